// Both sides of the session together, over the in-process network and over real sockets.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "actors/selfplay/outbox.h"
#include "actors/selfplay/session_client.h"
#include "actors/selfplay/ticket_book.h"
#include "common/base/check.h"
#include "common/config/config.h"
#include "common/model/network_description.h"
#include "common/wire/codec.h"
#include "common/wire/zmq_transport.h"
#include "learner/intake/session_server.h"
#include "tests/selfplay/session_support.h"
#include "tests/wire/in_process_transport.h"
#include "tests/wire/played_tickets.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

// Reads a message 50 ms after it has come.
class SlowChannel final : public ClientChannel {
 public:
  explicit SlowChannel(std::unique_ptr<ClientChannel> channel) : channel_(std::move(channel)) {}

  bool Send(const std::string& bytes) override { return channel_->Send(bytes); }
  std::optional<std::string> Receive(milliseconds timeout, const Waker& waker) override {
    std::this_thread::sleep_for(milliseconds(50));
    return channel_->Receive(timeout, waker);
  }

 private:
  std::unique_ptr<ClientChannel> channel_;
};

TEST(SessionTest, AGameIsAcknowledgedWhenItIsDurable) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  EXPECT_EQ(actor.PlayOne(), 0u);
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_EQ(learner.Tickets(), (std::vector<std::uint64_t>{0}));
  EXPECT_EQ(learner.games().front(), PlayTicket(QuickConfig(), 0));
}

TEST(SessionTest, WorksOverIpcAndTcp) {
  const std::string ipc = "ipc://" + testing::TempDir() + "pk-session.ipc";
  for (const std::string& endpoint : {ipc, std::string("tcp://127.0.0.1:0")}) {
    TestLearner learner(ListenZmq({.endpoint = endpoint}));
    TestActor actor([&] { return ConnectZmq(learner.server->endpoint(), std::nullopt); });
    ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
    for (int i = 0; i < 3; ++i) actor.PlayOne();
    EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
    EXPECT_EQ(learner.Tickets(), (std::vector<std::uint64_t>{0, 1, 2}));
  }
}

TEST(SessionTest, LostAcksAreMadeUpForByTheNextConnection) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  network.FilterToClients([](const std::string&) { return false; });
  actor.PlayOne();
  ASSERT_TRUE(Eventually([&] { return learner.Tickets().size() == 1; }));
  ASSERT_TRUE(Eventually([&] {
    return learner.server->statistics().actors.empty() ||
           learner.server->statistics().duplicates > 0;
  }));
  network.FilterToClients([](const std::string&) { return true; });
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_EQ(learner.Tickets().size(), 1u);
}

TEST(SessionTest, ALearnerThatReturnsGetsEveryGameOnce) {
  InProcessNetwork network;
  auto learner = std::make_unique<TestLearner>(network.Listen());
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() >= 4; }));
  actor.PlayOne();
  ASSERT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  const std::vector<std::uint64_t> known = learner->Tickets();
  learner.reset();
  for (int i = 0; i < 3; ++i) actor.PlayOne();
  TestLearner second(network.Listen(), QuickSettings(), known);
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_EQ(second.Tickets(), (std::vector<std::uint64_t>{1, 2, 3}));
}

TEST(SessionTest, TicketsOfADeadActorGoToAnother) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  auto dead = std::make_unique<TestActor>([&] { return network.Connect(); }, "dead");
  ASSERT_TRUE(Eventually([&] { return dead->tickets.waiting() > 0; }));
  const std::vector<std::uint64_t> lost = dead->tickets.Held();
  network.FilterToServer([](const std::string&) { return false; });
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().sessions_lost == 1; }));
  dead.reset();
  network.FilterToServer([](const std::string&) { return true; });
  TestActor other([&] { return network.Connect(); }, "other");
  ASSERT_TRUE(Eventually([&] { return other.tickets.waiting() > 0; }));
  EXPECT_EQ(other.tickets.Held(), lost);
}

