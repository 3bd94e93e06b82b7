#include <exception>

#include "common/base/check.h"
#include "python/native/bindings.h"

PYBIND11_MODULE(_native, module) {
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const powderkeg::Error& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });
  powderkeg::BindGames(module);
  powderkeg::BindSamples(module);
  powderkeg::BindWeights(module);
}
