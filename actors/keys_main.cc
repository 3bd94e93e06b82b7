// keys: makes the key files that learner and actors know each other by.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "actors/run_main.h"
#include "common/wire/keys.h"

namespace powderkeg {
namespace {

void MakeKeys(const std::filesystem::path& folder, const std::vector<std::string>& actors) {
  if (!std::filesystem::exists(folder / "learner.secret")) {
    WriteKeyPair(MakeKeyPair(), folder / "learner");
    std::cout << "made " << (folder / "learner.secret").string() << " and .public\n";
  }
  for (const std::string& name : actors) {
    WriteKeyPair(MakeKeyPair(), folder / "actors" / name);
    std::cout << "made " << (folder / "actors" / name).string() << ".secret and .public\n";
  }
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  std::string folder;
  std::vector<std::string> actors;
  CLI::App app(
      "Makes the learner's key pair, unless it exists, and one for each actor. A machine "
      "with actors needs learner.public and the actors' own files.");
  app.add_option("folder", folder, "where the keys are")->required();
  app.add_option("actors", actors, "names of actors");
  CLI11_PARSE(app, argc, argv);
  return powderkeg::RunMain("keys", [&] { powderkeg::MakeKeys(folder, actors); });
}
