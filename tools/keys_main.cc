// keys: makes the key files that learner and actors know each other by.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "common/base/name.h"
#include "common/base/run_main.h"
#include "common/wire/keys.h"

namespace powderkeg {
namespace {

// A pair that exists is kept: peers know it.
void MakePair(const std::filesystem::path& file) {
  if (std::filesystem::exists(file.string() + ".secret")) return;
  WriteKeyPair(MakeKeyPair(), file);
  std::cout << "made " << file.string() << ".secret and .public\n";
}

int MakeKeys(const std::filesystem::path& folder, const std::vector<std::string>& actors) {
  for (const std::string& name : actors) RequireName("an actor's name", name);
  MakePair(folder / "learner");
  for (const std::string& name : actors) MakePair(folder / "actors" / name);
  return kDone;
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  std::string folder;
  std::vector<std::string> actors;
  CLI::App app(
      "Makes a key pair for the learner and one for each actor, those that do not exist yet. A "
      "machine with actors needs learner.public and the actors' own files.",
      "keys");
  app.add_option("folder", folder, "where the keys are")->required();
  app.add_option("actors", actors, "names of actors");
  return powderkeg::RunMain(app, argc, argv, [&] { return powderkeg::MakeKeys(folder, actors); });
}
