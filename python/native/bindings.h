#pragma once

// The parts of the module powderkeg._native; python/powderkeg holds what users see of it. Every
// Error becomes a ValueError.

#include <pybind11/pybind11.h>

namespace powderkeg {

void BindGames(pybind11::module_& module);
void BindSamples(pybind11::module_& module);
void BindWeights(pybind11::module_& module);

}  // namespace powderkeg
