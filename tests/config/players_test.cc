#include "common/config/players.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/check.h"
#include "common/config/config.h"

namespace powderkeg {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;
using Weights = PlayerSpec::Weights;
using Teaches = PlayerSpec::Teaches;

Players WhoPlays(const std::string& self_play) {
  return ResolvePlayers(ParseConfig("self_play { " + self_play + " }", "x", {}).self_play);
}

std::string FaultOf(const std::string& self_play) {
  try {
    (void)WhoPlays(self_play);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Players, ByDefaultOneLearnsFromThreeAndIsExamined) {
  for (const Players& who : {WhoPlays(""), ResolvePlayers({})}) {
    ASSERT_EQ(who.players.size(), 2u);
    EXPECT_EQ(who.players[0].name, "me");
    EXPECT_EQ(who.players[0].agent.kind, AgentSpec::Kind::kSearch);
    EXPECT_EQ(who.players[0].weights, Weights::kNewest);
    EXPECT_EQ(who.players[0].teaches, Teaches::kSearch);
    EXPECT_EQ(who.players[1].agent.policy, PolicyKind::kSimpleUnbiased);
    EXPECT_EQ(who.players[1].weights, Weights::kNone);
    ASSERT_EQ(who.lineups.size(), 2u);
    EXPECT_EQ(who.lineups[0], (Lineup{.name = "me + 3 simple_unbiased",
                                      .share = 0.95,
                                      .exam = false,
                                      .seats = {0, 1, 1, 1},
                                      .seat_count = 4}));
    EXPECT_EQ(who.lineups[1], (Lineup{.name = "me + 3 simple_unbiased",
                                      .share = 0.05,
                                      .exam = true,
                                      .seats = {0, 1, 1, 1},
                                      .seat_count = 4}));
  }
}

TEST(Players, TwoPlayOneAgainstOne) {
  const Players who = WhoPlays("environment: 'OneVsOne-v0'");
  EXPECT_EQ(who.lineups[0].seat_count, 2);
  EXPECT_THAT(who.lineups[0].seats, ElementsAre(0, 1, 0, 0));
}

TEST(Players, OpponentsAreShortForLineups) {
  const Players who = WhoPlays("opponents: 'idle' opponents: 'random' opponents: 'idle'");
  ASSERT_EQ(who.players.size(), 3u);
  EXPECT_EQ(who.players[1].name, "idle");
  EXPECT_THAT(who.lineups[0].seats, ElementsAre(0, 1, 2, 1));
  EXPECT_THAT(WhoPlays("opponents: 'harmless'").lineups[1].seats, ElementsAre(0, 1, 1, 1));
  // Those said later replace line-ups said before.
  const std::vector<std::string> changes = {"self_play.opponents=idle,random,harmless"};
  const RunConfig stored = ParseConfig(ToText(ParseConfig("", "x", {})), "x", changes);
  EXPECT_THAT(stored.self_play.lineups.at(1).seats,
              ElementsAre("me", "idle", "random", "harmless"));
  EXPECT_EQ(ParseConfig("self_play { opponents: idle }", "x",
                        std::vector<std::string>{"self_play.seed=5"})
                .self_play.lineups.at(0)
                .seats.at(1),
            "idle");
  EXPECT_THAT(FaultOf("opponents: idle lineup { seats: 'me idle idle idle' }"),
              HasSubstr("expected one of the two"));
  EXPECT_THAT(FaultOf("opponents: 'idle idle'"), HasSubstr("has 2 names; expected 1 or 3"));
  EXPECT_THAT(FaultOf("opponents: 'idle idle bob'"), HasSubstr("bob"));
}

TEST(Players, SitInLineups) {
  const Players who = WhoPlays(R"(
      search { simulations: 5 memory: reset }
      player { name: "me" agent: "search:simulations=16" teaches: search }
      player { name: "past" agent: "search" weights: past }
      player { name: "given" agent: "raw" weights: "file:a b.weights" }
      player { name: "script" agent: "official_simple" teaches: moves }
      lineup { share: 3 seats: "me" seats: "past" seats: "given" seats: "script" }
      lineup { share: 1 exam: true seats: "me idle idle idle" })");
  ASSERT_EQ(who.players.size(), 5u);
  EXPECT_EQ(who.players[0].agent.search.simulations, 16);
  EXPECT_EQ(who.players[0].agent.search.memory, ModelMemory::kReset);
  EXPECT_EQ(who.players[1].agent.search.simulations, 5);
  EXPECT_EQ(who.players[1].weights, Weights::kPast);
  EXPECT_EQ(who.players[2].weights, Weights::kFile);
  EXPECT_EQ(who.players[2].weights_file, "a b.weights");
  EXPECT_EQ(who.players[3].teaches, Teaches::kMoves);
  EXPECT_EQ(who.players[3].weights, Weights::kNone);
  EXPECT_EQ(who.players[4].name, "idle");
  EXPECT_THAT(who.lineups[0].share, DoubleEq(0.75));
  EXPECT_THAT(who.lineups[0].seats, ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(who.lineups[1].seats, ElementsAre(0, 4, 4, 4));
}

TEST(Players, PessimistsNeedNoPlayer) {
  const Players who = WhoPlays(R"(
      player { name: "me" teaches: search }
      player { name: "deep" agent: "pessimist:depth=3" teaches: moves }
      lineup { seats: "me pessimist deep pessimist" })");
  ASSERT_EQ(who.players.size(), 3u);
  EXPECT_EQ(who.players[1].agent.pessimist.depth, 3);
  EXPECT_EQ(who.players[1].weights, Weights::kNone);
  EXPECT_EQ(who.players[2].agent.kind, AgentSpec::Kind::kPessimist);
  EXPECT_EQ(who.players[2].weights, Weights::kNone);
  EXPECT_THAT(who.lineups[0].seats, ElementsAre(0, 2, 1, 2));
}

TEST(Players, FaultsSayWhatIsExpected) {
  const std::string me = "player { name: 'me' teaches: search } ";
  const std::string all = "lineup { seats: 'me me me me' } ";
  EXPECT_EQ(FaultOf(me + all), "no error");
  EXPECT_THAT(FaultOf(me + "lineup { seats: 'me you me me' }"),
              HasSubstr("names you; expected one of me, idle"));
  EXPECT_THAT(FaultOf(me + "lineup { seats: 'me simple_unbaised me me' }"),
              HasSubstr("; did you mean simple_unbiased?"));
  EXPECT_THAT(FaultOf(me + "lineup { seats: 'me me' }"), HasSubstr("has 2 seats; expected 4 in"));
  EXPECT_THAT(FaultOf(me + all + "environment: OneVsOne-v0"), HasSubstr("has 4 seats; expected 2"));
  EXPECT_THAT(FaultOf(me + "lineup { share: 0 seats: 'me me me me' }"), HasSubstr("sum to 0"));
  EXPECT_THAT(FaultOf(me + "lineup { share: -1 seats: 'me me me me' }"), HasSubstr("share is -1"));
  EXPECT_THAT(FaultOf(me + me + all), HasSubstr("expected one player of that name"));
  EXPECT_THAT(FaultOf("player { name: idle }"), HasSubstr("expected another name than a policy's"));
  EXPECT_THAT(FaultOf("player { name: v3 }"), HasSubstr("expected another name than a version's"));
  EXPECT_THAT(FaultOf("player { name: 'a b' }"), HasSubstr("[A-Za-z0-9_-]"));
  EXPECT_THAT(FaultOf("player { name: me teaches: everything }"), HasSubstr("nothing, search"));
  EXPECT_THAT(FaultOf("player { name: me weights: old }"), HasSubstr("none, newest, past or file"));
  EXPECT_THAT(FaultOf("player { name: me weights: 'file:' }"), HasSubstr("or file:MODEL"));
  EXPECT_THAT(FaultOf("player { name: me agent: idle teaches: search }"),
              HasSubstr("me (idle) teaches search; expected teaches: moves"));
  EXPECT_THAT(FaultOf("player { name: me agent: idle weights: newest teaches: moves }"),
              HasSubstr("has weights; expected none"));
  EXPECT_THAT(FaultOf("player { name: me agent: raw weights: none teaches: moves }"),
              HasSubstr("has no weights"));
  EXPECT_THAT(FaultOf("player { name: me agent: 'raw:model=x' }"), HasSubstr("file:x"));
  EXPECT_THAT(FaultOf("player { name: me agent: 'http:host:1' teaches: moves }"),
              HasSubstr("expected one that an actor can play without a server"));
  EXPECT_THAT(FaultOf("player { name: me agent: 'search:simulation=4' }"),
              HasSubstr("simulations"));
  EXPECT_THAT(FaultOf("player { name: me }" + all), HasSubstr("nobody teaches"));
  EXPECT_THAT(FaultOf(me + "lineup { exam: true seats: 'me me me me' }"),
              HasSubstr("nobody teaches"));
  EXPECT_THAT(
      FaultOf(me +
              "lineup { share: 0 seats: 'me me me me' } lineup { seats: 'idle idle idle idle' }"),
      HasSubstr("nobody teaches"));
  EXPECT_THAT(
      FaultOf("environment: 'Chess-v0'"),
      HasSubstr("self_play.environment is Chess-v0; expected one of PommeFFACompetition-v0"));
}

}  // namespace
}  // namespace powderkeg