TEST(SessionTest, AKilledActorSendsItsSpoolWhenItReturns) {
  InProcessNetwork network;
  TemporarySpool spool;
  TestLearner learner(network.Listen());
  {
    TestActor actor([&] { return network.Connect(); }, "a", spool.path());
    ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
    network.FilterToServer([](const std::string&) { return false; });
    actor.PlayOne();
    actor.PlayOne();
  }
  network.FilterToServer([](const std::string&) { return true; });
  TestActor actor([&] { return network.Connect(); }, "a", spool.path());
  EXPECT_EQ(actor.outbox.size(), 2u);
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_EQ(learner.Tickets(), (std::vector<std::uint64_t>{0, 1}));
}

TEST(SessionTest, ForgedGamesAreRejectedAndTheirTicketsGrantedAnew) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() >= 3; }));
  GameRecord won = PlayTicket(QuickConfig(), actor.tickets.Take()->ticket);
  won.outcome.winners ^= 1;
  actor.Send(Seal(won, {}));
  GameRecord chosen = PlayTicket(QuickConfig(), actor.tickets.Take()->ticket);
  chosen.actions.front().fill(Action::kBomb);
  actor.Send(Seal(chosen, {}));
  SealedGame damaged = SealedTicket(QuickConfig(), actor.tickets.Take()->ticket);
  damaged.record[damaged.record.size() / 2] ^= 4;
  actor.Send(damaged);
  EXPECT_TRUE(Eventually([&] { return learner.server->statistics().rejected == 3; }));
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_TRUE(learner.games().empty());
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() >= 3; }));
  EXPECT_EQ(actor.PlayOne(), 0u);
  EXPECT_TRUE(Eventually([&] { return learner.Tickets().size() == 1; }));
}

TEST(SessionTest, AnActorThatForgesOnIsRefusedForGood) {
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  settings.max_rejected_games = 2;
  TestLearner learner(network.Listen(), settings);
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() >= 3; }));
  for (int i = 0; i < 3; ++i) {
    GameRecord record = PlayTicket(QuickConfig(), actor.tickets.Take()->ticket);
    record.outcome.winners ^= 1;
    actor.Send(Seal(record, SettingsDigest(QuickConfig())));
  }
  ASSERT_TRUE(Eventually([&] { return actor.client->ended(); }));
  try {
    actor.client->Leave(milliseconds(0));
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("too many of its games were rejected"));
  }
}

TEST(SessionTest, ActorsPauseWhenTheLearnerIsSlow) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  learner.Hold();
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  const std::size_t granted = actor.tickets.waiting();
  EXPECT_EQ(granted, TicketTarget(1, QuickConfig().games_in_flight));
  while (actor.tickets.waiting() > 0) actor.PlayOne();
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().pending_games == granted; }));
  EXPECT_EQ(actor.tickets.waiting(), 0u);
  EXPECT_EQ(actor.outbox.size(), granted);
  learner.Release();
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_TRUE(Eventually([&] { return actor.tickets.waiting() == granted; }));
}

TEST(SessionTest, AFloodOfGamesStopsAtItsSender) {
  SessionServerSettings settings = QuickSettings();
  settings.max_pending_games = 64;  // stops reading at half of them
  TestLearner learner(ListenZmq({.endpoint = "tcp://127.0.0.1:0"}), settings);
  learner.Hold();
  const Waker waker;
  const auto flood = ConnectZmq(learner.server->endpoint(), std::nullopt);
  const std::string hello = Encode(Hello{.name = "flood"});
  ASSERT_TRUE(Eventually([&] { return flood->Send(hello); }));
  ASSERT_TRUE(flood->Receive(milliseconds(5000), waker)) << "no Welcome";
  ASSERT_TRUE(flood->Receive(milliseconds(5000), waker)) << "no tickets";
  const std::string games = Encode(Games{.games = std::vector(25, SealedTicket(QuickConfig(), 0))});
  constexpr int kMost = 20'000;
  int sent = 0;
  for (int refused = 0; refused < 100 && sent < kMost;) {
    const bool taken = flood->Send(games);
    sent += taken ? 1 : 0;
    refused = taken ? 0 : refused + 1;
    if (!taken) waker.Wait(milliseconds(1));
  }
  EXPECT_LT(sent, kMost) << "nothing held the sender back";
  const IntakeStatistics statistics = learner.server->statistics();
  EXPECT_LE(statistics.pending_games, settings.max_pending_games);
  EXPECT_EQ(statistics.actors.size(), 1u) << "it was refused instead of held back";
  learner.Release();
  EXPECT_TRUE(Eventually([&] { return flood->Send(games); })) << "not read again";
  EXPECT_TRUE(Eventually([&] { return learner.server->statistics().duplicates > 100; }));
  EXPECT_EQ(learner.Tickets(), (std::vector<std::uint64_t>{0}));
}

