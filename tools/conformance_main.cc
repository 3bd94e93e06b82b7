// conformance: replays what the official environment recorded and reports every difference.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/run_main.h"
#include "tools/official/recorded_decisions.h"
#include "tools/official/recorded_replay.h"

namespace powderkeg {
namespace {

struct Tally {
  int checked = 0;  // steps
  int skipped = 0;  // games of modes that are not built
  std::vector<std::string> differences;
  std::vector<std::string> skipped_modes;
};

void CheckGame(const RecordedGame& game, Tally& tally) {
  if (!game.Known()) {
    ++tally.skipped;
    if (std::ranges::find(tally.skipped_modes, game.mode) == tally.skipped_modes.end()) {
      tally.skipped_modes.push_back(game.mode);
    }
    return;
  }
  tally.checked += static_cast<int>(game.steps.size());
  for (std::string& difference : ReplayDifferences(game)) {
    tally.differences.push_back(std::move(difference));
  }
}

void Print(const std::string& file, const Tally& tally) {
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, tally.differences.size()); ++i) {
    std::cout << tally.differences[i] << '\n';
  }
  for (const std::string& mode : tally.skipped_modes) {
    std::cout << file << ": mode '" << mode << "' is not built, its games are skipped\n";
  }
  std::cout << file << ": " << tally.checked << " checked, " << tally.differences.size()
            << " differences, " << tally.skipped << " skipped\n";
}

int CheckGames(const std::vector<std::string>& files) {
  int code = kDone;
  for (const std::string& file : files) {
    Tally tally;
    int games = 0;
    RecordedGameReader reader(file);
    for (RecordedGame game; reader.Next(game); ++games) CheckGame(game, tally);
    if (games == 0) throw Error(StrCat(file, ": holds no game"));
    Print(file, tally);
    if (!tally.differences.empty()) code = kFailed;
  }
  return code;
}

int Main(int argc, char** argv) {
  CLI::App app("Replays what the official environment recorded and reports every difference.",
               "conformance");
  app.require_subcommand(1);
  std::vector<std::string> files;
  CLI::App* games = app.add_subcommand("games", "Recorded games: states, rewards, ends, views");
  games->add_option("files", files, ".jsonl or .jsonl.gz files")->required();
  std::string agent;
  CLI::App* decisions =
      app.add_subcommand("decisions", "Recorded decisions of an agent: their distributions");
  decisions->add_option("--agent", agent, "simple_unbiased or official_simple")->required();
  decisions->add_option("files", files, ".jsonl or .jsonl.gz files")->required();
  return RunMain(app, argc, argv, [&] {
    return games->parsed() ? CheckGames(files) : RunDecisionsCheck(agent, files);
  });
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) { return powderkeg::Main(argc, argv); }
