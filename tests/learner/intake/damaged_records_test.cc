// Records of every kind, and the segments that hold them, with a byte changed here or there: what
// is not what it was is refused with a reason or is another game that could have been played;
// nothing crashes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <variant>
#include <vector>

#include "common/base/check.h"
#include "common/segment/segment_file.h"
#include "common/wire/codec.h"
#include "learner/intake/plausible.h"
#include "learner/replay/lessons.h"
#include "tests/learner/record_support.h"
#include "tests/wire/played_tickets.h"

namespace powderkeg {
namespace {

constexpr std::uint32_t kNewest = 9;

struct Kind {
  const char* name;
  const char* environment;
  std::vector<std::string> seats;
};

const std::vector<Kind> kKinds = {
    {"FourLearners", "PommeFFACompetition-v0", {"me", "me", "me", "me"}},
    {"PastVersions", "PommeFFACompetition-v0", {"me", "past", "past", "simple_unbiased"}},
    {"Demonstrations", "PommeFFACompetition-v0", {"me", "teacher", "teacher", "idle"}},
    {"Team", "PommeTeamCompetition-v0", {"me", "simple_unbiased", "me", "simple_unbiased"}},
    {"Radio", "PommeRadioCompetition-v2", {"me", "me", "me", "me"}},
    {"OneVsOne", "OneVsOne-v0", {"me", "past"}},
};

SelfPlayConfig ConfigOf(const Kind& kind) {
  SelfPlayConfig config;
  config.environment = kind.environment;
  config.players = {{.name = "me", .teaches = Teaches::kSearch},
                    {.name = "past", .weights = PlayerSpec::Weights::kPast},
                    {.name = "teacher", .agent = "simple_unbiased", .teaches = Teaches::kMoves}};
  config.lineups = {{.seats = kind.seats}};
  return config;
}

class DamagedRecords : public testing::TestWithParam<Kind> {
 protected:
  // A short one of the kind; its past selves are older than its learners.
  [[nodiscard]] GameRecord Play() const {
    GameRecord shortest;
    for (std::uint64_t ticket = 0; ticket < 20; ++ticket) {
      GameRecord record = PlayTicket(config_, ticket, kNewest - 1);
      const std::size_t steps = record.actions.size();
      if (shortest.actions.empty() || steps < shortest.actions.size()) shortest = std::move(record);
    }
    for (AgentId agent = 0; agent < kAgentCount; ++agent) {
      if (shortest.setup.seats[agent].player == 1) shortest.tracks[agent].weights_version = 2;
    }
    return shortest;
  }
  // Why the learner would refuse it; "" if it would not.
  [[nodiscard]] std::string ReasonAgainst(GameRecord record) const {
    record.setup = games_.SetupFor(record.ticket);
    const auto made = MakeLessons(record);
    if (const auto* reason = std::get_if<std::string>(&made)) return *reason;
    const auto& lessons = std::get<Lessons>(made);
    EXPECT_GE(lessons.samples.size(), DecisionCount(record));
    return WhyImplausible(record, games_, kNewest).value_or("");
  }

  const SelfPlayConfig config_ = ConfigOf(GetParam());
  const RunGames games_{config_};
};
INSTANTIATE_TEST_SUITE_P(Kinds, DamagedRecords, testing::ValuesIn(kKinds),
                         [](const auto& kind) { return std::string(kind.param.name); });

TEST_P(DamagedRecords, EveryFlippedByteOfASealedRecordIsRefused) {
  const GameRecord record = Play();
  ASSERT_EQ(ReasonAgainst(record), "");
  SealedGame game = Seal(record, {});
  Rng rng(1);
  for (char& byte : game.record) {
    const char whole = byte;
    byte = static_cast<char>(byte ^ (1 << rng.Below(8)));
    ASSERT_TRUE(std::holds_alternative<Malformed>(Unseal(game)));
    byte = whole;
  }
}

// A liar seals what it has made up: its own moves, and what its search found, within bounds.
TEST_P(DamagedRecords, AFlippedByteThatIsSealedAgainIsRefusedOrPlausible) {
  const GameRecord record = Play();
  const std::string whole = EncodeRecord(record);
  Rng rng(2);
  int refused = 0;
  for (std::size_t place = 0; place < whole.size(); ++place) {
    std::string bytes = whole;
    bytes[place] = static_cast<char>(bytes[place] ^ (1 << rng.Below(8)));
    const Decoded<GameRecord> decoded = DecodeRecord(bytes);
    const auto* changed = std::get_if<GameRecord>(&decoded);
    if (changed == nullptr || changed->ticket != record.ticket ||
        !ReasonAgainst(*changed).empty()) {
      ++refused;
      continue;
    }
    for (AgentId agent = 0; agent < kAgentCount; ++agent) {
      EXPECT_LE(changed->tracks[agent].weights_version, kNewest);
      if (record.setup.seats[agent].searches) continue;
      EXPECT_EQ(changed->tracks[agent], record.tracks[agent]);
    }
  }
  EXPECT_GT(refused, static_cast<int>(whole.size()) / 20);
}

TEST_P(DamagedRecords, AFlippedByteOfASegmentGivesNoOtherGame) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "x.h5";
  const std::vector<GameRecord> games = {Play()};
  const std::vector<std::uint8_t> whole = EncodeSegment(games);
  Rng rng(3);
  for (int i = 0; i < 300; ++i) {
    std::vector<std::uint8_t> bytes = whole;
    bytes[rng.Below(static_cast<std::uint32_t>(bytes.size()))] ^=
        static_cast<std::uint8_t>(1 << rng.Below(8));
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
    const SegmentDamage damage =
        ReadSegment(path, [&](const GameRecord& record) { EXPECT_EQ(record, games.front()); });
    EXPECT_NE(damage.reason, "");
  }
}

}  // namespace
}  // namespace powderkeg