// A server's channel whose peers can be made deaf: what is sent to them is not taken.
class MutedChannel final : public ServerChannel {
 public:
  MutedChannel(std::unique_ptr<ServerChannel> channel, std::atomic<bool>& muted)
      : channel_(std::move(channel)), muted_(muted) {}
  bool Send(const PeerId& peer, const std::string& bytes) override {
    return !muted_ && channel_->Send(peer, bytes);
  }
  bool SendShared(const PeerId& peer, const std::shared_ptr<const std::string>& bytes) override {
    return Send(peer, *bytes);
  }
  std::optional<Incoming> Receive(milliseconds timeout, const Waker& waker) override {
    return channel_->Receive(timeout, waker);
  }
  [[nodiscard]] std::string endpoint() const override { return channel_->endpoint(); }

 private:
  std::unique_ptr<ServerChannel> channel_;
  std::atomic<bool>& muted_;
};

TEST(SessionTest, AnActorThatIsGoneBeforeItsWelcomeHarmsNobody) {
  InProcessNetwork network;
  auto channel = network.Listen();
  ASSERT_TRUE(network.Connect()->Send(Encode(Hello{.name = "gone"})));
  TestLearner learner(std::move(channel));
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  EXPECT_EQ(actor.PlayOne(), 0u) << "a ticket went with the actor that was gone";
}

TEST(SessionTest, AnActorWhoseSessionEndedComesBackAndLosesNothing) {
  InProcessNetwork network;
  std::atomic<bool> muted = false;
  TestLearner learner(std::make_unique<MutedChannel>(network.Listen(), muted));
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  muted = true;
  actor.PlayOne();
  ASSERT_TRUE(Eventually([&] { return learner.Tickets().size() == 1; }));
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().actors.empty(); }));
  muted = false;
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  actor.PlayOne();
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_EQ(learner.Tickets(), (std::vector<std::uint64_t>{0, 1}));
  EXPECT_EQ(learner.server->statistics().rejected, 0u);
}

TEST(SessionTest, ActorsPauseWhileNoGamesAreWanted) {
  std::atomic<bool> wanted = false;
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  settings.games_wanted = [&wanted] { return wanted ? kAllGames : 0; };
  TestLearner learner(network.Listen(), settings);
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.client->welcome() != nullptr; }));
  EXPECT_EQ(actor.tickets.waiting(), 0u);
  wanted = true;
  EXPECT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
}

// Else the games of many actors would fill data set after data set, all played with old weights.
TEST(SessionTest, ActorsShareTheGamesThatAreWanted) {
  std::atomic<std::uint64_t> wanted = 5;
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  settings.games_wanted = [&wanted] { return wanted.load(); };
  TestLearner learner(network.Listen(), settings);
  TestActor one([&] { return network.Connect(); }, "one");
  ASSERT_TRUE(Eventually([&] { return one.tickets.waiting() == 5; }));
  TestActor other([&] { return network.Connect(); }, "other");
  EXPECT_TRUE(Eventually([&] { return other.tickets.waiting() == 3; })) << "half, rounded up";
  --wanted;
  one.PlayOne();
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().games == 1; }));
  EXPECT_EQ(one.tickets.waiting(), 4u) << "it has more than its share already";
  wanted = 12;
  EXPECT_TRUE(Eventually([&] { return one.tickets.waiting() == 6; }));
  EXPECT_TRUE(Eventually([&] { return other.tickets.waiting() == 6; }));
}

TEST(SessionTest, AServerThatIsFullReadsOn) {
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  settings.max_pending_games = 4;  // stops reading at two
  TestLearner learner(network.Listen(), settings);
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  while (actor.tickets.waiting() > 0) {
    actor.PlayOne();
    ASSERT_TRUE(Eventually([&] { return actor.outbox.size() < 2; }));
    if (learner.Tickets().size() > 20) break;
  }
  EXPECT_GT(learner.Tickets().size(), 10u);
}

