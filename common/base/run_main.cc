#include "common/base/run_main.h"

#include <CLI/CLI.hpp>
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
