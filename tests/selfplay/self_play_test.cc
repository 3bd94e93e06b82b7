// Actors that search, and a learner.

#include "actors/selfplay/self_play.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/check.h"
#include "common/base/worker.h"
#include "common/wire/zmq_transport.h"
#include "tests/selfplay/session_support.h"
#include "tests/wire/in_process_transport.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

SessionServerSettings SearchingSettings() {
  SessionServerSettings settings = QuickSettings();
  settings.self_play.search.simulations = 2;
  return settings;
}

// A SelfPlay on its own thread.
class RunningActor {
 public:
  RunningActor(InProcessNetwork& network, EvaluatorFactory factory = {})
      : RunningActor([&network] { return network.Connect(); }, std::move(factory)) {}
  explicit RunningActor(Connect connect, EvaluatorFactory factory = {}) {
    SelfPlaySettings settings;
    settings.session.name = "actor";
    settings.session.incarnation = 1;
    settings.session.loops = 2;
    settings.session.first_backoff = milliseconds(5);
    settings.spool = spool_.path();
    self_play_ = std::make_unique<SelfPlay>(settings, std::move(connect), std::move(factory));
    worker = std::make_unique<Worker>(
        "actor", [this](const std::stop_token& stop) { self_play_->Run(stop); });
  }

 private:
  TemporarySpool spool_;
  std::unique_ptr<SelfPlay> self_play_;

 public:
  std::unique_ptr<Worker> worker;
};

// Answers as the uniform evaluator under another name, or wrongly.
class FakeNetwork final : public Evaluator {
 public:
  explicit FakeNetwork(float value) : value_(value) {}
  void Evaluate(const GameSettings&, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      evaluations[i].policy.fill(1.0F / kActionCount);
      evaluations[i].value = value_;
    }
  }
  [[nodiscard]] std::string name() const override { return "fake fp32"; }

 private:
  float value_;
};

// Of the one seat that searches.
std::uint32_t VersionOf(const GameRecord& game) {
  std::uint32_t version = 0;
  for (const Track& track : game.tracks) version = std::max(version, track.weights_version);
  return version;
}

Snapshot WeightsWithCanary(std::uint32_t version) {
  auto snapshot = std::make_shared<WeightsSnapshot>(*SomeWeights(version));
  const GameSetup setup = RunGames(QuickConfig()).SetupFor(0);
  const State state = GenerateStart(setup.settings, setup.start, BoardRng(setup));
  FakeNetwork network(0.25F);
  snapshot->canary = MakeCanary({state}, {0}, network);
  return snapshot;
}

TEST(SelfPlayTest, PlaysVerifiedGamesInTicketOrder) {
  InProcessNetwork network;
  TestLearner learner(network.Listen(), SearchingSettings());
  RunningActor actor(network);
  ASSERT_TRUE(Eventually([&] { return learner.Tickets().size() >= 12; }));
  actor.worker->RequestStop();
  actor.worker->Join();
  EXPECT_EQ(learner.server->statistics().rejected, 0u);
  EXPECT_EQ(learner.games().front().evaluator, "uniform");
  EXPECT_GT(DecisionCount(learner.games().front()), 0u);
  EXPECT_TRUE(Eventually([&] { return learner.server->statistics().actors.empty(); }));
  // Nobody has a hole: tickets of games given up are granted to the next actor first.
  RunningActor next(network);
  EXPECT_TRUE(Eventually([&] { return learner.server->statistics().first_open_ticket >= 12; }));
}

TEST(SelfPlayTest, PausesOverRealSocketsWhileTheLearnerIsSlow) {
  TestLearner learner(ListenZmq({.endpoint = "tcp://127.0.0.1:0"}), SearchingSettings());
  learner.Hold();
  RunningActor actor([&] { return ConnectZmq(learner.server->endpoint(), std::nullopt); });
  // Of two loops, but it has not delivered a game yet.
  const std::size_t tickets = TicketTarget(1, QuickConfig().games_in_flight);
  // It has played its tickets, all of them lie in its outbox, and no game is in play.
  ASSERT_TRUE(Eventually([&] {
    const auto statistics = learner.server->statistics();
    if (statistics.actors.size() != 1 || statistics.pending_games != tickets) return false;
    const Heartbeat& heartbeat = statistics.actors[0].heartbeat;
    return heartbeat.games == tickets && heartbeat.outbox_games == tickets &&
           heartbeat.games_running == 0 && heartbeat.tickets_waiting == 0;
  }));
  EXPECT_EQ(learner.server->statistics().tickets_issued, tickets);
  learner.Release();
  EXPECT_TRUE(Eventually([&] { return learner.Tickets().size() > 2 * tickets; }));
}