TEST(SessionTest, WeightsReachActorsNowAndLater) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor early([&] { return network.Connect(); }, "early");
  const Snapshot first = SomeWeights(1);
  learner.server->Publish(first);
  ASSERT_TRUE(Eventually([&] { return early.client->weights() != nullptr; }));
  EXPECT_EQ(*early.client->weights(), *first);
  TestActor late([&] { return network.Connect(); }, "late");
  ASSERT_TRUE(Eventually([&] { return late.client->weights() != nullptr; }));
  learner.server->Publish(SomeWeights(2));
  for (const TestActor* actor : {&early, &late}) {
    EXPECT_TRUE(Eventually([&] { return actor->client->weights()->version == 2; }));
  }
}

TEST(SessionTest, ActorsLearnThatThereAreNoWeightsYet) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  EXPECT_FALSE(actor.client->no_weights_yet()) << "nobody has said so";
  learner.server->Publish(nullptr);
  EXPECT_TRUE(Eventually([&] { return actor.client->no_weights_yet(); }));
  EXPECT_EQ(actor.client->weights(), nullptr);
  learner.server->Publish(SomeWeights(2));
  EXPECT_TRUE(Eventually([&] { return actor.client->weights() != nullptr; }));
}

TEST(SessionTest, DamagedWeightsAreFetchedAgain) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  learner.server->Publish(SomeWeights(1));
  std::atomic<int> damaged = 0;
  network.FilterToClients([&](std::string& bytes) {
    const auto message = std::get<WireMessage>(Decode(bytes));
    if (std::holds_alternative<WeightsChunk>(message) && damaged < 2) {
      ++damaged;
      bytes[bytes.size() / 2] ^= 1;
    }
    return true;
  });
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.client->weights() != nullptr; }));
  EXPECT_EQ(*actor.client->weights(), *SomeWeights(1));
  EXPECT_EQ(damaged, 2);
}

TEST(SessionTest, LostChunksAreAskedForAgain) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  learner.server->Publish(SomeWeights(1));
  std::atomic<int> lost = 0;
  network.FilterToClients([&](const std::string& bytes) {
    const auto message = std::get<WireMessage>(Decode(bytes));
    return !std::holds_alternative<WeightsChunk>(message) || ++lost > 1;
  });
  TestActor actor([&] { return network.Connect(); });
  EXPECT_TRUE(Eventually([&] { return actor.client->weights() != nullptr; }));
  EXPECT_GE(lost, 1);
}

TEST(SessionTest, TheEndOfTheRunEndsTheActor) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  learner.server->Stop({.reason = "all iterations are done", .run_complete = true});
  EXPECT_TRUE(Eventually([&] { return actor.client->ended(); }));
  EXPECT_NO_THROW(actor.client->Leave(milliseconds(0)));
}

// Closing a socket drops what its peers have not read: an actor that just does something else must
// hear of the end all the same, or it would look for a learner that is gone for ever.
TEST(SessionTest, ASlowActorHearsOfTheEnd) {
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  settings.goodbye_patience = std::chrono::seconds(60);
  TestLearner learner(network.Listen(), settings);
  TestActor actor([&] { return std::make_unique<SlowChannel>(network.Connect()); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  const auto start = std::chrono::steady_clock::now();
  learner.server->Stop({.reason = "all iterations are done", .run_complete = true});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
  EXPECT_TRUE(Eventually([&] { return actor.client->ended(); }));
}

TEST(SessionTest, AnActorThatHangsDoesNotHoldUpTheEnd) {
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  settings.goodbye_patience = milliseconds(50);
  TestLearner learner(network.Listen(), settings);
  const auto hanging = network.Connect();
  ASSERT_TRUE(hanging->Send(Encode(Hello{.name = "hanging"})));
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().actors.size() == 1; }));
  const auto start = std::chrono::steady_clock::now();
  learner.server->Stop({.reason = "the learner stops"});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

