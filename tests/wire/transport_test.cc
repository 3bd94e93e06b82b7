#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netdb.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "common/base/check.h"
#include "common/wire/messages.h"
#include "common/wire/zmq_transport.h"
#include "tests/wire/in_process_transport.h"

namespace {

using Resolver = int (*)(const char*, const char*, const addrinfo*, addrinfo**);
constexpr const char* kManyAddresses = "many-addresses.invalid";

}  // namespace

// Stands before the system's function for this whole program: a name with three addresses, of which
// the learner listens on the last.
extern "C" int getaddrinfo(const char* name, const char* service, const addrinfo* hints,
                           addrinfo** result) {
  static const auto system = reinterpret_cast<Resolver>(dlsym(RTLD_NEXT, "getaddrinfo"));
  if (name == nullptr || std::string(name) != kManyAddresses) {
    return system(name, service, hints, result);
  }
  addrinfo** end = result;
  for (const char* address : {"::1", "127.0.0.2", "127.0.0.1"}) {
    if (const int error = system(address, service, hints, end); error != 0) return error;
    while (*end != nullptr) end = &(*end)->ai_next;
  }
  return 0;
}

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

class ZmqTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(keys_); }
  void TearDown() override { std::filesystem::remove_all(keys_); }

  // Sends until the server has it; false after `patience`.
  bool Reaches(ClientChannel& client, ServerChannel& server, const std::string& bytes,
               milliseconds patience) {
    const auto deadline = Clock::now() + patience;
    bool sent = false;
    while (Clock::now() < deadline) {
      sent = sent || client.Send(bytes);
      if (auto incoming = server.Receive(milliseconds(10), waker_)) {
        last_ = *std::move(incoming);
        return last_.bytes == bytes;
      }
    }
    return false;
  }

  const std::filesystem::path keys_ =
      std::filesystem::path(testing::TempDir()) / "pk-transport-keys";
  const Waker waker_;
  Incoming last_;
};

TEST_F(ZmqTest, CarriesMessagesBothWays) {
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0"});
  const auto client = ConnectZmq(server->endpoint(), std::nullopt);
  const std::string large(kMaxChunkBytes, 'x');
  ASSERT_TRUE(Reaches(*client, *server, large, milliseconds(5000)));
  EXPECT_TRUE(server->Send(last_.peer, "answer"));
  EXPECT_EQ(client->Receive(milliseconds(5000), waker_), "answer");
  EXPECT_FALSE(server->Send("nobody", "lost"));
}

