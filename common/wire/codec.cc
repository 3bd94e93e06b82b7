// Envelopes: WireMessage <-> proto/wire.proto.

#include "common/wire/codec.h"

#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "common/base/check.h"
#include "common/base/name.h"
#include "common/config/config.h"
#include "proto/wire.pb.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kMaxNameBytes = 64;
constexpr std::size_t kMaxReasonBytes = 512;
constexpr std::int64_t kMaxHeartbeatMs = 60'000;
constexpr std::int64_t kMaxDeadAfterMs = 600'000;

// A reason as it may be sent: short, and valid UTF-8 (text of peers and of the system may not be).
std::string Reason(const std::string& text) {
  std::string clean = text.substr(0, kMaxReasonBytes);
  std::replace_if(
      clean.begin(), clean.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return clean;
}

std::string ToBytes(const Sha256Digest& digest) {
  return {reinterpret_cast<const char*>(digest.data()), digest.size()};
}

std::uint32_t ToMilliseconds(milliseconds duration) {
  const std::int64_t highest = std::numeric_limits<std::uint32_t>::max();
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(duration.count(), 0, highest));
}

template <typename Field>
void AddAll(const std::vector<std::uint64_t>& values, Field* field) {
  field->Add(values.begin(), values.end());
}

// --- Encoding: one function per message ----------------------------------------------------------

void Write(const Hello& hello, proto::Envelope& envelope) {
  proto::Hello& message = *envelope.mutable_hello();
  message.set_protocol_version(hello.protocol_version);
  message.set_run_id(hello.run_id);
  message.set_build(hello.build);
  message.set_name(hello.name);
  message.set_incarnation(hello.incarnation);
  message.set_loops(hello.loops);
  AddAll(hello.tickets, message.mutable_tickets());
}

void Write(const Welcome& welcome, proto::Envelope& envelope) {
  proto::Welcome& message = *envelope.mutable_welcome();
  message.set_run_id(welcome.run_id);
  message.set_self_play(ToText(welcome.self_play));
  message.set_settings_digest(ToBytes(welcome.settings_digest));
  message.set_heartbeat_ms(ToMilliseconds(welcome.heartbeat));
  message.set_dead_after_ms(ToMilliseconds(welcome.dead_after));
}

void Write(const Refused& refused, proto::Envelope& envelope) {
  envelope.mutable_refused()->set_reason(Reason(refused.reason));
  envelope.mutable_refused()->set_retry(refused.retry);
}

void Write(const Games& games, proto::Envelope& envelope) {
  proto::Games& message = *envelope.mutable_games();
  for (const SealedGame& game : games.games) {
    proto::SealedGame& sealed = *message.add_games();
    sealed.set_ticket(game.ticket);
    sealed.set_record(game.record);
    sealed.set_checksum(game.checksum);
    sealed.set_settings_digest(ToBytes(game.settings_digest));
  }
}

void Write(const Ack& ack, proto::Envelope& envelope) {
  proto::Ack& message = *envelope.mutable_ack();
  AddAll(ack.durable, message.mutable_durable());
  for (const RejectedGame& game : ack.rejected) {
    proto::RejectedGame& rejected = *message.add_rejected();
    rejected.set_ticket(game.ticket);
    rejected.set_reason(Reason(game.reason));
  }
  AddAll(ack.tickets, message.mutable_tickets());
  message.mutable_past_versions()->Add(ack.past_versions.begin(), ack.past_versions.end());
}

void Write(const WeightsOffer& offer, proto::WeightsOffer& message) {
  message.set_version(offer.version);
  message.set_size_bytes(offer.size_bytes);
  if (offer.size_bytes > 0) message.set_sha256(ToBytes(offer.sha256));
}

void Write(const WeightsOffer& offer, proto::Envelope& envelope) {
  Write(offer, *envelope.mutable_weights_offer());
}

void Write(const WeightsRequest& request, proto::Envelope& envelope) {
  proto::WeightsRequest& message = *envelope.mutable_weights_request();
  message.set_version(request.version);
  message.set_offset_bytes(request.offset_bytes);
  message.set_receipt(request.receipt);
}

void Write(const WeightsChunk& chunk, proto::Envelope& envelope) {
  proto::WeightsChunk& message = *envelope.mutable_weights_chunk();
  Write(chunk.offer, *message.mutable_offer());
  message.set_offset_bytes(chunk.offset_bytes);
  message.set_data(chunk.data);
}

void Write(const WeightsReceipt& receipt, proto::Envelope& envelope) {
  envelope.mutable_weights_receipt()->set_receipt(receipt.receipt);
}