TEST(SessionTest, LeavingWaitsForTheAcknowledgement) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  actor.PlayOne();
  actor.client->Leave(milliseconds(10'000));
  EXPECT_EQ(actor.outbox.size(), 0u);
  EXPECT_TRUE(Eventually([&] { return learner.server->statistics().actors.empty(); }));
}

TEST(SessionTest, LeavingWithoutALearnerEndsInTime) {
  InProcessNetwork network;
  TestActor actor([&] { return network.Connect(); });
  actor.Send(SealedTicket(QuickConfig(), 0));
  actor.client->Leave(milliseconds(30));
  EXPECT_EQ(actor.outbox.size(), 1u);
}

TEST(SessionTest, AnActorGivesUpWhereItIsToldTo) {
  InProcessNetwork network;
  TemporarySpool spool;
  const milliseconds give_up(1000);
  auto learner = std::make_unique<TestLearner>(network.Listen());
  TestActor actor([&] { return network.Connect(); }, "a", spool.path(), "", give_up);
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  std::this_thread::sleep_for(give_up);  // a session that lasts is no absence
  EXPECT_FALSE(actor.client->ended());
  const auto start = std::chrono::steady_clock::now();
  learner.reset();
  actor.PlayOne();
  EXPECT_TRUE(Eventually([&] { return actor.client->ended(); }));
  EXPECT_GE(std::chrono::steady_clock::now() - start, give_up);
  EXPECT_TRUE(actor.client->gave_up());
  EXPECT_NO_THROW(actor.client->Leave(std::chrono::seconds(60)));
  EXPECT_EQ(actor.outbox.size(), 1u);  // for the next start
}

TEST(SessionTest, AWrongRunIsRefusedForGood) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); }, "a", {}, "another-run");
  ASSERT_TRUE(Eventually([&] { return actor.client->ended(); }));
  EXPECT_THROW(actor.client->Leave(milliseconds(0)), Error);
}

TEST(SessionTest, ANamesakeReplacesTheOldActor) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor old([&] { return network.Connect(); }, "same");
  ASSERT_TRUE(Eventually([&] { return old.tickets.waiting() > 0; }));
  TestActor fresh([&] { return network.Connect(); }, "same");
  EXPECT_TRUE(Eventually([&] { return old.client->ended(); }));
  EXPECT_TRUE(Eventually([&] { return fresh.tickets.waiting() > 0; }));
  EXPECT_EQ(learner.server->statistics().actors.size(), 1u);
  EXPECT_THROW(old.client->Leave(milliseconds(0)), Error);
}

TEST(SessionTest, AnotherRunsActorOfTheSameNameReplacesNobody) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); }, "same");
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  TestActor stranger([&] { return network.Connect(); }, "same", {}, "another-run");
  ASSERT_TRUE(Eventually([&] { return stranger.client->ended(); }));
  EXPECT_THROW(stranger.client->Leave(milliseconds(0)), Error);
  actor.PlayOne();
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_FALSE(actor.client->ended());
}

TEST(SessionTest, AnotherProtocolIsRefusedWithBothVersions) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  const auto client = network.Connect();
  ASSERT_TRUE(client->Send(Encode(Hello{.protocol_version = 99, .name = "new"})));
  const auto answer = client->Receive(milliseconds(5000), Waker());
  ASSERT_TRUE(answer);
  const auto refused = std::get<Refused>(std::get<WireMessage>(Decode(*answer)));
  EXPECT_EQ(refused,
            (Refused{.reason = StrCat("its protocol version is 99; expected ", kProtocolVersion)}));
}

TEST(SessionTest, AFailedStoreFailsTheServer) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  learner.FailWith("disk full");
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  actor.PlayOne();
  ASSERT_TRUE(Eventually([&] { return learner.server->failed(); }));
  EXPECT_THROW(learner.server->Stop({.reason = "failed"}), Error);
  EXPECT_EQ(actor.outbox.size(), 1u);  // never acknowledged
}

TEST(SessionTest, HeartbeatsCarryTheActorsCounters) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); }, "counts");
  ASSERT_TRUE(Eventually([&] {
    const auto actors = learner.server->statistics().actors;
    return actors.size() == 1 && actors[0].heartbeat.evaluations == 42;
  }));
  EXPECT_EQ(learner.server->statistics().actors[0].name, "counts");
}

// Of two runs with equal settings the same ticket is the same game to start with: only the weights
// that played it tell them apart.
TEST(SessionTest, GamesOfAnotherRunAreNotSent) {
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  auto first = std::make_unique<TestLearner>(network.Listen(), settings);
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 1; }));
  first.reset();
  EXPECT_EQ(actor.PlayOne(), 0u);
  settings.run_id = "another";
  TestLearner second(network.Listen(), settings);
  ASSERT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_TRUE(second.games().empty());
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  EXPECT_EQ(actor.PlayOne(), 0u);
  EXPECT_TRUE(Eventually([&] { return second.Tickets().size() == 1; }));
}

