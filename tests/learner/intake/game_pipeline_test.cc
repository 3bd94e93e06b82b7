#include "learner/intake/game_pipeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/config/config.h"
#include "tests/wire/played_tickets.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
using Kind = Verdict::Kind;

constexpr milliseconds kLong{60'000};

// A pipeline into a vector.
class GamePipelineTest : public testing::Test {
 protected:
  GamePipelineTest() {
    settings_.self_play = QuickConfig();
    settings_.commit_interval = milliseconds(1);
  }

  void Start(std::vector<std::uint64_t> stored = {}) {
    TicketSet tickets;
    for (const std::uint64_t ticket : stored) tickets.Insert(ticket);
    pipeline_ = std::make_unique<GamePipeline>(
        settings_,
        [this](const auto& games, const auto& lessons) {
          EXPECT_EQ(lessons.size(), games.size());
          games_.insert(games_.end(), games.begin(), games.end());
        },
        tickets, waker_);
  }
  void Submit(SealedGame game) { ASSERT_TRUE(pipeline_->Submit(/*session=*/1, std::move(game))); }
  // The verdict on one game.
  Verdict VerdictOn(SealedGame game) {
    Start();
    Submit(std::move(game));
    pipeline_->Drain();
    const std::vector<Verdict> verdicts = pipeline_->TakeVerdicts();
    EXPECT_EQ(verdicts.size(), 1u);
    return verdicts.at(0);
  }
  std::string ReasonAgainst(SealedGame game) {
    const Verdict verdict = VerdictOn(std::move(game));
    EXPECT_EQ(verdict.kind, Kind::kRejected);
    EXPECT_TRUE(games_.empty());
    return verdict.reason;
  }

  PipelineSettings settings_;
  const Waker waker_;
  std::vector<GameRecord> games_;  // of the store thread until Drain
  std::unique_ptr<GamePipeline> pipeline_;
};

TEST_F(GamePipelineTest, AGameBecomesDurable) {
  const Verdict verdict = VerdictOn(SealedTicket(QuickConfig(), 3));
  EXPECT_EQ(verdict.kind, Kind::kDurable);
  EXPECT_EQ(verdict.ticket, 3u);
  ASSERT_EQ(games_.size(), 1u);
  EXPECT_EQ(verdict.decisions, DecisionCount(games_[0]));
  EXPECT_EQ(games_[0], PlayTicket(QuickConfig(), 3));
}

// One Ack for all of them: an Ack for each would overrun the queue of an actor with many games.
TEST_F(GamePipelineTest, VerdictsOfOneCommitComeTogether) {
  constexpr std::size_t kGames = 300;
  settings_.commit_games = kGames;
  settings_.commit_interval = kLong;
  Start();
  for (std::uint64_t ticket = 0; ticket < kGames; ++ticket) {
    Submit(SealedTicket(QuickConfig(), ticket));
  }
  pipeline_->Drain();
  std::uint64_t notifications = 0;  // an eventfd counts them
  ASSERT_EQ(read(waker_.file_descriptor(), &notifications, sizeof notifications), 8);
  EXPECT_EQ(notifications, 1u);
  EXPECT_EQ(pipeline_->TakeVerdicts().size(), kGames);
}

TEST_F(GamePipelineTest, AGameIsStoredOnce) {
  Start(/*stored=*/{5});
  for (const std::uint64_t ticket : {4, 4, 5}) Submit(SealedTicket(QuickConfig(), ticket));
  pipeline_->Drain();
  int duplicates = 0;
  for (const Verdict& verdict : pipeline_->TakeVerdicts()) {
    duplicates += verdict.kind == Kind::kDuplicate ? 1 : 0;
  }
  EXPECT_EQ(duplicates, 2);
  EXPECT_EQ(games_.size(), 1u);
}

TEST_F(GamePipelineTest, GamesOfOtherSearchSettingsAreTold) {
  EXPECT_TRUE(VerdictOn(Seal(PlayTicket(QuickConfig(), 0), {})).other_settings);
  const Sha256Digest digest = SettingsDigest(QuickConfig());
  EXPECT_FALSE(VerdictOn(Seal(PlayTicket(QuickConfig(), 0), digest)).other_settings);
}

// ---- What is refused, and the line that says why ------------------------------------------------

TEST_F(GamePipelineTest, RefusesDamagedRecords) {
  const SealedGame whole = SealedTicket(QuickConfig(), 0);
  SealedGame truncated = whole;
  truncated.record.resize(whole.record.size() / 2);
  EXPECT_THAT(ReasonAgainst(truncated), HasSubstr("checksum"));
  for (std::size_t place = 0; place < whole.record.size(); place += 1 + whole.record.size() / 20) {
    SealedGame flipped = whole;
    flipped.record[place] ^= 4;
    EXPECT_THAT(ReasonAgainst(flipped), HasSubstr("checksum"));
  }
}

TEST_F(GamePipelineTest, RefusesAResultThatDoesNotFollowFromTheMoves) {
  GameRecord won = PlayTicket(QuickConfig(), 0);
  won.outcome.winners ^= 1;
  EXPECT_THAT(ReasonAgainst(Seal(won, {})), HasSubstr("outcome"));
}

TEST_F(GamePipelineTest, RefusesAGameCutShort) {
  GameRecord record = PlayTicket(QuickConfig(), 0);
  record.actions.pop_back();
  for (Track& track : record.tracks) {
    std::erase_if(track.decisions,
                  [&](const Decision& decision) { return decision.step >= record.actions.size(); });
  }
  EXPECT_THAT(ReasonAgainst(Seal(record, {})), HasSubstr("outcome"));
}

TEST_F(GamePipelineTest, RefusesAMoveThatARuleBasedSeatWouldNotMake) {
  GameRecord record = PlayTicket(QuickConfig(), 0);
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (record.setup.seats[seat].policy != PolicyKind::kIdle) continue;
    if (!record.setup.seats[seat].searches) record.actions[0][seat] = Action::kBomb;
  }
  EXPECT_THAT(ReasonAgainst(Seal(record, {})), HasSubstr("step 0"));
}

