#pragma once

// One measured number.

#include <string>

namespace powderkeg {

struct BenchFigure {
  std::string name;  // dotted, for example "games.simple_unbiased"
  double value;
  std::string unit;  // for example "steps/s"
};

}  // namespace powderkeg