TEST(SessionTest, EqualVersionsOfOtherWeightsAreFetched) {
  InProcessNetwork network;
  auto first = std::make_unique<TestLearner>(network.Listen());
  TestActor actor([&] { return network.Connect(); });
  first->server->Publish(SomeWeights(1));
  ASSERT_TRUE(Eventually([&] { return actor.client->weights() != nullptr; }));
  first.reset();
  TestLearner second(network.Listen());
  auto others = std::make_shared<WeightsSnapshot>(*SomeWeights(9));
  others->version = 1;
  second.server->Publish(others);
  EXPECT_TRUE(Eventually([&] { return *actor.client->weights() == *others; }));
}

TEST(SessionTest, WeightsOfAnotherRunAreForgottenWhereThereAreNone) {
  InProcessNetwork network;
  auto first = std::make_unique<TestLearner>(network.Listen());
  TestActor actor([&] { return network.Connect(); });
  first->server->Publish(SomeWeights(1));
  ASSERT_TRUE(Eventually([&] { return actor.client->weights() != nullptr; }));
  first.reset();
  TestLearner second(network.Listen());
  second.server->Publish(nullptr);
  EXPECT_TRUE(Eventually([&] { return actor.client->weights() == nullptr; }));
  EXPECT_TRUE(actor.client->no_weights_yet());
}

// Else an actor that was cut off again and again would first play what others have played long ago,
// and everybody would wait for its newest tickets.
TEST(SessionTest, TicketsThatOnlyWaitAreGivenUpWithTheConnection) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  TestActor actor([&] { return network.Connect(); }, "a");
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  const std::uint64_t in_play = actor.tickets.Take().value().ticket;
  const std::vector<std::uint64_t> held = actor.tickets.Held();
  network.FilterToServer([](const std::string&) { return false; });
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().sessions_lost == 1; }));
  network.FilterToServer([](const std::string& bytes) {  // the other one alone
    const auto message = std::get<WireMessage>(Decode(bytes));
    const auto* hello = std::get_if<Hello>(&message);
    return hello == nullptr || hello->name != "a";
  });
  TestActor other([&] { return network.Connect(); }, "other");
  ASSERT_TRUE(Eventually([&] { return other.tickets.waiting() > 0; }));
  EXPECT_EQ(other.tickets.Held(), held);
  network.FilterToServer([](const std::string&) { return true; });
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().actors.size() == 2; }));
  ASSERT_TRUE(Eventually([&] { return actor.tickets.Held().back() > held.back(); }));
  for (const std::uint64_t ticket : actor.tickets.Held()) {
    EXPECT_TRUE(ticket == in_play || ticket > held.back()) << ticket;
  }
}

// Their games were true when they were played: that is no reason to lose the actor.
TEST(SessionTest, AnActorWithGamesOfEarlierSettingsIsNotRefused) {
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  settings.max_rejected_games = 2;
  settings.self_play.seed = 77;
  TestLearner learner(network.Listen(), settings);
  TestActor actor([&] { return network.Connect(); });
  const Sha256Digest earlier = SettingsDigest(QuickConfig());
  for (std::uint64_t ticket = 0; ticket < 4; ++ticket) {
    actor.Send(Seal(PlayTicket(QuickConfig(), ticket), earlier));
  }
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_TRUE(Eventually([&] { return learner.server->statistics().rejected == 4; }));
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  EXPECT_FALSE(actor.client->ended());
}

// A peer that is no actor: says and reads what the test wants.
class Stranger {
 public:
  explicit Stranger(InProcessNetwork& network) : channel_(network.Connect()) {}

  void Say(const WireMessage& message) { ASSERT_TRUE(channel_->Send(Encode(message))); }
  // The next message of this kind; others are passed over. nullopt: it does not come.
  template <typename Message>
  std::optional<Message> Hear() {
    std::optional<Message> heard;
    (void)Eventually([&] {
      const auto bytes = channel_->Receive(milliseconds(50), waker_);
      if (!bytes) return false;
      auto message = std::get<WireMessage>(Decode(*bytes));
      if (auto* found = std::get_if<Message>(&message)) heard = *found;
      return heard.has_value();
    });
    return heard;
  }