TEST_F(ZmqTest, TriesEveryAddressOfAName) {
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0"});
  const std::string port = server->endpoint().substr(server->endpoint().rfind(':'));
  const auto client = ConnectZmq(StrCat("tcp://", kManyAddresses, port), std::nullopt);
  EXPECT_TRUE(Reaches(*client, *server, "hello", milliseconds(20'000)));
}

// Sends until nothing more is taken; how many were. Stops at `most`.
int SendUntilFull(const std::function<bool()>& send, const std::function<void()>& pause, int most) {
  int sent = 0;
  for (int refused = 0; refused < 100 && sent < most;) {
    if (send()) {
      ++sent;
      refused = 0;
    } else {
      ++refused;
      pause();  // the io threads may still make room
    }
  }
  return sent;
}

TEST_F(ZmqTest, APeerThatDoesNotReadGetsABoundedQueue) {
  const std::string message(std::size_t{64} << 10, 'x');
  constexpr int kMost = 5000;
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0"});
  const auto client = ConnectZmq(server->endpoint(), std::nullopt);
  ASSERT_TRUE(Reaches(*client, *server, "hello", milliseconds(5000)));
  const auto pause = [&] { waker_.Wait(milliseconds(1)); };
  const int down = SendUntilFull([&] { return server->Send(last_.peer, message); }, pause, kMost);
  const int up = SendUntilFull([&] { return client->Send(message); }, pause, kMost);
  EXPECT_LT(down, kMost);
  EXPECT_LT(up, kMost);
  // Everything that was taken arrives, and there is room again.
  for (int i = 0; i < down; ++i) ASSERT_TRUE(client->Receive(milliseconds(5000), waker_)) << i;
  for (int i = 0; i < up; ++i) ASSERT_TRUE(server->Receive(milliseconds(5000), waker_)) << i;
  EXPECT_EQ(SendUntilFull([&] { return server->Send(last_.peer, message); }, pause, 1), 1);
  EXPECT_EQ(SendUntilFull([&] { return client->Send(message); }, pause, 1), 1);
}

TEST_F(ZmqTest, TheEndpointIsWhatOneConnectsTo) {
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0"});
  EXPECT_TRUE(server->endpoint().starts_with("tcp://127.0.0.1:")) << server->endpoint();
  const auto on_ipv6 = ListenZmq({.endpoint = "tcp://[::1]:0"});
  EXPECT_TRUE(on_ipv6->endpoint().starts_with("tcp://[::1]:")) << on_ipv6->endpoint();
}

TEST_F(ZmqTest, NothingIsSentBeforeTheConnectionStands) {
  const auto client = ConnectZmq("tcp://127.0.0.1:1", std::nullopt);
  EXPECT_FALSE(client->Send("hello"));
}

TEST_F(ZmqTest, OversizedMessagesDoNotArrive) {
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0"});
  const auto client = ConnectZmq(server->endpoint(), std::nullopt);
  const std::string oversized(static_cast<std::size_t>(kMaxMessageBytes) + 1, 'x');
  EXPECT_FALSE(Reaches(*client, *server, oversized, milliseconds(300)));
  const auto other = ConnectZmq(server->endpoint(), std::nullopt);
  EXPECT_TRUE(Reaches(*other, *server, "still there", milliseconds(5000)));
}

TEST_F(ZmqTest, KeysLetInWhoIsKnown) {
  WriteKeyPair(MakeKeyPair(), keys_ / "learner");
  WriteKeyPair(MakeKeyPair(), keys_ / "actors" / "known");
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0", .keys = keys_});
  const auto client = ConnectZmq(server->endpoint(), ReadClientKeys(keys_, "known"));
  EXPECT_TRUE(Reaches(*client, *server, "hello", milliseconds(5000)));
}

TEST_F(ZmqTest, KeysKeepOutEverybodyElse) {
  WriteKeyPair(MakeKeyPair(), keys_ / "learner");
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0", .keys = keys_});
  const ClientKeys stranger{.learner_public = ReadKey(keys_ / "learner.public"),
                            .own = MakeKeyPair()};
  const ClientKeys fooled{.learner_public = MakeKeyPair().public_key, .own = MakeKeyPair()};
  const auto clients = {ConnectZmq(server->endpoint(), stranger).release(),
                        ConnectZmq(server->endpoint(), fooled).release(),
                        ConnectZmq(server->endpoint(), std::nullopt).release()};
  for (ClientChannel* channel : clients) {
    const std::unique_ptr<ClientChannel> client(channel);
    EXPECT_FALSE(Reaches(*client, *server, "hello", milliseconds(200)));
  }
}

TEST_F(ZmqTest, WhoIsKeptOutIsToldWhy) {
  WriteKeyPair(MakeKeyPair(), keys_ / "learner");
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0", .keys = keys_});
  const auto open = ListenZmq({.endpoint = "tcp://127.0.0.1:0"});
  const ClientKeys stranger{.learner_public = ReadKey(keys_ / "learner.public"),
                            .own = MakeKeyPair()};
  const ClientKeys fooled{.learner_public = MakeKeyPair().public_key, .own = MakeKeyPair()};
  const auto trouble = [&](const std::string& endpoint, const std::optional<ClientKeys>& keys) {
    const auto client = ConnectZmq(endpoint, keys);
    const auto deadline = Clock::now() + milliseconds(5000);
    const std::string unknown = endpoint + ": no answer";
    while (client->Trouble() == unknown && Clock::now() < deadline) waker_.Wait(milliseconds(5));
    return client->Trouble();
  };
  using testing::HasSubstr;
  EXPECT_THAT(trouble(server->endpoint(), stranger), HasSubstr("does not know this actor's key"));
  EXPECT_THAT(trouble(server->endpoint(), fooled), HasSubstr("it hung up"));
  EXPECT_THAT(trouble(server->endpoint(), std::nullopt), HasSubstr("it hung up"));
  EXPECT_THAT(trouble(open->endpoint(), stranger), HasSubstr("it hung up"));
  EXPECT_EQ(ConnectZmq("tcp://127.0.0.1:1", std::nullopt)->Trouble(),
            "tcp://127.0.0.1:1: no answer");
}

TEST_F(ZmqTest, AnActorCanBeAddedWhileTheLearnerRuns) {
  WriteKeyPair(MakeKeyPair(), keys_ / "learner");
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0", .keys = keys_});
  WriteKeyPair(MakeKeyPair(), keys_ / "actors" / "late");
  const auto client = ConnectZmq(server->endpoint(), ReadClientKeys(keys_, "late"));
  EXPECT_TRUE(Reaches(*client, *server, "hello", milliseconds(5000)));
}

TEST_F(ZmqTest, KeysThatComeGoAndChangeAreNoticed) {
  const CurveKeyPair first = MakeKeyPair();
  const std::filesystem::path actors = keys_ / "actors";
  WriteKeyPair(first, actors / "one");
  KeyFolder folder(keys_);
  EXPECT_EQ(folder.ActorOf(first.public_key), "one");
  std::filesystem::rename(actors / "one.public", actors / "two.public");
  const auto deadline = std::chrono::steady_clock::now() + milliseconds(5000);
  while (folder.ActorOf(first.public_key) != "two") {  // the folder is not read at all times
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
  }
  std::ofstream(actors / "two.public") << MakeKeyPair().public_key << "\n";
  EXPECT_EQ(folder.ActorOf(first.public_key), std::nullopt);
  std::filesystem::remove_all(actors);
  EXPECT_EQ(folder.ActorOf(first.public_key), std::nullopt);
}

TEST_F(ZmqTest, NoKeysNoListeningBeyondThisMachine) {
  EXPECT_THROW((void)ListenZmq({.endpoint = "tcp://*:0"}), Error);
  EXPECT_NO_THROW((void)ListenZmq({.endpoint = "tcp://*:0", .allow_insecure = true}));
  EXPECT_TRUE(IsLocal("ipc:///tmp/x"));
  EXPECT_TRUE(IsLocal("tcp://127.0.0.1:5000"));
  EXPECT_FALSE(IsLocal("tcp://0.0.0.0:5000"));
  EXPECT_FALSE(IsLocal("tcp://localhost.example.org:5000"));
}

TEST_F(ZmqTest, BadAddressesAndKeysAreErrors) {
  EXPECT_THROW((void)ListenZmq({.endpoint = "nonsense", .allow_insecure = true}), Error);
  EXPECT_THROW((void)ConnectZmq("nonsense", std::nullopt), Error);
  for (const std::string port : {"99999", "65536", "-1", "", "http", "123456789012345"}) {
    const std::string endpoint = "tcp://127.0.0.1:" + port;
    EXPECT_THROW((void)ListenZmq({.endpoint = endpoint}), Error) << endpoint;
    EXPECT_THROW((void)ConnectZmq(endpoint, std::nullopt), Error) << endpoint;
  }
  EXPECT_THROW((void)ListenZmq({.endpoint = "tcp://127.0.0.1:0", .keys = keys_}), Error);
  WriteKeyPair(MakeKeyPair(), keys_ / "learner");
  EXPECT_THROW(WriteKeyPair(MakeKeyPair(), keys_ / "learner"), Error);
  const auto server = ListenZmq({.endpoint = "tcp://127.0.0.1:0", .keys = keys_});
  EXPECT_THROW((void)ListenZmq({.endpoint = server->endpoint(), .keys = keys_}), Error);
  const auto mode = std::filesystem::status(keys_ / "learner.secret").permissions();
  EXPECT_EQ(mode, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

TEST(WakerTest, EndsAWait) {
  InProcessNetwork network;
  const auto server = network.Listen();
  const Waker waker;
  waker.Notify();
  EXPECT_EQ(server->Receive(milliseconds(60'000), waker), std::nullopt);
}

}  // namespace
}  // namespace powderkeg
