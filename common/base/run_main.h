#pragma once

// The frame of a main.

#include <iostream>
#include <string_view>

#include "common/base/check.h"

namespace powderkeg {

// Calls run() and returns the program's exit code: an Error becomes one line on standard error,
// "name: what is wrong", and the code 1.
template <typename Function>
[[nodiscard]] int RunMain(std::string_view name, const Function& run) {
  try {
    run();
  } catch (const Error& error) {
    std::cerr << name << ": " << error.what() << "\n";
    return 1;
  }
  return 0;
}

}  // namespace powderkeg
