#pragma once

// The frame of a main.

#include <exception>
#include <iostream>
#include <new>
#include <stdexcept>
#include <string_view>

namespace powderkeg {

// Calls run() and returns the program's exit code: an Error, or what the library throws where
// files, descriptors or memory fail, or standard output could not be written, becomes one line on
// standard error, "name: what is wrong", and the code 1.
template <typename Function>
[[nodiscard]] int RunMain(std::string_view name, const Function& run) {
  try {
    run();
    if (!std::flush(std::cout)) throw std::runtime_error("cannot write standard output");
  } catch (const std::bad_alloc&) {
    std::cerr << name << ": there is not enough memory\n";
    return 1;
  } catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << "\n";
    return 1;
  }
  return 0;
}

}  // namespace powderkeg