 private:
  std::unique_ptr<ClientChannel> channel_;
  const Waker waker_;
};

// So that ten thousand actors cost a learner no more signs of life than three thousand.
TEST(SessionTest, WithManyActorsHeartbeatsAreRarer) {
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  settings.dead_after = std::chrono::minutes(1);
  TestLearner learner(network.Listen(), settings);
  std::vector<std::unique_ptr<Stranger>> actors;
  std::vector<Welcome> welcomes;
  for (int i = 0; i < 1001; ++i) {
    actors.push_back(std::make_unique<Stranger>(network));
    actors.back()->Say(Hello{.name = StrCat("actor-", i)});
    const auto welcome = actors.back()->Hear<Welcome>();
    ASSERT_TRUE(welcome);
    welcomes.push_back(*welcome);
  }
  EXPECT_EQ(welcomes.front().heartbeat, settings.heartbeat);
  EXPECT_EQ(welcomes.back().heartbeat, 2 * settings.heartbeat);
  EXPECT_EQ(welcomes.back().dead_after, 2 * settings.dead_after);
}

// So at most one chunk lies in the queue of a peer that does not read.
TEST(SessionTest, TheNextChunkIsForWhoHasReadTheLast) {
  InProcessNetwork network;
  TestLearner learner(network.Listen());
  learner.server->Publish(SomeWeights(1));
  Stranger greedy(network);
  greedy.Say(Hello{.name = "greedy"});
  ASSERT_TRUE(greedy.Hear<WeightsOffer>());
  greedy.Say(WeightsRequest{.version = 1});
  ASSERT_TRUE(greedy.Hear<WeightsChunk>());
  const auto receipt = greedy.Hear<WeightsReceipt>();
  ASSERT_TRUE(receipt);
  greedy.Say(WeightsRequest{.version = 1, .receipt = receipt->receipt});
  ASSERT_TRUE(greedy.Hear<WeightsChunk>());
  greedy.Say(WeightsRequest{.version = 1, .receipt = receipt->receipt});
  const auto refused = greedy.Hear<Refused>();
  ASSERT_TRUE(refused);
  EXPECT_TRUE(refused->retry);
  EXPECT_TRUE(Eventually([&] { return learner.server->statistics().actors.empty(); }));
}

// Five versions on disk, of which the learner has published the last.
class PastWeightsTest : public testing::Test {
 protected:
  SessionServerSettings Settings() {
    SessionServerSettings settings = QuickSettings();
    settings.weights_kept = 1;
    settings.load_weights = [this](std::uint32_t version) {
      ++loads_;
      return version <= 5 && version != 4 ? Serialize(*SomeWeights(version))
                                          : std::vector<std::uint8_t>{};
    };
    return settings;
  }
  // Asks until there is an answer.
  static WantedWeights Get(TestActor& actor, std::uint32_t version) {
    WantedWeights wanted;
    (void)Eventually([&] {
      wanted = actor.client->Want(version);
      return wanted.snapshot || !wanted.fault.empty();
    });
    return wanted;
  }

  InProcessNetwork network_;
  std::atomic<int> loads_ = 0;
};

TEST_F(PastWeightsTest, ComeBesideTheNewest) {
  TestLearner learner(network_.Listen(), Settings());
  learner.server->Publish(SomeWeights(5));
  TestActor actor([&] { return network_.Connect(); });
  ASSERT_TRUE(Eventually([&] { return actor.client->weights() != nullptr; }));
  for (const std::uint32_t version : {2, 1, 3, 5}) {
    const WantedWeights wanted = Get(actor, version);
    ASSERT_TRUE(wanted.snapshot) << wanted.fault;
    EXPECT_EQ(*wanted.snapshot, *SomeWeights(version));
  }
  EXPECT_EQ(loads_, 3);
  EXPECT_EQ(actor.client->weights()->version, 5u);
  EXPECT_TRUE(actor.client->Want(1).snapshot) << "it was here already";
}

