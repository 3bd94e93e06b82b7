// The official environment's own games, played again.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/pommerman/game_settings.h"
#include "common/recorded/json_lines.h"
#include "tools/official/recorded_replay.h"

namespace powderkeg {
namespace {

std::string PathOf(const std::string& name) { return "tests/data/" + name + ".jsonl.gz"; }

// Calls `visit` for every game of a file.
template <typename Visit>
void ForEachGame(const std::string& name, Visit&& visit) {
  RecordedGameReader reader(PathOf(name));
  for (RecordedGame game; reader.Next(game);) visit(game);
}

struct File {
  const char* name;
  int games;
  int steps;
};

class RecordedGames : public testing::TestWithParam<File> {};

TEST_P(RecordedGames, ReplayWithoutDifference) {
  int games = 0;
  int steps = 0;
  ForEachGame(GetParam().name, [&](const RecordedGame& game) {
    ASSERT_TRUE(game.Known());
    EXPECT_THAT(ReplayDifferences(game), testing::IsEmpty());
    EXPECT_EQ(GameSettingsFor(game.environment), game.settings) << game.environment;
    ++games;
    steps += static_cast<int>(game.steps.size());
  });
  EXPECT_EQ(games, GetParam().games);
  EXPECT_EQ(steps, GetParam().steps);
}

INSTANTIATE_TEST_SUITE_P(AllFiles, RecordedGames,
                         testing::Values(File{"ffa", 120, 21141}, File{"corner", 80, 1044},
                                         File{"fuzz", 538, 5500}, File{"team", 60, 8446},
                                         File{"radio", 30, 4147}, File{"one_vs_one", 40, 1816}),
                         [](const auto& file) { return std::string(file.param.name); });

// ---- The format ----

RecordedGame FirstGame(const std::string& name) {
  RecordedGame game;
  RecordedGameReader(PathOf(name)).Next(game);
  return game;
}

TEST(RecordedFormat, ReplayFindsEveryKindOfDifference) {
  const RecordedGame good = FirstGame("radio");
  const auto differs = [&](auto&& change) {
    RecordedGame game = good;
    change(game);
    return ReplayDifferences(game).size();
  };
  EXPECT_EQ(differs([](RecordedGame&) {}), 0u);
  EXPECT_EQ(differs([](RecordedGame& game) { game.steps[3].rewards[2] = 1; }), 1u);
  EXPECT_EQ(differs([](RecordedGame& game) { game.steps[3].done = true; }), 1u);
  EXPECT_EQ(differs([](RecordedGame& game) { game.result = Result::kIncomplete; }), 1u);
  EXPECT_EQ(differs([](RecordedGame& game) { game.winners ^= 1; }), 1u);
  EXPECT_EQ(differs([](RecordedGame& game) { game.steps.back().state.agents[0].ammo ^= 1; }), 1u);
  EXPECT_EQ(differs([](RecordedGame& game) {
              game.steps.back().state.wood.Remove(game.steps.back().state.wood.First());
            }),
            1u);
  EXPECT_EQ(differs([](RecordedGame& game) { (*game.observations)[1].team_mate = {}; }), 1u);
  EXPECT_EQ(differs([](RecordedGame& game) { (*game.observations)[1].observation.ammo = 9; }), 1u);
  EXPECT_EQ(differs([](RecordedGame& game) {
              (*game.steps[4].observations)[0].observation.message = {9, 9};
            }),
            1u);
}

TEST(RecordedFormat, SkipsGamesOfOtherModes) {
  std::istringstream lines(R"({"t":"game","v":1,"id":"x","mode":"chess"})"
                           "\n"
                           R"({"t":"step"})"
                           "\n"
                           R"({"t":"end"})"
                           "\n");
  RecordedGameReader reader(
      "memory", [&](std::string& line) { return static_cast<bool>(std::getline(lines, line)); });
  RecordedGame game;
  ASSERT_TRUE(reader.Next(game));
  EXPECT_FALSE(game.Known());
  EXPECT_EQ(game.mode, "chess");
  EXPECT_FALSE(reader.Next(game));
}

// The lines of the first recorded game.
std::vector<std::string> FirstLines(int count) {
  LineReader reader(PathOf("corner"));
  std::vector<std::string> lines(static_cast<std::size_t>(count));
  for (std::string& line : lines) EXPECT_TRUE(reader.Next(line));
  return lines;
}

// The message that reading these lines ends with.
std::string ErrorOf(const std::vector<std::string>& lines) {
  std::size_t next = 0;
  RecordedGameReader reader("memory", [&](std::string& line) {
    if (next == lines.size()) return false;
    line = lines[next++];
    return true;
  });
  try {
    for (RecordedGame game; reader.Next(game);) {
    }
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(RecordedFormat, SaysWhereAndWhatIsWrong) {
  using testing::HasSubstr;
  using testing::StartsWith;
  const std::vector<std::string> lines = FirstLines(2);
  const auto error_of_header = [&](const std::string& from, const std::string& to) {
    return ErrorOf({Replaced(lines[0], from, to)});
  };
  EXPECT_THAT(ErrorOf({"{"}), StartsWith("memory:1: not a JSON object"));
  EXPECT_THAT(ErrorOf({""}), HasSubstr("not a JSON object"));
  EXPECT_THAT(ErrorOf({"[]"}), HasSubstr("no field \"t\""));
  EXPECT_THAT(ErrorOf({lines[1]}), HasSubstr("expected the header of a game"));
  EXPECT_THAT(ErrorOf(lines), StartsWith("memory:2: the file ends within a game"));
  EXPECT_THAT(ErrorOf({lines[0], lines[0]}), HasSubstr("unexpected line of kind 'game'"));
  EXPECT_THAT(error_of_header(R"("v":1)", R"("v":2)"), HasSubstr("version is not 1"));
  EXPECT_THAT(error_of_header(R"("b":"00)", R"("b":"0)"), HasSubstr("board of 120 cells"));
  EXPECT_THAT(error_of_header(R"("b":"0)", R"("b":"!)"), HasSubstr("a cell '!'"));
  EXPECT_THAT(error_of_header(R"("b":"0)", R"("b":"z)"), HasSubstr("no cell has the value 35"));
  EXPECT_THAT(error_of_header(R"("b":"0)", R"("b":"3)"), HasSubstr("disagree at (0,0)"));
  EXPECT_THAT(error_of_header(R"("ag":[[3,)", R"("ag":[[11,)"), HasSubstr("from 0 to 10"));
  EXPECT_THAT(error_of_header(R"("ag":[[3,)", R"("ag":[[3.5,)"), HasSubstr("no whole number"));
  EXPECT_THAT(error_of_header(R"("max_steps":800)", R"("max_steps":"x")"),
              HasSubstr("no whole number"));
  EXPECT_THAT(error_of_header(R"("it":[)", R"("it":[[0,0,6],)"), HasSubstr("lies open"));
  EXPECT_THAT(ErrorOf({lines[0], Replaced(lines[1], R"("a":[)", R"("a":[7,)")}),
              HasSubstr("memory:2: "));
  EXPECT_THAT(ErrorOf({lines[0], R"({"t":"end","result":"Draw","winners":null,"steps":0})"}),
              HasSubstr("unknown result 'Draw'"));
  EXPECT_THAT(ErrorOf({lines[0], R"({"t":"end","result":"Tie","winners":null,"steps":3})"}),
              HasSubstr("the game has 0 steps"));
}

TEST(RecordedFormat, FilesThatAreNotThereAreErrors) {
  EXPECT_THROW(RecordedGameReader("tests/data/nothing.jsonl"), Error);
}

// ---- Settings ----

TEST(GameSettings, KnowTheOfficialEnvironments) {
  for (const char* id : {"PommeFFACompetition-v0", "PommeFFACompetitionFast-v0", "PommeFFAFast-v0",
                         "PommeFFA-v1", "PommeTeamCompetition-v0", "PommeTeamCompetitionFast-v0",
                         "PommeTeamCompetition-v1", "PommeTeam-v0", "PommeTeamFast-v0",
                         "PommeRadio-v2", "PommeRadioCompetition-v2", "OneVsOne-v0"}) {
    EXPECT_TRUE(GameSettingsFor(id).has_value()) << id;
    EXPECT_THAT(KnownEnvironmentIds(), testing::HasSubstr(id));
  }
  EXPECT_EQ(GameSettingsFor("PommeFFACompetition-v0"), GameSettings{});
  EXPECT_EQ(GameSettingsFor("PommeFFA-v1")->collapse_steps[3], 725);
  EXPECT_EQ(GameSettingsFor("PommeTeam-v0")->blast_strength_cap, 10);
  EXPECT_EQ(GameSettingsFor("PommeRadio-v2")->blast_strength_cap, 4);
  EXPECT_EQ(GameSettingsFor("OneVsOne-v0")->board_size, 8);
  EXPECT_EQ(GameSettingsFor("Pomme"), std::nullopt);
}

TEST(GameSettings, TeamsAreDiagonal) {
  EXPECT_EQ(TeamMateOf(Mode::kTeam, 3), 1);
  EXPECT_EQ(TeamMateOf(Mode::kFreeForAll, 3), -1);
  EXPECT_TRUE(AreEnemies(Mode::kTeamRadio, 0, 1));
  EXPECT_FALSE(AreEnemies(Mode::kTeamRadio, 0, 2));
  EXPECT_TRUE(AreEnemies(Mode::kFreeForAll, 0, 2));
  EXPECT_FALSE(AreEnemies(Mode::kFreeForAll, 2, 2));
}

}  // namespace
}  // namespace powderkeg
