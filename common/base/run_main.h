#pragma once

// The frame of a main: what all programs do alike. One that was compiled for another processor ends
// with one line before its main.

#include <functional>
#include <optional>

namespace CLI {
class App;
}

namespace powderkeg {

// Exit codes.
inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;      // or what was checked is wrong
inline constexpr int kWrongUsage = 2;  // of the command line

// "0.1.0 (GIT DESCRIPTION)", of what was built.
[[nodiscard]] const char* Version();

// Reads the command line into the options of `app`, which has a name; to those come --version, and
// the defaults in --help. Returns the exit code if that was all: help was asked for, or the command
// line is wrong, which one line on standard error says.
[[nodiscard]] std::optional<int> ReadCommandLine(CLI::App& app, int argc, char** argv);

// The same, and then run(), which returns the exit code. An Error, or what the library throws where
// files, descriptors or memory fail, or that standard output cannot be written, becomes one line on
// standard error, "name: what is wrong", and kFailed.
[[nodiscard]] int RunMain(CLI::App& app, int argc, char** argv, const std::function<int()>& run);

}  // namespace powderkeg