void Write(const Heartbeat& heartbeat, proto::Envelope& envelope) {
  proto::Heartbeat& message = *envelope.mutable_heartbeat();
  message.set_games(heartbeat.games);
  message.set_steps(heartbeat.steps);
  message.set_decisions(heartbeat.decisions);
  message.set_simulations(heartbeat.simulations);
  message.set_evaluations(heartbeat.evaluations);
  message.set_batches(heartbeat.batches);
  message.set_games_running(heartbeat.games_running);
  message.set_tickets_waiting(heartbeat.tickets_waiting);
  message.set_outbox_games(heartbeat.outbox_games);
  message.set_outbox_bytes(heartbeat.outbox_bytes);
  message.set_oldest_ticket(heartbeat.oldest_ticket);
  message.set_oldest_game_ms(ToMilliseconds(heartbeat.oldest_game));
  message.set_weights_version(heartbeat.weights_version);
}

void Write(const Goodbye& goodbye, proto::Envelope& envelope) {
  envelope.mutable_goodbye()->set_reason(Reason(goodbye.reason));
  envelope.mutable_goodbye()->set_run_complete(goodbye.run_complete);
}

// --- Decoding ------------------------------------------------------------------------------------

Malformed OutOfRange(const char* what) {
  return Malformed{StrCat("message: ", what, " is out of range")};
}

bool ReadDigest(const std::string& bytes, Sha256Digest& digest) {
  if (bytes.size() != digest.size()) return false;
  std::copy(bytes.begin(), bytes.end(), digest.begin());
  return true;
}

template <typename Field>
bool ReadTickets(const Field& field, std::vector<std::uint64_t>& tickets) {
  if (static_cast<std::size_t>(field.size()) > kMaxTickets) return false;
  tickets.assign(field.begin(), field.end());
  return true;
}

Decoded<WireMessage> Read(const proto::Hello& message) {
  Hello hello{.protocol_version = message.protocol_version(),
              .run_id = message.run_id(),
              .build = message.build(),
              .name = message.name(),
              .incarnation = message.incarnation(),
              .loops = message.loops(),
              .tickets = {}};
  if (hello.run_id.size() > kMaxNameBytes) return OutOfRange("run id");
  if (hello.build.size() > kMaxNameBytes) return OutOfRange("build");
  if (!IsName(hello.name)) return OutOfRange("actor name");
  if (hello.loops < 1 || hello.loops > kMaxLoops) return OutOfRange("loops");
  if (!ReadTickets(message.tickets(), hello.tickets)) return OutOfRange("number of tickets");
  return hello;
}

Decoded<WireMessage> Read(const proto::Welcome& message) {
  Welcome welcome{.run_id = message.run_id(),
                  .self_play = {},
                  .settings_digest = {},
                  .heartbeat = milliseconds(message.heartbeat_ms()),
                  .dead_after = milliseconds(message.dead_after_ms())};
  if (welcome.run_id.size() > kMaxNameBytes) return OutOfRange("run id");
  try {
    welcome.self_play = ParseSelfPlay(message.self_play());
  } catch (const Error& fault) {
    return Malformed{StrCat("message: ", fault.what())};
  }
  if (!ReadDigest(message.settings_digest(), welcome.settings_digest)) {
    return OutOfRange("settings digest");
  }
  const std::int64_t heartbeat = welcome.heartbeat.count();
  const std::int64_t dead_after = welcome.dead_after.count();
  if (heartbeat < 10 || heartbeat > kMaxHeartbeatMs) return OutOfRange("heartbeat");
  if (dead_after < 2 * heartbeat || dead_after > kMaxDeadAfterMs) return OutOfRange("dead_after");
  return welcome;
}

Decoded<WireMessage> Read(const proto::Refused& message) {
  return Refused{.reason = Reason(message.reason()), .retry = message.retry()};
}

Decoded<WireMessage> Read(proto::Games& message) {
  Games games;
  std::size_t bytes = 0;
  for (proto::SealedGame& game : *message.mutable_games()) {
    SealedGame sealed{.ticket = game.ticket(),
                      .record = std::move(*game.mutable_record()),
                      .checksum = game.checksum(),
                      .settings_digest = {}};
    bytes += sealed.record.size();
    if (sealed.record.size() > kMaxRecordBytes) return OutOfRange("size of a record");
    if (!ReadDigest(game.settings_digest(), sealed.settings_digest)) {
      return OutOfRange("settings digest");
    }
    games.games.push_back(std::move(sealed));
  }
  if (bytes > kMaxGamesBytes) return OutOfRange("size of the games");
  return games;
}

Decoded<WireMessage> Read(const proto::Ack& message) {
  Ack ack;
  if (!ReadTickets(message.durable(), ack.durable)) return OutOfRange("number of games");
  if (!ReadTickets(message.tickets(), ack.tickets)) return OutOfRange("number of tickets");
  const int past = message.past_versions_size();
  if (past != 0 && past != message.tickets_size()) return OutOfRange("number of past versions");
  ack.past_versions.assign(message.past_versions().begin(), message.past_versions().end());
  if (static_cast<std::size_t>(message.rejected_size()) > kMaxTickets) {
    return OutOfRange("number of rejected games");
  }
  for (const proto::RejectedGame& game : message.rejected()) {
    ack.rejected.push_back({.ticket = game.ticket(), .reason = Reason(game.reason())});
  }
  return ack;
}

