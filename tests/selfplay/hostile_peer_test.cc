// Peers that mean ill, over real sockets.

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <iterator>
#include <memory>
#include <numeric>
#include <string>
#include <string_view>
#include <thread>
#include <vector>
#include <zmq.hpp>

#include "common/base/log.h"
#include "common/wire/codec.h"
#include "common/wire/keys.h"
#include "common/wire/zmq_transport.h"
#include "tests/selfplay/session_support.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

// With as many tickets as a message may hold.
std::string LargeHello(const std::string& name) {
  std::vector<std::uint64_t> tickets(kMaxTickets);
  std::iota(tickets.begin(), tickets.end(), std::uint64_t{0});
  return Encode(Hello{.name = name, .loops = kMaxLoops, .tickets = std::move(tickets)});
}

int ConnectedToPath(const std::string& path) {
  const int local = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  CHECK(connect(local, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  return local;
}

int Connected(const std::string& endpoint) {
  constexpr std::string_view kIpc = "ipc://";
  if (endpoint.starts_with(kIpc)) return ConnectedToPath(endpoint.substr(kIpc.size()));
  const int tcp = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int port = std::stoi(endpoint.substr(endpoint.rfind(':') + 1));
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  CHECK(connect(tcp, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  return tcp;
}

// Says nothing.
class BarePeer {
 public:
  explicit BarePeer(const std::string& endpoint) : socket_(Connected(endpoint)) {}
  ~BarePeer() { close(socket_); }
  BarePeer(const BarePeer&) = delete;
  BarePeer& operator=(const BarePeer&) = delete;

  // The other side has not hung up.
  [[nodiscard]] static bool IsOpen(const std::unique_ptr<BarePeer>& peer) {
    std::array<char, 256> greeting;
    ssize_t size = 1;
    while (size > 0) size = recv(peer->socket_, greeting.data(), greeting.size(), MSG_DONTWAIT);
    return size < 0 && errno == EAGAIN;
  }

 private:
  const int socket_;
};

// Speaks just enough ZMTP 3.0 (ZeroMQ RFC 23) to be let in, and never reads from then on.
class DeafPeer {
 public:
  explicit DeafPeer(const std::string& endpoint) : socket_(Connected(endpoint)) {
    const timeval patience{.tv_sec = 0, .tv_usec = 200'000};
    setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    std::string greeting = std::string("\xff\0\0\0\0\0\0\0\1\x7f\3\0NULL", 16);
    greeting.resize(64);
    const std::string ready = std::string("\4\x1c\5READY\xbSocket-Type\0\0\0\6DEALER", 30);
    CHECK(Send(greeting) && Send(ready));
    (void)Read(greeting.size());
    const std::string header = Read(2);  // of the other side's READY: before it nothing may be said
    (void)Read(static_cast<unsigned char>(header[1]));
  }
  // Resets the connection.
  ~DeafPeer() {
    const linger at_once{.l_onoff = 1, .l_linger = 0};
    setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    close(socket_);
  }
  DeafPeer(const DeafPeer&) = delete;
  DeafPeer& operator=(const DeafPeer&) = delete;

  // As they are. False: the other side has stopped reading, or hung up.
  bool SayBytes(std::string_view bytes) { return Send(bytes); }

  // False: the other side has stopped reading.
  bool Say(const std::string& bytes) {
    std::string frame("\2");  // one long frame
    for (int shift = 56; shift >= 0; shift -= 8) {
      frame.push_back(static_cast<char>(bytes.size() >> shift));
    }
    return Send(frame + bytes);
  }

 private:
  bool Send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }

  [[nodiscard]] std::string Read(std::size_t size) {
    std::string bytes(size, '\0');
    CHECK(recv(socket_, bytes.data(), size, MSG_WAITALL) == static_cast<ssize_t>(size));
    return bytes;
  }

  const int socket_;
};

// Keeps every core busy at the lowest priority.
class BusyMachine {
 public:
  BusyMachine() {
    for (int i = 0; i < 3; ++i) {
      threads_.emplace_back([](const std::stop_token& stop) {
        setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 19);
        while (!stop.stop_requested()) {
        }
      });
    }
  }

 private:
  std::vector<std::jthread> threads_;
};

class HostilePeerTest : public testing::Test {
 protected:
  // Sends and is acknowledged, without a break in its session.
  void ExpectServed(TestActor& actor) {
    ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
    actor.PlayOne();
    EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
    EXPECT_EQ(learner_.server->statistics().sessions_lost, 0u);
    EXPECT_FALSE(actor.client->ended());
  }

  // That the learner has counted in the actor's session so far.
  [[nodiscard]] std::uint64_t GamesInSession(const std::string& name) const {
    for (const ActorStatistics& actor : learner_.server->statistics().actors) {
      if (actor.name == name) return actor.games;
    }
    return 0;
  }

  std::uint64_t played_ = 0;
  // A busy machine alone is no reason to lose a session.
  static SessionServerSettings PatientSettings() {
    SessionServerSettings settings = QuickSettings();
    settings.heartbeat = milliseconds(100);
    settings.dead_after = milliseconds(2000);
    return settings;
  }

  TestLearner learner_{ListenZmq({.endpoint = "tcp://127.0.0.1:0"}), PatientSettings()};
  const std::string endpoint_ = learner_.server->endpoint();
};

// It used to end in an assertion of libzmq, three to four seconds later.
TEST_F(HostilePeerTest, ManyLargeHellosAndAResetEndNobodyElse) {
  const BusyMachine busy;
  TestActor actor([&] { return ConnectZmq(endpoint_, std::nullopt); });
  {
    DeafPeer peer(endpoint_);
    const std::string hello = LargeHello("deaf");
    int said = 0;
    while (said < 280 && peer.Say(hello)) ++said;
    EXPECT_GT(said, 10);
  }
  ExpectServed(actor);
  std::this_thread::sleep_for(std::chrono::seconds(4));
  ExpectServed(actor);
}

// The tick used to come only after 256 messages, at 20 ms each.
TEST_F(HostilePeerTest, AFloodOfHellosCostsNobodyElseTheSession) {
  TestActor actor([&] { return ConnectZmq(endpoint_, std::nullopt); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  std::vector<std::jthread> flood;
  for (const std::string name : {"one", "two"}) {
    flood.emplace_back([this, name](const std::stop_token& stop) {
      const std::string hello = LargeHello(name);
      const Waker waker;
      const auto channel = ConnectZmq(endpoint_, std::nullopt);
      while (!stop.stop_requested()) {
        if (!channel->Send(hello)) waker.Wait(milliseconds(1));
      }
    });
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  for (; std::chrono::steady_clock::now() < end; ++played_) ExpectServed(actor);
  flood.clear();  // what it left unread is answered before the count is renewed
  EXPECT_TRUE(Eventually([&] { return GamesInSession("actor") == played_; })) << "not one session";
}

// Open tickets are granted whatever is wanted: a claim used to open all below it.
TEST_F(HostilePeerTest, AClaimGrantsNothing) {
  SessionServerSettings settings = QuickSettings();
  settings.games_wanted = [] { return 5; };
  TestLearner learner(ListenZmq({.endpoint = "tcp://127.0.0.1:0"}), settings);
  const std::string endpoint = learner.server->endpoint();
  DeafPeer peer(endpoint);
  ASSERT_TRUE(peer.Say(Encode(Hello{.name = "claims", .tickets = {1'048'575, 60'000}})));
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().actors.size() == 1; }));
  TestActor actor([&] { return ConnectZmq(endpoint, std::nullopt); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_EQ(actor.tickets.waiting(), 3u);
  EXPECT_LT(learner.server->statistics().tickets_issued, 10u);
}

TEST_F(HostilePeerTest, LoopsThatPlayNothingStarveNobody) {
  SessionServerSettings settings = QuickSettings();
  settings.games_wanted = [] { return 12; };
  TestLearner learner(ListenZmq({.endpoint = "tcp://127.0.0.1:0"}), settings);
  const std::string endpoint = learner.server->endpoint();
  DeafPeer peer(endpoint);
  ASSERT_TRUE(peer.Say(Encode(Hello{.name = "idle", .loops = kMaxLoops})));
  ASSERT_TRUE(Eventually([&] { return learner.server->statistics().actors.size() == 1; }));
  EXPECT_LE(learner.server->statistics().tickets_issued,
            TicketTarget(1, QuickConfig().games_in_flight));
  TestActor actor([&] { return ConnectZmq(endpoint, std::nullopt); });
  EXPECT_TRUE(Eventually([&] { return actor.tickets.waiting() == 6; }));
}

TEST_F(HostilePeerTest, NobodyFillsTheLog) {
  const TemporarySpool folder;
  const std::string file = folder.path() / "log";
  log::Init(file, log::Level::kInfo, log::Level::kError);
  const auto start = std::chrono::steady_clock::now();
  DeafPeer peer(endpoint_);
  for (int i = 0; i < 300; ++i) {
    ASSERT_TRUE(peer.Say(Encode(Hello{.name = "chatty"})));
    ASSERT_TRUE(peer.Say(i % 2 == 0 ? Encode(Goodbye{.reason = "again"}) : "no message"));
  }
  ASSERT_TRUE(Eventually([&] { return learner_.server->statistics().malformed == 150; }));
  const auto elapsed = std::chrono::steady_clock::now() - start;
  log::Init("", log::Level::kInfo);
  std::ifstream lines(file);
  const auto count = std::count(std::istreambuf_iterator<char>(lines), {}, '\n');
  EXPECT_LE(count, 12 * (2 + std::chrono::duration_cast<std::chrono::seconds>(elapsed).count()));
}

// In MB, of this process.
std::size_t Memory() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages >> pages;
  return pages * static_cast<std::size_t>(getpagesize()) >> 20;
}

// Sanitizers keep several bytes for each, and freed ones for long.
void ExpectLittleMemorySince([[maybe_unused]] std::size_t before,
                             [[maybe_unused]] std::size_t megabytes) {
#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(Memory() - std::min(before, Memory()), megabytes);
#endif
}

// Frames of one byte that all belong to one message: 36 MB of them used to take 770 MB.
void ExpectCutsMessagesWithoutEnd(const std::string& endpoint) {
  const std::size_t before = Memory();
  std::string frames;
  for (int i = 0; i < 20'000; ++i) frames += std::string_view("\1\1x", 3);  // 1: more follow
  std::atomic<int> cut = 0;
  {
    std::vector<std::jthread> peers;
    for (int i = 0; i < 3; ++i) {
      peers.emplace_back([&] {
        DeafPeer peer(endpoint);
        int said = 0;
        while (said < 600 && peer.SayBytes(frames)) ++said;
        if (said < 600) ++cut;
      });
    }
  }
  EXPECT_EQ(cut, 3);
  ExpectLittleMemorySince(before, 200);
}

TEST_F(HostilePeerTest, AMessageWithoutEndIsCutOff) {
  TestActor actor([&] { return ConnectZmq(endpoint_, std::nullopt); });
  ExpectCutsMessagesWithoutEnd(endpoint_);
  ExpectServed(actor);
}

// The system does not count what comes over ipc.
TEST_F(HostilePeerTest, AMessageWithoutEndOverIpcIsCutOff) {
  const TemporarySpool folder;
  const std::string endpoint = StrCat("ipc://", (folder.path() / "socket").string());
  TestLearner learner(ListenZmq({.endpoint = endpoint}), PatientSettings());
  TestActor actor([&] { return ConnectZmq(endpoint, std::nullopt); });
  ExpectCutsMessagesWithoutEnd(endpoint);
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  actor.PlayOne();
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
}

// Of a peer with a key the system sees 35 bytes for each.
TEST_F(HostilePeerTest, AMessageWithoutEndUnderAKeyIsCutOff) {
  const TemporarySpool folder;
  WriteKeyPair(MakeKeyPair(), folder.path() / "learner");
  WriteKeyPair(MakeKeyPair(), folder.path() / "actors" / "a");
  TestLearner learner(ListenZmq({.endpoint = "tcp://127.0.0.1:0", .keys = folder.path()}));
  const ClientKeys keys = ReadClientKeys(folder.path(), "a");
  zmq::context_t context(1);
  zmq::socket_t peer(context, zmq::socket_type::dealer);
  peer.set(zmq::sockopt::linger, 0);
  peer.set(zmq::sockopt::immediate, true);
  peer.set(zmq::sockopt::curve_serverkey, keys.learner_public);
  peer.set(zmq::sockopt::curve_publickey, keys.own.public_key);
  peer.set(zmq::sockopt::curve_secretkey, keys.own.secret_key);
  zmq::socket_t monitor(context, zmq::socket_type::pair);
  zmq_socket_monitor(peer.handle(), "inproc://m", ZMQ_EVENT_DISCONNECTED);
  monitor.connect("inproc://m");
  peer.connect(learner.server->endpoint());
  // The library holds them back until the last.
  for (int i = 0; i < 1'000'000; ++i) peer.send(zmq::buffer("x", 1), zmq::send_flags::sndmore);
  const std::size_t before = Memory();
  peer.send(zmq::buffer("x", 1), zmq::send_flags::none);
  zmq::message_t event;
  EXPECT_TRUE(Eventually([&] {
    return monitor.recv(event, zmq::recv_flags::dontwait).has_value();
  })) << "35 MB of it have come";
  ExpectLittleMemorySince(before, 100);
}

// Half of the process's descriptors are for them.
TEST_F(HostilePeerTest, ConnectionsThatSayNothingAreBounded) {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const rlimit few{.rlim_cur = 800, .rlim_max = limit.rlim_max};
  setrlimit(RLIMIT_NOFILE, &few);
  TestLearner learner(ListenZmq({.endpoint = "tcp://127.0.0.1:0"}), PatientSettings());
  const std::string endpoint = learner.server->endpoint();
  TestActor actor([&] { return ConnectZmq(endpoint, std::nullopt); });
  ASSERT_TRUE(Eventually([&] { return actor.tickets.waiting() > 0; }));
  setrlimit(RLIMIT_NOFILE, &limit);
  std::vector<std::unique_ptr<BarePeer>> peers;
  for (int i = 0; i < 450; ++i) peers.push_back(std::make_unique<BarePeer>(endpoint));
  const auto open = [&] { return std::ranges::count_if(peers, &BarePeer::IsOpen); };
  EXPECT_TRUE(Eventually([&] { return open() < 400; }));
  EXPECT_GT(open(), 350);
  EXPECT_TRUE(BarePeer::IsOpen(peers.back())) << "who has come last needs a moment";
  actor.PlayOne();
  EXPECT_TRUE(Eventually([&] { return actor.outbox.size() == 0; }));
  EXPECT_EQ(learner.server->statistics().sessions_lost, 0u);
}

TEST_F(HostilePeerTest, AKeyIsGoodForItsOwnNameAlone) {
  const TemporarySpool folder;
  WriteKeyPair(MakeKeyPair(), folder.path() / "learner");
  for (const std::string name : {"honest", "thief"}) {
    WriteKeyPair(MakeKeyPair(), folder.path() / "actors" / name);
  }
  TestLearner learner(ListenZmq({.endpoint = "tcp://127.0.0.1:0", .keys = folder.path()}));
  const auto connect_as = [&](const std::string& name) {
    return [&learner, keys = ReadClientKeys(folder.path(), name)] {
      return ConnectZmq(learner.server->endpoint(), keys);
    };
  };
  TestActor honest(connect_as("honest"), "honest");
  ASSERT_TRUE(Eventually([&] { return honest.tickets.waiting() > 0; }));
  TestActor thief(connect_as("thief"), "honest");
  ASSERT_TRUE(Eventually([&] { return thief.client->ended(); }));
  try {
    thief.client->Leave(milliseconds(0));
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("its key is that of actor \"thief\""));
  }
  honest.PlayOne();
  EXPECT_TRUE(Eventually([&] { return honest.outbox.size() == 0; }));
  EXPECT_FALSE(honest.client->ended());
}

}  // namespace
}  // namespace powderkeg
