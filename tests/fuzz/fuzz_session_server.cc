// Several peers tell the learner's session server whatever the bytes say, one after the other: what
// it stores it stores once, and what it acknowledges it has stored.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/config/config.h"
#include "learner/intake/session_server.h"
#include "tests/fuzz/byte_source.h"
#include "tests/wire/in_process_transport.h"
#include "tests/wire/played_tickets.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kPeers = 3;
constexpr int kMostMessages = 64;
constexpr std::uint64_t kPlayedTickets = 16;
constexpr milliseconds kPatience{10'000};

const SelfPlayConfig& Config() {
  static const SelfPlayConfig config = [] {
    log::Init("", log::Level::kError);
    return QuickConfig();
  }();
  return config;
}

SessionServerSettings ServerSettings() {
  SessionServerSettings settings;
  settings.run_id = "fuzz";
  settings.self_play = Config();
  settings.commit_interval = milliseconds(1);
  settings.goodbye_patience = milliseconds(0);
  settings.max_sessions = 2;
  settings.max_pending_games = 8;
  settings.max_rejected_games = 2;
  settings.draw_past = [] { return 1U; };
  return settings;
}

const SealedGame& TrueGame(std::uint64_t ticket) {
  static std::map<std::uint64_t, SealedGame> games;
  const auto found = games.find(ticket);
  if (found != games.end()) return found->second;
  return games[ticket] = SealedTicket(Config(), ticket);
}

const Snapshot& SomeWeights(std::uint32_t version) {
  static std::map<std::uint32_t, Snapshot> all;
  Snapshot& snapshot = all[version];
  if (!snapshot) {
    auto made = std::make_shared<WeightsSnapshot>(InitialWeights(SmallNetwork(), Rng(version)));
    made->version = version;
    snapshot = made;
  }
  return snapshot;
}

// One peer: what it was told decides what it can say.
class Peer {
 public:
  explicit Peer(InProcessNetwork& network) : network_(network) { Connect(); }

  void Connect() { channel_ = network_.Connect(); }
  void Say(const WireMessage& message) { (void)channel_->Send(Encode(message)); }
  void SayBytes(std::string_view bytes) { (void)channel_->Send(std::string(bytes)); }

  // Waits for something to be said if nothing was, perhaps in vain. Whether there was.
  bool Hear(milliseconds patience) {
    const auto bytes = channel_->Receive(patience, waker_);
    if (!bytes) return false;
    const Decoded<WireMessage> decoded = Decode(*bytes);
    CHECK(std::holds_alternative<WireMessage>(decoded));
    const auto& message = std::get<WireMessage>(decoded);
    if (const auto* ack = std::get_if<Ack>(&message)) {
      acknowledged_.insert(ack->durable.begin(), ack->durable.end());
      granted_.insert(granted_.end(), ack->tickets.begin(), ack->tickets.end());
    } else if (const auto* receipt = std::get_if<WeightsReceipt>(&message)) {
      receipt_ = receipt->receipt;
    }
    return true;
  }
  void HearAll() {
    while (Hear(milliseconds(0))) {
    }
  }

  [[nodiscard]] std::uint64_t Ticket(ByteSource& source) const {
    const std::size_t number = source.Next();
    if (granted_.empty() || number >= 0xc0) return number;
    return granted_[number % granted_.size()];
  }
  [[nodiscard]] std::uint64_t receipt() const { return receipt_; }
  [[nodiscard]] const std::set<std::uint64_t>& acknowledged() const { return acknowledged_; }

 private:
  InProcessNetwork& network_;
  Waker waker_;
  std::unique_ptr<ClientChannel> channel_;
  std::vector<std::uint64_t> granted_;
  std::set<std::uint64_t> acknowledged_;
  std::uint64_t receipt_ = 0;
};

Hello SomeHello(const Peer& peer, ByteSource& source) {
  Hello hello;
  const std::uint8_t kind = source.Next();
  hello.protocol_version += kind == 0xff ? 1U : 0U;
  hello.run_id = kind == 0xfe ? "other" : kind % 2 == 0 ? "" : "fuzz";
  hello.name = std::string(1, static_cast<char>('a' + kind % 3));
  hello.incarnation = kind / 16;
  hello.loops = 1U + source.Next() % 4U;
  for (std::size_t tickets = source.Next() % 8U; tickets > 0; --tickets) {
    hello.tickets.push_back(peer.Ticket(source));
  }
  return hello;
}

SealedGame SomeGame(const Peer& peer, ByteSource& source) {
  const std::uint64_t ticket = peer.Ticket(source);
  SealedGame game = TrueGame(ticket % kPlayedTickets);
  const std::uint8_t kind = source.Next();
  if (kind < 0x80) game.settings_digest = SettingsDigest(Config());
  if (kind % 8 == 1) {  // a peer that lies has checksums too
    game.record[source.Below(game.record.size())] = static_cast<char>(source.Next());
    game.checksum = Crc32c(BytesOf(game.record));
  }
  if (kind % 8 == 2) game.checksum ^= 1U;
  if (kind % 8 == 3) game.ticket = ticket;
  return game;
}

Games SomeGames(const Peer& peer, ByteSource& source) {
  Games games;
  for (std::size_t count = source.Next() % 4U; count > 0; --count) {
    games.games.push_back(SomeGame(peer, source));
  }
  return games;
}

WeightsRequest SomeRequest(const Peer& peer, ByteSource& source) {
  const std::uint8_t kind = source.Next();
  return {.version = kind % 4U,
          .offset_bytes = source.Below(65'536) * 64,
          .receipt = kind < 0xf0 ? peer.receipt() : kind};
}

class Fuzz {
 public:
  Fuzz()
      : server_(ServerSettings(), network_.Listen(),
                [this](const auto& games, const auto& lessons) {
                  CHECK(games.size() == lessons.size());
                  for (const GameRecord& game : games) CHECK(stored_.insert(game.ticket).second);
                }),
        peers_{Peer(network_), Peer(network_), Peer(network_)},
        stranger_(network_) {}

  void Run(ByteSource source) {
    for (int i = 0; i < kMostMessages && !source.empty(); ++i) Act(source);
    WaitUntilRead();
    server_.Stop({.reason = "that is all"});
    for (Peer& peer : peers_) {
      peer.HearAll();
      for (const std::uint64_t ticket : peer.acknowledged()) CHECK(stored_.contains(ticket));
    }
  }

 private:
  void Act(ByteSource& source) {
    const std::uint8_t choice = source.Next();
    Peer& peer = peers_[choice % kPeers];
    switch (choice / kPeers % 12) {
      case 0: peer.SayBytes(source.Take(source.Next())); break;
      case 1: peer.Say(SomeHello(peer, source)); break;
      case 2:
      case 3: peer.Say(SomeGames(peer, source)); break;
      case 4: peer.Say(Heartbeat{.weights_version = source.Next()}); break;
      case 5: peer.Say(Goodbye{.reason = "enough"}); break;
      case 6: peer.Say(SomeRequest(peer, source)); break;
      case 7: peer.Connect(); break;
      case 8: peer.Say(Ack{.tickets = {source.Next()}}); break;
      case 9:
        if (published_ < 3) server_.Publish(SomeWeights(++published_));
        break;
      default: WaitUntilRead(); peer.HearAll();
    }
  }

  // Whoever has no session is answered at once: all that was said before was read then.
  void WaitUntilRead() {
    stranger_.Say(Heartbeat{});
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!stranger_.Hear(kPatience)) CHECK(std::chrono::steady_clock::now() < end);
  }

  InProcessNetwork network_;
  std::set<std::uint64_t> stored_;
  SessionServer server_;
  std::array<Peer, kPeers> peers_;
  Peer stranger_;
  std::uint32_t published_ = 0;
};

}  // namespace
}  // namespace powderkeg

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  powderkeg::Fuzz().Run(powderkeg::ByteSource(data, size));
  return 0;
}
