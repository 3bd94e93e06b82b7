#include "common/base/run_main.h"

#include <errno.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/check.h"
#include "common/base/nearest_name.h"

namespace powderkeg {
namespace {

// What the compiler was allowed to use (POWDERKEG_NATIVE) and this processor lacks, or null.
const char* MissingInstructions() {
#if defined(__x86_64__)
  __builtin_cpu_init();
// MACRO is 1 where the compiler uses them, and stands for itself elsewhere.
#define POWDERKEG_TEXT(text) #text
#define POWDERKEG_NEEDS(MACRO, name) \
  if (POWDERKEG_TEXT(MACRO)[0] == '1' && !__builtin_cpu_supports(name)) return name
  POWDERKEG_NEEDS(__SSE4_2__, "sse4.2");
  POWDERKEG_NEEDS(__POPCNT__, "popcnt");
  POWDERKEG_NEEDS(__AVX__, "avx");
  POWDERKEG_NEEDS(__AVX2__, "avx2");
  POWDERKEG_NEEDS(__FMA__, "fma");
  POWDERKEG_NEEDS(__BMI__, "bmi");
  POWDERKEG_NEEDS(__BMI2__, "bmi2");
  POWDERKEG_NEEDS(__AVX512F__, "avx512f");
  POWDERKEG_NEEDS(__AVX512BW__, "avx512bw");
  POWDERKEG_NEEDS(__AVX512DQ__, "avx512dq");
  POWDERKEG_NEEDS(__AVX512VL__, "avx512vl");
  POWDERKEG_NEEDS(__AVX512VBMI__, "avx512vbmi");
  POWDERKEG_NEEDS(__AVX512VNNI__, "avx512vnni");
  POWDERKEG_NEEDS(__AVX512VPOPCNTDQ__, "avx512vpopcntdq");
#undef POWDERKEG_NEEDS
#undef POWDERKEG_TEXT
#endif
  return nullptr;
}

// Before anything else of the program runs, which would end with SIGILL.
[[gnu::constructor(101)]] void RequireProcessor() {
  const char* missing = MissingInstructions();
  if (missing == nullptr) return;
  std::fprintf(stderr,
               "%s: this processor has no %s, expected one like that it was built on; build it "
               "here, or for any with -DPOWDERKEG_NATIVE=OFF\n",
               program_invocation_short_name, missing);
  std::_Exit(kFailed);
}

// Of the first argument that the program does not know.
std::string NearestOption(const CLI::App& app) {
  const std::vector<std::string> unknown = app.remaining();
  if (unknown.empty()) return "";
  std::vector<std::string> options;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  }
  const std::string_view given = unknown.front();
  return DidYouMean(given.substr(0, given.find('=')),
                    std::vector<std::string_view>(options.begin(), options.end()));
}

void AddWhatAllHave(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option == app.get_help_ptr()) continue;
    option->capture_default_str();
    if (option->get_default_str() == "[]") option->default_str("");
  }
  app.set_version_flag("--version", StrCat(app.get_name(), " ", Version()));
  app.failure_message([](const CLI::App* parsed, const CLI::Error& error) {
    return StrCat(parsed->get_name(), ": ", error.what(), "; see --help", NearestOption(*parsed),
                  "\n");
  });
}

}  // namespace

std::optional<int> ReadCommandLine(CLI::App& app, int argc, char** argv) {
  AddWhatAllHave(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kWrongUsage;
  }
  return std::nullopt;
}

int RunMain(CLI::App& app, int argc, char** argv, const std::function<int()>& run) {
  if (const std::optional<int> code = ReadCommandLine(app, argc, argv)) return *code;
  try {
    const int code = run();
    if (!std::flush(std::cout)) throw Error("cannot write standard output");
    return code;
  } catch (const std::bad_alloc&) {
    std::cerr << app.get_name() << ": there is not enough memory\n";
  } catch (const std::exception& error) {
    std::cerr << app.get_name() << ": " << error.what() << "\n";
  }
  return kFailed;
}

}  // namespace powderkeg
