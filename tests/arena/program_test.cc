// What the program says to wrong arguments and files: one line that names what was wrong.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "common/base/digest.h"
#include "common/model/planes.h"
#include "common/model/weights_snapshot.h"
#include "tests/pommerman/board_reader.h"

namespace powderkeg {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Finished {
  std::string output;  // of stderr, or of both
  int status = 0;
};

// Runs the shell command to its end.
Finished RunCommand(const std::string& command) {
  Finished run;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {"popen failed", -1};
  std::array<char, 4096> buffer;
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) run.output += buffer.data();
  run.status = WEXITSTATUS(pclose(pipe));
  return run;
}

std::string Arena(const std::string& arguments) {
  return std::string(ARENA_PROGRAM) + " " + arguments;
}

class ArenaProgram : public testing::Test {
 protected:
  ArenaProgram() : folder_(std::filesystem::path(testing::TempDir()) / "arena_program_test") {
    std::filesystem::create_directories(folder_);
  }
  ~ArenaProgram() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string PathOf(const std::string& name) const {
    return (folder_ / name).string();
  }
  [[nodiscard]] std::string TextOf(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }

  // Expects that the program refuses the arguments with one line that holds the text, after the
  // lines of progress of a match that had begun.
  static void ExpectRefused(const std::string& arguments, const std::string& text,
                            int progress_lines = 0) {
    const Finished run = RunCommand(Arena(arguments) + " 2>&1 >/dev/null");
    EXPECT_THAT(run.status, AnyOf(1, 2)) << arguments;
    EXPECT_EQ(std::ranges::count(run.output, '\n'), 1 + progress_lines) << run.output;
    EXPECT_THAT(
        run.output,
        AllOf(progress_lines > 0 ? HasSubstr("\narena: ") : HasSubstr("arena: "), HasSubstr(text)))
        << arguments;
  }

  std::filesystem::path folder_;
};

NetworkDescription TinyNetwork() {
  NetworkDescription network;
  network.stem_channels = 1;
  network.blocks = {{BlockDescription::Kind::kResidual, 1, 1, 1}};
  network.value_hidden = 1;
  network.policy_channels = 1;
  return network;
}

TEST_F(ArenaProgram, RefusesUnknownAgentsAndOptions) {
  ExpectRefused("--agent nobody", "unknown agent nobody: known: idle, random");
  ExpectRefused("--agent random:x=1", "agent random: options \"x=1\": it has none");
  ExpectRefused("--agent search:depth=3",
                "there is no setting search:depth; --help-options lists all");
  ExpectRefused("--agent search:depth", "expected OPTION=VALUE");
  ExpectRefused("--agent search:tree=three_player",
                "search:tree is three_player; expected one of one_player");
  ExpectRefused("--agent random --opponents idle nobody", "unknown agent nobody");
  ExpectRefused("--agent raw", "no model: expected raw:model=MODEL");
  ExpectRefused("", "--agent is required");
  ExpectRefused("--agent random --depth 3", "--depth");
}

TEST_F(ArenaProgram, RefusesImpossibleNumbers) {
  ExpectRefused("--agent search:simulations=0",
                "search:simulations is 0; expected a whole number from 1 to 1000000");
  ExpectRefused("--agent search:simulations=-5", "search:simulations is -5; expected");
  ExpectRefused("--agent search:simulations=many", "search:simulations is many; expected");
  ExpectRefused("--agent random --games 0", "--games");
  ExpectRefused("--agent random --games soon", "--games");
  ExpectRefused("--agent random --threads 0", "--threads");
  ExpectRefused("--agent random --min-games 0", "--min-games");
}

TEST_F(ArenaProgram, RefusesGamesThatDoNotExist) {
  ExpectRefused("--agent random --environment Chess-v0", "environment \"Chess-v0\": expected one");
  ExpectRefused("--agent random --board round", "--board");
  ExpectRefused("--agent random --mate random",
                "--mate random: PommeFFACompetition-v0 has no mate");
  ExpectRefused("--agent random --sprt win_rate=2..3",
                "question \"win_rate=2..3\": expected win_rate=LOW..HIGH");
  ExpectRefused("--agent random --sprt score_difference=0..0.1", "1 agents to measure, expected 2");
}

TEST_F(ArenaProgram, KnowsModelsByNameWhereverItIsStarted) {
  const Finished run = RunCommand("cd " + folder_.string() + " && " +
                                  Arena("--agent raw:model=ffa --games 1 2>/dev/null"));
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.output, StartsWith("raw:model=ffa\n  1 games"));
  ExpectRefused("--agent raw:model=fa", "there is no model \"fa\"; in ");
  ExpectRefused("--agent raw:model=untrained:small:x", "the seed is \"x\"");
}

TEST_F(ArenaProgram, RefusesWeightsThatItCannotUse) {
  const std::string path = PathOf("a.weights");
  const std::string agent = "--games 1 --agent raw:model=" + path;
  ExpectRefused(agent, "cannot open " + path);
  std::ofstream(path) << "not a network";
  ExpectRefused(agent, path + ": weights: ");
  SaveSnapshot(InitialWeights(TinyNetwork(), Rng(1)), path);
  const std::string whole = TextOf("a.weights");
  std::ofstream(path, std::ios::binary) << whole.substr(0, whole.size() / 2);
  ExpectRefused(agent, path + ": weights: ");
  ExpectRefused(agent + " --evaluator none", path);
}