TEST_F(PastWeightsTest, WhatIsGoneIsSaidOnce) {
  TestLearner learner(network_.Listen(), Settings());
  TestActor actor([&] { return network_.Connect(); });
  EXPECT_THAT(Get(actor, 4).fault, HasSubstr("does not have them any more"));
  EXPECT_THAT(Get(actor, 99).fault, HasSubstr("does not have them any more"));
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_THAT(actor.client->Want(4).fault, HasSubstr("does not have them any more"));
  EXPECT_EQ(loads_, 2) << "asked again";
  EXPECT_TRUE(Get(actor, 1).snapshot);
}

TEST_F(PastWeightsTest, NewestOnesComeInBetween) {
  TestLearner learner(network_.Listen(), Settings());
  learner.server->Publish(SomeWeights(5));
  TestActor actor([&] { return network_.Connect(); });
  for (std::uint32_t version = 1; version <= 3; ++version) (void)actor.client->Want(version);
  learner.server->Publish(SomeWeights(6));
  for (std::uint32_t version = 1; version <= 3; ++version) {
    EXPECT_TRUE(Get(actor, version).snapshot) << version;
  }
  EXPECT_TRUE(Eventually([&] {
    const Snapshot newest = actor.client->weights();
    return newest && newest->version == 6;
  }));
  EXPECT_TRUE(Get(actor, 5).snapshot) << "the learner keeps what it has just replaced";
}

// They used to be downloaded five times a second, for ever.
TEST(SessionTest, WeightsThatAreNoUseAreFetchedOnce) {
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  std::atomic<int> loads = 0;
  settings.load_weights = [&loads](std::uint32_t) {
    ++loads;
    return std::vector<std::uint8_t>{1, 2, 3};
  };
  TestLearner learner(network.Listen(), settings);
  auto broken = std::make_shared<WeightsSnapshot>(*SomeWeights(1));
  broken->arrays.front().values.front() = std::numeric_limits<float>::quiet_NaN();
  learner.server->Publish(broken);
  std::atomic<int> requests = 0;
  network.FilterToServer([&](const std::string& bytes) {
    const auto message = std::get<WireMessage>(Decode(bytes));
    requests += std::holds_alternative<WeightsRequest>(message) ? 1 : 0;
    return true;
  });
  TestActor actor([&] { return network.Connect(); });
  ASSERT_TRUE(Eventually([&] { return requests > 0; }));
  ASSERT_TRUE(Eventually([&] { return !actor.client->Want(2).fault.empty(); }));
  const int asked = requests;
  std::this_thread::sleep_for(milliseconds(200));
  EXPECT_EQ(requests, asked);
  EXPECT_EQ(loads, 1);
  EXPECT_EQ(actor.client->weights(), nullptr);
  learner.server->Publish(SomeWeights(3));
  EXPECT_TRUE(Eventually([&] { return actor.client->weights() != nullptr; }));
}

TEST(SessionTest, GamesOfAnActorThatHangsAreGrantedToAnother) {
  std::atomic<bool> wanted = true;
  InProcessNetwork network;
  SessionServerSettings settings = QuickSettings();
  settings.overdue_after = milliseconds(30);
  settings.games_wanted = [&wanted] { return wanted ? kAllGames : 0; };
  TestLearner learner(network.Listen(), settings);
  TestActor hanging([&] { return network.Connect(); }, "hanging");
  ASSERT_TRUE(Eventually([&] { return hanging.tickets.waiting() > 0; }));
  const std::vector<std::uint64_t> held = hanging.tickets.Held();
  std::this_thread::sleep_for(milliseconds(150));
  EXPECT_EQ(learner.server->statistics().actors.at(0).tickets, held.size()) << "nobody is idle";
  wanted = false;
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().actors.at(0).tickets == 0; }));
  TestActor other([&] { return network.Connect(); }, "other");
  ASSERT_TRUE(Eventually([&] { return other.tickets.waiting() == held.size(); }));
  EXPECT_EQ(other.tickets.Held(), held);
  other.PlayOne();
  EXPECT_TRUE(Eventually([&] { return learner.Tickets().size() == 1; }));
  hanging.PlayOne();  // it was only slow: the same game, which is acknowledged all the same
  EXPECT_TRUE(Eventually([&] { return hanging.outbox.size() == 0; }));
  EXPECT_EQ(learner.Tickets().size(), 1u);
  wanted = true;
  EXPECT_TRUE(Eventually([&] { return hanging.tickets.Held().back() > held.back(); }));
}

}  // namespace
}  // namespace powderkeg
