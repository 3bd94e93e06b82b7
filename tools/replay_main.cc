// replay: shows stored games step by step in the terminal, or exports them as text.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>

#include "common/base/check.h"
#include "common/base/run_main.h"
#include "tools/official/recorded_export.h"
#include "tools/viewer/game_source.h"
#include "tools/viewer/viewer.h"

namespace powderkeg {
namespace {

struct Arguments {
  std::string file;
  int game = -1;  // -1: the first to show, all to export
  int step = -1;  // -1: all
  int delay_ms = 200;
  std::string export_file;
};

// The chosen game. Throws Error if the file has fewer.
StoredGame Find(const Arguments& arguments) {
  const GameSource next = OpenGames(arguments.file);
  const int wanted = std::max(arguments.game, 0);
  StoredGame stored;
  for (int number = 0; next(stored); ++number) {
    if (number < wanted) continue;
    if (stored.game.Known() || !stored.game.steps.empty()) return stored;
    throw Error(StrCat(stored.game.id, ": games of mode \"", stored.game.mode, "\" are not shown"));
  }
  throw Error(StrCat("game ", wanted, ": not in ", arguments.file, ", which has fewer games"));
}

int Show(const Arguments& arguments) {
  const bool terminal = isatty(STDOUT_FILENO) != 0;
  const Colours colours = terminal ? Colours::kAnsi : Colours::kNone;
  const StoredGame stored = Find(arguments);
  const int last = static_cast<int>(stored.game.steps.size());
  if (arguments.step > last) {
    throw Error(StrCat("step ", arguments.step, ": expected 0..", last));
  }
  if (arguments.step >= 0) {
    std::cout << RenderStep(stored, arguments.step, colours);
    return kDone;
  }
  constexpr std::string_view kClearScreen = "\033[H\033[2J";
  for (int step = 0; step <= last; ++step) {
    std::cout << (terminal ? kClearScreen : "") << RenderStep(stored, step, colours)
              << (terminal ? "" : "\n") << std::flush;
    if (terminal && step < last) {
      std::this_thread::sleep_for(std::chrono::milliseconds(arguments.delay_ms));
    }
  }
  return kDone;
}

int Export(const Arguments& arguments) {
  std::ofstream output(arguments.export_file);
  int games = 0;
  if (arguments.game >= 0) {
    output << RecordedLines(Find(arguments).game);
    ++games;
  } else {
    const GameSource next = OpenGames(arguments.file);
    for (StoredGame stored; next(stored); ++games) output << RecordedLines(stored.game);
  }
  if (!output.flush()) throw Error(StrCat("cannot write ", arguments.export_file));
  std::cout << arguments.export_file << ": " << games << " games\n";
  return kDone;
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  app.add_option("file", arguments.file,
                 "recorded games (.jsonl, .jsonl.gz) or a segment of a run (replay/segment-*.h5)")
      ->required();
  app.add_option("--game", arguments.game, "number of the game in the file, from 0")
      ->check(CLI::Range(0, 1'000'000'000));
  app.add_option("--step", arguments.step, "show only the position after so many steps")
      ->check(CLI::Range(0, 1'000'000));
  app.add_option("--delay-ms", arguments.delay_ms, "between two steps on a terminal")
      ->check(CLI::Range(0, 60'000));
  app.add_option("--export", arguments.export_file,
                 "write the game (without --game: all games) in the recorded format instead");
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  CLI::App app("Shows stored games step by step, or exports them as text.", "replay");
  powderkeg::Arguments arguments;
  powderkeg::AddOptions(app, arguments);
  return powderkeg::RunMain(app, argc, argv, [&] {
    return arguments.export_file.empty() ? powderkeg::Show(arguments)
                                         : powderkeg::Export(arguments);
  });
}