TEST_F(GamePipelineTest, RefusesAChosenBoard) {
  GameRecord record = PlayTicket(QuickConfig(), 0);
  record.ticket = 1;
  EXPECT_THAT(ReasonAgainst(Seal(record, {})), HasSubstr("step"));
}

TEST_F(GamePipelineTest, RefusesWeightsThatWereNeverPublished) {
  settings_.newest_version = 8;
  EXPECT_EQ(VerdictOn(Seal(PlayTicket(QuickConfig(), 0, 7), {})).kind, Kind::kDurable);
  games_.clear();
  settings_.newest_version = 6;
  EXPECT_THAT(ReasonAgainst(Seal(PlayTicket(QuickConfig(), 0, 7), {})),
              HasSubstr(": weights 7 of player me, expected 0 to 6"));
  Start();
  pipeline_->Published(8);
  Submit(Seal(PlayTicket(QuickConfig(), 0, 7), {}));
  pipeline_->Drain();
  EXPECT_EQ(pipeline_->TakeVerdicts().at(0).kind, Kind::kDurable);
}

TEST_F(GamePipelineTest, RefusesWeightsOfOtherPlayers) {
  settings_.newest_version = 8;
  settings_.self_play.players = {{.name = "me", .teaches = Teaches::kSearch},
                                 {.name = "fixed",
                                  .weights = PlayerSpec::Weights::kFile,
                                  .weights_file = "some.weights",
                                  .teaches = Teaches::kSearch},
                                 {.name = "blind", .weights = PlayerSpec::Weights::kNone}};
  settings_.self_play.opponents.clear();
  const auto reason = [&](const std::string& player, std::uint32_t version) {
    settings_.self_play.lineups = {{.seats = {player, "idle", "random", "harmless"}},
                                   {.share = 0, .seats = {"me", "idle", "idle", "idle"}}};
    const Verdict verdict = VerdictOn(Seal(PlayTicket(settings_.self_play, 0, version), {}));
    games_.clear();
    return verdict.reason;
  };
  EXPECT_EQ(reason("me", 7), "");
  EXPECT_THAT(reason("me", FileVersion(1)), HasSubstr("of player me, expected 0 to 8"));
  EXPECT_THAT(reason("fixed", 7), HasSubstr("weights 7 of player fixed, expected those of its"));
  EXPECT_THAT(reason("fixed", FileVersion(2)), HasSubstr("of player fixed, expected those of its"));
}

TEST_F(GamePipelineTest, RefusesWeightsOfAScript) {
  settings_.newest_version = 8;
  GameRecord record = PlayTicket(QuickConfig(), 0);
  AgentId script = 0;
  while (record.setup.seats[script].searches) ++script;
  record.tracks[script].weights_version = 3;
  EXPECT_EQ(ReasonAgainst(Seal(record, {})),
            StrCat("agent ", script, ": weights 3 of a script, expected 0"));
}

TEST_F(GamePipelineTest, RefusesVisitsThatNoSearchMakes) {
  const auto reason = [&](std::array<std::uint16_t, kActionCount> visits) {
    GameRecord record = PlayTicket(settings_.self_play, 0);
    for (Track& track : record.tracks) {
      if (!track.decisions.empty()) track.decisions.front().visits = visits;
    }
    const Verdict verdict = VerdictOn(Seal(record, {}));
    games_.clear();
    return verdict.reason;
  };
  settings_.self_play.search.simulations = 1000;
  EXPECT_EQ(reason({1000}), "");
  EXPECT_THAT(reason({}), HasSubstr("no visits, expected some in every decision"));
  EXPECT_THAT(reason({600, 600}), HasSubstr("1200 visits, expected at most 1000"));
  settings_.self_play.search.full_search_share = 0.25;
  EXPECT_EQ(reason({}), "") << "a fast search";
  settings_.self_play.search.root = RootSearch::kGumbel;
  EXPECT_EQ(reason({6000, 4000}), "") << "an improved policy";
}

// ---- Failure ------------------------------------------------------------------------------------

TEST_F(GamePipelineTest, AStoreThatFailsEndsThePipelineWithoutAVerdict) {
  GamePipeline pipeline(
      settings_, [](const auto&, const auto&) { throw Error("disk full"); }, TicketSet(), waker_);
  ASSERT_TRUE(pipeline.Submit(1, SealedTicket(QuickConfig(), 0)));
  EXPECT_THROW(pipeline.Drain(), Error);
  EXPECT_TRUE(pipeline.TakeVerdicts().empty());
}

}  // namespace
}  // namespace powderkeg
