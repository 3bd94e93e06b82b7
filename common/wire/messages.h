#pragma once

// What actor and learner say to each other, as plain values. proto/wire.proto specifies the session
// and every field.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "common/base/digest.h"
#include "common/config/run_config.h"

namespace powderkeg {

inline constexpr std::uint32_t kProtocolVersion = 3;

// Limits that both sides hold, and enforce on the other.
inline constexpr std::size_t kMaxRecordBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMaxGamesBytes = std::size_t{2} << 20;
inline constexpr std::size_t kMaxChunkBytes = std::size_t{1} << 20;
inline constexpr std::uint64_t kMaxWeightsBytes = std::uint64_t{256} << 20;
inline constexpr std::size_t kMaxTickets = 65'536;  // in one message
inline constexpr std::uint32_t kMaxLoops = 1024;
// Of one message of any kind, on the wire.
inline constexpr std::int64_t kMaxMessageBytes = std::int64_t{4} << 20;

struct Hello {
  std::uint32_t protocol_version = kProtocolVersion;
  std::string run_id{};
  std::string build{};
  std::string name{};
  std::uint64_t incarnation = 0;
  std::uint32_t loops = 1;
  std::vector<std::uint64_t> tickets{};

  friend bool operator==(const Hello&, const Hello&) = default;
};

struct Welcome {
  std::string run_id{};
  SelfPlayConfig self_play{};
  Sha256Digest settings_digest{};
  std::chrono::milliseconds heartbeat{1000};
  std::chrono::milliseconds dead_after{5000};

  friend bool operator==(const Welcome&, const Welcome&) = default;
};

struct Refused {
  std::string reason{};
  bool retry = false;

  friend bool operator==(const Refused&, const Refused&) = default;
};

// A finished game in the form that is spooled and sent.
struct SealedGame {
  std::uint64_t ticket = 0;
  std::string record{};  // a GameRecord, see EncodeRecord
  std::uint32_t checksum = 0;
  Sha256Digest settings_digest{};

  friend bool operator==(const SealedGame&, const SealedGame&) = default;
};

struct Games {
  std::vector<SealedGame> games{};

  friend bool operator==(const Games&, const Games&) = default;
};

struct RejectedGame {
  std::uint64_t ticket = 0;
  std::string reason{};

  friend bool operator==(const RejectedGame&, const RejectedGame&) = default;
};

struct Ack {
  std::vector<std::uint64_t> durable{};
  std::vector<RejectedGame> rejected{};
  std::vector<std::uint64_t> tickets{};
  // For each ticket the weights of its players of past weights; 0: there are none yet, they play by
  // the newest. Empty where the run has no such players.
  std::vector<std::uint32_t> past_versions{};

  friend bool operator==(const Ack&, const Ack&) = default;
};

// The default value says that there are no weights yet.
struct WeightsOffer {
  std::uint32_t version = 0;
  std::uint64_t size_bytes = 0;
  Sha256Digest sha256{};

  friend bool operator==(const WeightsOffer&, const WeightsOffer&) = default;
};

struct WeightsRequest {
  std::uint32_t version = 0;
  std::uint64_t offset_bytes = 0;
  std::uint64_t receipt = 0;

  friend bool operator==(const WeightsRequest&, const WeightsRequest&) = default;
};

// Without data: the version is gone.
struct WeightsChunk {
  WeightsOffer offer{};
  std::uint64_t offset_bytes = 0;
  std::string data{};

  friend bool operator==(const WeightsChunk&, const WeightsChunk&) = default;
};

struct WeightsReceipt {
  std::uint64_t receipt = 0;

  friend bool operator==(const WeightsReceipt&, const WeightsReceipt&) = default;
};

// An actor's counters since it started; empty from the learner.
struct Heartbeat {
  std::uint64_t games = 0;
  std::uint64_t steps = 0;
  std::uint64_t decisions = 0;
  std::uint64_t simulations = 0;
  std::uint64_t evaluations = 0;
  std::uint64_t batches = 0;
  std::uint32_t games_running = 0;
  std::uint32_t tickets_waiting = 0;
  std::uint32_t outbox_games = 0;
  std::uint64_t outbox_bytes = 0;
  std::uint64_t oldest_ticket = 0;
  std::chrono::milliseconds oldest_game{0};
  std::uint32_t weights_version = 0;

  friend bool operator==(const Heartbeat&, const Heartbeat&) = default;
};

struct Goodbye {
  std::string reason{};
  bool run_complete = false;

  friend bool operator==(const Goodbye&, const Goodbye&) = default;
};

using WireMessage = std::variant<Hello, Welcome, Refused, Games, Ack, WeightsOffer, WeightsRequest,
                                 WeightsChunk, WeightsReceipt, Heartbeat, Goodbye>;

}  // namespace powderkeg
