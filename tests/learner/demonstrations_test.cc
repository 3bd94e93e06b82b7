#include "learner/replay/demonstrations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/pommerman/belief.h"
#include "common/recorded/json_lines.h"
#include "common/recorded/recorded_game.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::StartsWith;

constexpr char kFreeForAll[] = "PommeFFACompetition-v0";

fs::path DataFile(const std::string& name) { return "tests/data/" + name + ".jsonl.gz"; }

std::vector<Lessons> Read(const std::vector<fs::path>& files,
                          const std::string& environment = kFreeForAll) {
  std::vector<Lessons> games;
  ReadDemonstrations(files, environment,
                     [&](Lessons&& lessons) { games.push_back(std::move(lessons)); });
  return games;
}

std::string ErrorOf(const fs::path& file, const std::string& environment = kFreeForAll) {
  try {
    (void)Read({file}, environment);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::vector<std::string> LinesOf(const fs::path& file) {
  LineReader reader(file.string());
  std::vector<std::string> lines;
  for (std::string line; reader.Next(line);) lines.push_back(line + "\n");
  return lines;
}

// A file of a few lines, for a test.
class DemonstrationFiles : public testing::Test {
 protected:
  fs::path Write(const std::string& text) const {
    const fs::path file = folder_.path() / "games.jsonl";
    std::ofstream(file) << text;
    return file;
  }
  fs::path WriteLines(std::span<const std::string> lines) const {
    return Write(std::accumulate(lines.begin(), lines.end(), std::string()));
  }

  const TemporaryFolder folder_;
};

struct File {
  const char* name;
  const char* environment;
};

class Demonstrations : public testing::TestWithParam<File> {};
INSTANTIATE_TEST_SUITE_P(Official, Demonstrations,
                         testing::Values(File{"ffa", kFreeForAll},
                                         File{"team", "PommeTeamCompetition-v0"},
                                         File{"radio", "PommeRadioCompetition-v2"},
                                         File{"one_vs_one", "OneVsOne-v0"}),
                         [](const auto& file) { return std::string(file.param.name); });

// Every move of everybody, as its own belief held the position before it.
TEST_P(Demonstrations, OfRecordedGamesEverybodyTeachesWhatItDid) {
  const auto& [name, environment] = GetParam();
  const std::vector<Lessons> games = Read({DataFile(name)}, environment);
  RecordedGameReader reader(DataFile(name).string());
  std::size_t number = 0;
  for (RecordedGame game; reader.Next(game);) {
    if (game.settings != GameSettingsFor(environment)) continue;
    ASSERT_LT(number, games.size());
    EXPECT_EQ(games[number].ticket, number);
    EXPECT_EQ(games[number].play.games, 1u);
    EXPECT_FALSE(games[number].result) << "nobody of the run played";
    std::array<std::optional<Belief>, kAgentCount> beliefs;
    auto sample = games[number].samples.begin();
    State state = game.start;
    for (const RecordedStep& step : game.steps) {
      for (AgentId agent = 0; agent < kAgentCount; ++agent) {
        if (!state.agents[agent].alive) continue;
        if (!beliefs[agent]) beliefs[agent].emplace(game.settings);
        beliefs[agent]->Observe(Observe(game.settings, state, agent));
        ASSERT_NE(sample, games[number].samples.end());
        EXPECT_EQ(sample->viewer, agent);
        EXPECT_EQ(sample->state, beliefs[agent]->state());
        EXPECT_EQ(sample->visits[static_cast<std::size_t>(step.actions[agent])], 1);
        EXPECT_EQ(std::accumulate(sample->visits.begin(), sample->visits.end(), 0), 1);
        EXPECT_FALSE(sample->searched);
        EXPECT_EQ(sample->end_step, game.start.step + game.steps.size());
        if (game.result == Result::kWin) {
          EXPECT_EQ(sample->outcome, (game.winners >> agent & 1) != 0 ? 1 : -1);
        }
        ++sample;
      }
      state = step.state;
    }
    EXPECT_EQ(sample, games[number].samples.end());
    ++number;
  }
  EXPECT_EQ(number, games.size());
}

TEST_F(DemonstrationFiles, SeveralFilesFollowEachOther) {
  const std::vector<std::string> lines = LinesOf(DataFile("ffa"));
  const auto end = std::ranges::find_if(
      lines, [](const std::string& line) { return line.starts_with(R"({"t":"end")"); });
  const fs::path first = WriteLines({lines.begin(), end + 1});
  const std::vector<Lessons> games = Read({first, DataFile("ffa"), first});
  ASSERT_EQ(games.size(), 108u) << "without those of other rules";
  for (std::size_t i = 0; i < games.size(); ++i) EXPECT_EQ(games[i].ticket, i);
  EXPECT_EQ(games.back().samples.size(), games.front().samples.size());
}

// How it would have ended is known of those alone that had died.
TEST(Demonstrations, OfAGameThatWasCutOffTheDeadTeach) {
  RecordedGameReader reader(DataFile("corner").string());
  std::size_t of_the_dead = 0;
  for (RecordedGame game; reader.Next(game);) {
    if (game.result != Result::kIncomplete) continue;
    const auto made = MakeLessons(game, 0);
    ASSERT_TRUE(std::holds_alternative<Lessons>(made)) << game.id << std::get<1>(made);
    for (const Sample& sample : std::get<Lessons>(made).samples) {
      EXPECT_FALSE(game.steps.back().state.agents[sample.viewer].alive) << game.id;
      EXPECT_EQ(sample.outcome, -1);
      ++of_the_dead;
    }
  }
  EXPECT_GT(of_the_dead, 20u);
}

TEST_F(DemonstrationFiles, GamesOfOtherRulesAreRefused) {
  EXPECT_EQ(
      ErrorOf(DataFile("team")),
      "demonstrations: tests/data/team.jsonl.gz: nothing to learn from: public-team-0000 is of "
      "PommeTeamCompetition-v0 (team, 800 steps, blast cap 4, view 4, collapses 0 0 0 0); "
      "expected games of PommeFFACompetition-v0 (self_play.environment), recorded as replay "
      "--export does");
  const fs::path strange = Write(R"({"t":"game","v":1,"id":"x","env":"y","mode":"chess"})"
                                 "\n"
                                 R"({"t":"end"})"
                                 "\n");
  EXPECT_THAT(ErrorOf(strange), HasSubstr("x is of chess; expected games of"));
}

TEST_F(DemonstrationFiles, AGameThatDoesNotFollowTheRulesIsRefused) {
  std::vector<std::string> lines = LinesOf(DataFile("ffa"));
  const std::string whole = lines[5];
  ASSERT_THAT(whole, StartsWith(R"({"t":"step","a":[)"));
  const std::string::size_type action = whole.find('[') + 1;
  std::size_t refused = 0;
  for (const char other : {'1', '2', '3', '4', '5'}) {
    lines[5][action] = other;
    const std::string error = ErrorOf(WriteLines(lines));
    if (error == "no error") continue;  // as good a way to the same position
    EXPECT_THAT(error, HasSubstr("public-ffa-0000: step 5: its position does not follow"));
    ++refused;
  }
  EXPECT_GT(refused, 2u);
  lines[5] = whole;
  const auto end = std::ranges::find_if(
      lines, [](const std::string& line) { return line.starts_with(R"({"t":"end")"); });
  const std::size_t steps = static_cast<std::size_t>(end - lines.begin()) - 1;
  *end = StrCat(R"({"t":"end","result":"Tie","winners":null,"steps":)", steps, "}\n");
  EXPECT_THAT(ErrorOf(WriteLines(lines)), HasSubstr("the result does not follow"));
}

TEST_F(DemonstrationFiles, WhatIsTruncatedOrNoSuchFileIsRefused) {
  std::ifstream whole(DataFile("ffa"), std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(whole), {});
  bytes.resize(bytes.size() / 2);
  EXPECT_THAT(ErrorOf(Write(bytes)), HasSubstr("unexpected end of file; expected games of"));
  const std::vector<std::string> lines = LinesOf(DataFile("ffa"));
  EXPECT_THAT(ErrorOf(WriteLines(std::span(lines).first(9))),
              HasSubstr("games.jsonl:9: the file ends within a game; expected games of"));
  EXPECT_THAT(ErrorOf(Write("")), HasSubstr("games.jsonl: nothing to learn from; expected"));
  EXPECT_THAT(ErrorOf(Write("no games at all\n")), HasSubstr(":1: not a JSON object; expected"));
  EXPECT_THAT(ErrorOf(DataFile("start_boards")), HasSubstr(":1: no field \"t\"; expected games"));
  EXPECT_THAT(ErrorOf(folder_.path() / "nothing"), HasSubstr("cannot open"));
  EXPECT_THAT(ErrorOf(folder_.path()), HasSubstr("cannot read"));
}

}  // namespace
}  // namespace powderkeg