TEST(SelfPlayTest, GamesUseTheNewestWeights) {
  InProcessNetwork network;
  SessionServerSettings settings = SearchingSettings();
  settings.self_play.evaluator = "auto";
  TestLearner learner(network.Listen(), settings);
  RunningActor actor(network, [](const SelfPlayConfig&, const Snapshot&) {
    return std::make_unique<FakeNetwork>(0.25F);
  });
  learner.server->Publish(WeightsWithCanary(1));
  ASSERT_TRUE(Eventually([&] { return !learner.games().empty(); }));
  EXPECT_EQ(VersionOf(learner.games().front()), 1u);
  EXPECT_EQ(learner.games().front().evaluator, "fake fp32");
  learner.server->Publish(WeightsWithCanary(2));
  ASSERT_TRUE(Eventually([&] { return VersionOf(learner.games().back()) == 2; }));
  for (const GameRecord& game : learner.games()) {
    for (const Track& track : game.tracks) {
      for (const Decision& decision : track.decisions) {
        ASSERT_EQ(decision.weights_version, track.weights_version);
      }
    }
  }
}

// Past selves sit beside the newest: their weights come by the grant, their tracks say which.
TEST(SelfPlayTest, PastPlayersUseThePastWeightsOfTheirGrant) {
  InProcessNetwork network;
  SessionServerSettings settings = SearchingSettings();
  settings.self_play.evaluator = "auto";
  settings.self_play.players = {{.name = "me", .teaches = Teaches::kSearch},
                                {.name = "past", .weights = PlayerSpec::Weights::kPast}};
  settings.self_play.opponents.clear();
  settings.self_play.lineups = {{.seats = {"me", "past", "idle", "idle"}}};
  settings.draw_past = [] { return 3u; };
  settings.load_weights = [](std::uint32_t version) {
    return Serialize(*WeightsWithCanary(version));
  };
  TestLearner learner(network.Listen(), settings);
  RunningActor actor(network, [](const SelfPlayConfig&, const Snapshot&) {
    return std::make_unique<FakeNetwork>(0.25F);
  });
  learner.server->Publish(WeightsWithCanary(5));
  ASSERT_TRUE(Eventually([&] { return learner.games().size() >= 3; }));
  const RunGames games(settings.self_play);
  for (const GameRecord& game : learner.games()) {
    for (AgentId seat = 0; seat < kAgentCount; ++seat) {
      const Seat& who = game.setup.seats[seat];
      const std::string& name = games.players()[who.player].name;
      const std::uint32_t version = game.tracks[seat].weights_version;
      EXPECT_EQ(version, name == "me" ? 5u : name == "past" ? 3u : 0u);
      EXPECT_EQ(game.tracks[seat].decisions.empty(), name != "me") << "only teachers are recorded";
    }
  }
}

TEST(SelfPlayTest, AnEvaluatorThatFailsTheCanaryEndsTheActor) {
  InProcessNetwork network;
  SessionServerSettings settings = SearchingSettings();
  settings.self_play.evaluator = "auto";
  TestLearner learner(network.Listen(), settings);
  RunningActor actor(network, [](const SelfPlayConfig&, const Snapshot&) {
    return std::make_unique<FakeNetwork>(0.75F);
  });
  learner.server->Publish(WeightsWithCanary(1));
  try {
    actor.worker->Join();
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("value by 0.5"));
  }
  EXPECT_TRUE(learner.games().empty());
}

TEST(SelfPlayTest, NewSettingsOfTheLearnerAreUsed) {
  InProcessNetwork network;
  auto first = std::make_unique<TestLearner>(network.Listen(), SearchingSettings());
  RunningActor actor(network);
  ASSERT_TRUE(Eventually([&] { return !first->games().empty(); }));
  first.reset();
  SessionServerSettings settings = SearchingSettings();
  settings.self_play.seed = 77;
  TestLearner second(network.Listen(), settings);
  ASSERT_TRUE(Eventually([&] { return !second.games().empty(); }));
  for (const GameRecord& game : second.games()) {
    EXPECT_EQ(game.setup, RunGames(settings.self_play).SetupFor(game.ticket));
  }
}

}  // namespace
}  // namespace powderkeg