// A network of another program: its description, which says how many planes it looks at, does not
// fit.
TEST_F(ArenaProgram, RefusesANetworkForOtherPlanes) {
  std::vector<std::uint8_t> bytes = Serialize(InitialWeights(TinyNetwork(), Rng(1)));
  constexpr std::ptrdiff_t kChecksum = 12;  // weights_format.cc
  constexpr std::ptrdiff_t kChecksummed = 16;
  const auto planes = std::find(bytes.begin() + kChecksummed, bytes.end(), kPlaneCount);
  ASSERT_NE(planes, bytes.end());
  --*planes;
  const std::uint32_t checksum = Crc32c(std::span(bytes).subspan(kChecksummed));
  std::memcpy(bytes.data() + kChecksum, &checksum, sizeof(checksum));
  std::ofstream(PathOf("other.weights"), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  ExpectRefused("--games 1 --agent raw:model=" + PathOf("other.weights"),
                "other.weights: network description: planes is 22, expected 23");
}

// Finite weights that no number can hold the answers of.
TEST_F(ArenaProgram, StopsWithThePositionWhereANetworkAnswersNoNumber) {
  WeightsSnapshot weights = InitialWeights(TinyNetwork(), Rng(1));
  for (NamedArray& array : weights.arrays) {
    if (array.name.ends_with("fc1.weight") || array.name.ends_with("conv.weight")) {
      std::ranges::fill(array.values, 1e38F);
    }
    if (array.name.ends_with("fc2.weight") || array.name.ends_with("fc.weight")) {
      float sign = 1;
      for (float& value : array.values) value = (sign = -sign) * 1e38F;
    }
  }
  SaveSnapshot(weights, PathOf("huge.weights"));
  const std::string agent = "raw:model=" + PathOf("huge.weights");
  const std::string position = PathOf("position.txt");
  ExpectRefused("--precision fp32 --games 50 --agent " + agent + " --position-file " + position,
                "agent " + agent + ": evaluator ", /*progress_lines=*/1);
  const State state = FromText(TextOf("position.txt"));
  EXPECT_GT(state.AgentCells().Count(), 1);
}

TEST_F(ArenaProgram, RefusesFilesThatItCannotWrite) {
  ExpectRefused("--agent random --opponents idle --games 1 --json /absent/result.json",
                "cannot write \"/absent/result.json\"", /*progress_lines=*/2);
}

TEST_F(ArenaProgram, PlaysComparesAndWritesEverything) {
  const Finished run = RunCommand(
      Arena("--agent simple_unbiased --agent random --games 400 --sprt score_difference=-0.1..0 "
            "--min-games 20 --json " +
            PathOf("r.json") + " --table " + PathOf("r.csv") + " --csv " + PathOf("g.csv") +
            " 2>/dev/null"));
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.output, HasSubstr("question score_difference=-0.1..0: -0.1 after "));
  EXPECT_THAT(run.output, HasSubstr("against the first, board by board"));
  EXPECT_THAT(TextOf("r.json"), HasSubstr("\"answer\": \"-0.1\""));
  EXPECT_THAT(TextOf("r.csv"), StartsWith("number,series,"));
  EXPECT_THAT(TextOf("g.csv"), StartsWith("agent,game,"));
}

TEST_F(ArenaProgram, WritesATableThatCanBeDrawn) {
  if (RunCommand("gnuplot --version 2>&1").status != 0) GTEST_SKIP() << "gnuplot is not installed";
  const std::string table = PathOf("table.csv");
  const Finished arena = RunCommand(
      Arena("--agent search:simulations=2 --agent search:simulations=4 --agent random --games 2 "
            "--table " +
            table + " 2>&1"));
  ASSERT_EQ(arena.status, 0) << arena.output;
  const Finished plot = RunCommand("deploy/plot-arena " + table + " 2>&1");
  EXPECT_EQ(plot.status, 0) << plot.output;
  for (const char* name : {"table-win-rate.svg", "table-actions.svg", "table-board.svg"}) {
    EXPECT_THAT(TextOf(name), AllOf(HasSubstr("<svg"), HasSubstr("</svg>"))) << name;
  }
  EXPECT_NE(RunCommand("deploy/plot-arena README.md 2>&1").status, 0);
}

TEST_F(ArenaProgram, MeasuresAnAgentWithEachOfSeveralModels) {
  const Finished run = RunCommand(
      Arena("--agent search:simulations=4 --models untrained:small:1 untrained:small:2 --games 4 "
            "--json " +
            PathOf("r.json") + " 2>/dev/null"));
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.output, HasSubstr("search:simulations=4,model=untrained:small:2\n"));
  EXPECT_THAT(run.output,
              ContainsRegex("search:simulations=4, mean .*between 2 models\n  win .*of 8 games"));
  EXPECT_THAT(TextOf("r.json"), HasSubstr("\"settings\": \"search:simulations=4\""));
  ExpectRefused("--agent raw:model=ffa --models untrained:small",
                "--agent raw:model=ffa names a model beside --models; expected none");
  ExpectRefused("--agent raw --models untrained:small nosuch", "there is no model \"nosuch\"");
  ExpectRefused("--agent random --models ffa", "agent random: options \"model=ffa\": it has none");
}

TEST_F(ArenaProgram, PlaysWithAMateOfAnotherKind) {
  const Finished run = RunCommand(
      Arena("--agent random --mate simple_unbiased --opponents idle --games 2 --environment "
            "PommeTeamCompetition-v0 2>/dev/null"));
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.output, HasSubstr("against idle, with mate simple_unbiased"));
}

TEST_F(ArenaProgram, ExplainsItselfWithExamples) {
  const Finished run = RunCommand(Arena("--help"));
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.output, AllOf(HasSubstr("Examples:"), HasSubstr("--sprt score_difference=0..")));
}

}  // namespace
}  // namespace powderkeg