std::optional<Malformed> ReadOffer(const proto::WeightsOffer& message, WeightsOffer& offer) {
  offer.version = message.version();
  offer.size_bytes = message.size_bytes();
  if (offer.size_bytes == 0 && message.sha256().empty()) return std::nullopt;
  if (offer.version < 1) return OutOfRange("weights version");
  if (offer.size_bytes < 1 || offer.size_bytes > kMaxWeightsBytes) {
    return OutOfRange("size of the weights");
  }
  if (!ReadDigest(message.sha256(), offer.sha256)) return OutOfRange("digest of the weights");
  return std::nullopt;
}

Decoded<WireMessage> Read(const proto::WeightsOffer& message) {
  WeightsOffer offer;
  if (auto fault = ReadOffer(message, offer)) return *std::move(fault);
  if (offer.size_bytes == 0 && offer.version > 0) return OutOfRange("size of the weights");
  return offer;
}

Decoded<WireMessage> Read(const proto::WeightsRequest& message) {
  return WeightsRequest{.version = message.version(),
                        .offset_bytes = message.offset_bytes(),
                        .receipt = message.receipt()};
}

Decoded<WireMessage> Read(proto::WeightsChunk& message) {
  WeightsChunk chunk{.offer = {},
                     .offset_bytes = message.offset_bytes(),
                     .data = std::move(*message.mutable_data())};
  if (auto fault = ReadOffer(message.offer(), chunk.offer)) return *std::move(fault);
  const std::uint64_t size = chunk.offer.size_bytes;
  const std::size_t bytes = chunk.data.size();
  const bool fits = bytes <= std::min<std::uint64_t>(kMaxChunkBytes, size) &&
                    (bytes == 0 || chunk.offset_bytes <= size - bytes);
  if (!fits || (bytes == 0) != (size == 0)) return OutOfRange("size of a chunk");
  return chunk;
}

Decoded<WireMessage> Read(const proto::WeightsReceipt& message) {
  return WeightsReceipt{.receipt = message.receipt()};
}

Decoded<WireMessage> Read(const proto::Heartbeat& message) {
  return Heartbeat{.games = message.games(),
                   .steps = message.steps(),
                   .decisions = message.decisions(),
                   .simulations = message.simulations(),
                   .evaluations = message.evaluations(),
                   .batches = message.batches(),
                   .games_running = message.games_running(),
                   .tickets_waiting = message.tickets_waiting(),
                   .outbox_games = message.outbox_games(),
                   .outbox_bytes = message.outbox_bytes(),
                   .oldest_ticket = message.oldest_ticket(),
                   .oldest_game = milliseconds(message.oldest_game_ms()),
                   .weights_version = message.weights_version()};
}

Decoded<WireMessage> Read(const proto::Goodbye& message) {
  return Goodbye{.reason = Reason(message.reason()), .run_complete = message.run_complete()};
}

}  // namespace

std::string Encode(const WireMessage& message) {
  proto::Envelope envelope;
  std::visit([&](const auto& value) { Write(value, envelope); }, message);
  return envelope.SerializeAsString();
}

Decoded<WireMessage> Decode(std::string_view bytes) {
  const google::protobuf::LogSilencer silence;  // a peer must not write our log
  proto::Envelope envelope;
  if (bytes.size() > static_cast<std::size_t>(kMaxMessageBytes) ||
      !envelope.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return Malformed{StrCat("message: ", bytes.size(), " bytes that are not an Envelope")};
  }
  switch (envelope.message_case()) {
    case proto::Envelope::kHello: return Read(envelope.hello());
    case proto::Envelope::kWelcome: return Read(envelope.welcome());
    case proto::Envelope::kRefused: return Read(envelope.refused());
    case proto::Envelope::kGames: return Read(*envelope.mutable_games());
    case proto::Envelope::kAck: return Read(envelope.ack());
    case proto::Envelope::kWeightsOffer: return Read(envelope.weights_offer());
    case proto::Envelope::kWeightsRequest: return Read(envelope.weights_request());
    case proto::Envelope::kWeightsChunk: return Read(*envelope.mutable_weights_chunk());
    case proto::Envelope::kWeightsReceipt: return Read(envelope.weights_receipt());
    case proto::Envelope::kHeartbeat: return Read(envelope.heartbeat());
    case proto::Envelope::kGoodbye: return Read(envelope.goodbye());
    case proto::Envelope::MESSAGE_NOT_SET: break;
  }
  return Malformed{"message: an Envelope without a known message"};
}

}  // namespace powderkeg
