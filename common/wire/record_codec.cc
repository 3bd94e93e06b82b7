// Game records: GameRecord <-> proto/game_record.proto.

#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "common/base/check.h"
#include "common/wire/codec.h"
#include "proto/game_record.pb.h"

namespace powderkeg {
namespace {

constexpr float kValueScale = 32'767;
constexpr int kActionBits = 3;
constexpr std::uint32_t kActionMask = (1u << kActionBits) - 1;
constexpr std::size_t kMaxSteps = std::numeric_limits<std::uint16_t>::max();
constexpr std::size_t kMaxNameBytes = 128;

std::int32_t ScaledValue(float value) {
  return static_cast<std::int32_t>(std::lround(value * kValueScale));
}

float ValueOf(std::int32_t scaled) { return static_cast<float>(scaled) / kValueScale; }

std::uint32_t Packed(const JointAction& actions) {
  std::uint32_t packed = 0;
  for (std::size_t i = 0; i < actions.size(); ++i) {
    packed |= static_cast<std::uint32_t>(actions[i]) << (kActionBits * i);
  }
  return packed;
}

void EncodeTrack(const Track& track, proto::Track& message) {
  const auto count = static_cast<int>(track.decisions.size());
  message.set_weights_version(track.weights_version);
  message.mutable_step_change()->Reserve(count);
  message.mutable_visits()->Reserve(count * kActionCount);
  message.mutable_value()->Reserve(count);
  message.mutable_weights_version_change()->Reserve(count);
  std::uint32_t step = 0;
  std::int64_t version = track.weights_version;
  for (const Decision& decision : track.decisions) {
    message.add_step_change(decision.step - step);
    for (const std::uint16_t visits : decision.visits) message.add_visits(visits);
    message.add_value(ScaledValue(decision.value));
    message.add_weights_version_change(decision.weights_version - version);
    step = decision.step;
    version = decision.weights_version;
  }
}

void EncodeOutcome(const Outcome& outcome, proto::Outcome& message) {
  message.set_done(outcome.done);
  message.set_result(static_cast<std::uint32_t>(outcome.result));
  message.set_winners(outcome.winners);
  for (const std::int8_t reward : outcome.rewards) message.add_rewards(reward);
}

// Reads the parts of one record; keeps the first fault, later parts are then of no use.
class RecordReader {
 public:
  explicit RecordReader(const proto::GameRecord& message) : message_(message) {}

  Decoded<GameRecord> Read() {
    record_.ticket = message_.ticket();
    record_.evaluator = message_.evaluator();
    Require(record_.evaluator.size() <= kMaxNameBytes, "evaluator", record_.evaluator.size());
    ReadActions();
    if (Require(message_.tracks_size() == kAgentCount, "tracks", message_.tracks_size())) {
      for (int i = 0; i < kAgentCount; ++i) ReadTrack(message_.tracks(i), record_.tracks[i]);
    }
    ReadOutcome(message_.outcome());
    if (!fault_.empty()) return Malformed{fault_};
    return std::move(record_);
  }

 private:
  template <typename Value>
  bool Require(bool condition, const char* what, Value value) {
    if (!condition && fault_.empty()) {
      fault_ = StrCat("game record: ", what, " is out of range: ", value);
    }
    return condition;
  }
  int Number(std::uint32_t value, std::uint32_t low, std::uint32_t high, const char* what) {
    Require(value >= low && value <= high, what, value);
    return static_cast<int>(value);
  }
  template <typename Enumeration>
  Enumeration Known(std::uint32_t value, Enumeration first, Enumeration last, const char* what) {
    Require(value >= static_cast<std::uint32_t>(first) && value <= static_cast<std::uint32_t>(last),
            what, value);
    return static_cast<Enumeration>(value);
  }

  void ReadActions() {
    const auto& packed = message_.joint_actions();
    if (!Require(packed.size() <= static_cast<int>(kMaxSteps), "steps", packed.size())) return;
    record_.actions.resize(static_cast<std::size_t>(packed.size()));
    for (int step = 0; step < packed.size(); ++step) {
      std::uint32_t rest = packed[step];
      for (Action& action : record_.actions[static_cast<std::size_t>(step)]) {
        const std::uint32_t number = rest & kActionMask;
        if (!Require(number < kActionCount, "action", packed[step])) return;
        action = static_cast<Action>(number);
        rest >>= kActionBits;
      }
      if (!Require(rest == 0, "joint action", packed[step])) return;
    }
  }

  void ReadTrack(const proto::Track& message, Track& track) {
    const int count = message.step_change_size();
    const bool even = message.visits_size() == count * kActionCount &&
                      message.value_size() == count &&
                      message.weights_version_change_size() == count;
    if (!Require(count <= static_cast<int>(kMaxSteps) && even, "decision columns", count)) return;
    track.weights_version = message.weights_version();
    track.decisions.resize(static_cast<std::size_t>(count));
    std::uint64_t step = 0;
    std::int64_t version = track.weights_version;
    for (int i = 0; i < count; ++i) {
      Decision& decision = track.decisions[static_cast<std::size_t>(i)];
      step += message.step_change(i);
      if (!Require(step <= kMaxSteps, "step", step)) return;
      decision.step = static_cast<std::uint16_t>(step);
      if (!ReadTargets(message, i, decision)) return;
      const std::int64_t change = message.weights_version_change(i);
      constexpr std::int64_t kMaxVersion = std::numeric_limits<std::uint32_t>::max();
      if (!Require(change >= -version && change <= kMaxVersion - version, "weights version",
                   change)) {
        return;
      }
      version += change;
      decision.weights_version = static_cast<std::uint32_t>(version);
    }
  }

  bool ReadTargets(const proto::Track& message, int i, Decision& decision) {
    for (int action = 0; action < kActionCount; ++action) {
      const std::uint32_t visits = message.visits(i * kActionCount + action);
      if (!Require(visits <= std::numeric_limits<std::uint16_t>::max(), "visits", visits)) {
        return false;
      }
      decision.visits[static_cast<std::size_t>(action)] = static_cast<std::uint16_t>(visits);
    }
    const std::int32_t value = message.value(i);
    constexpr auto kLimit = static_cast<std::int32_t>(kValueScale);
    if (!Require(value >= -kLimit && value <= kLimit, "value", value)) return false;
    decision.value = ValueOf(value);
    return true;
  }

  void ReadOutcome(const proto::Outcome& message) {
    Outcome& outcome = record_.outcome;
    outcome.done = message.done();
    outcome.result = Known(message.result(), Result::kIncomplete, Result::kTie, "result");
    outcome.winners =
        static_cast<std::uint8_t>(Number(message.winners(), 0, (1u << kAgentCount) - 1, "winners"));
    if (!Require(message.rewards_size() == kAgentCount, "rewards", message.rewards_size())) return;
    for (int i = 0; i < kAgentCount; ++i) {
      const std::int32_t reward = message.rewards(i);
      Require(reward >= -1 && reward <= 1, "reward", reward);
      outcome.rewards[static_cast<std::size_t>(i)] = static_cast<std::int8_t>(reward);
    }
  }

  const proto::GameRecord& message_;
  GameRecord record_;
  std::string fault_;
};

}  // namespace

float QuantiseValue(float value) { return ValueOf(ScaledValue(value)); }

std::string EncodeRecord(const GameRecord& record) {
  proto::GameRecord message;
  message.set_ticket(record.ticket);
  message.set_evaluator(record.evaluator);
  message.mutable_joint_actions()->Reserve(static_cast<int>(record.actions.size()));
  for (const JointAction& actions : record.actions) message.add_joint_actions(Packed(actions));
  for (const Track& track : record.tracks) EncodeTrack(track, *message.add_tracks());
  EncodeOutcome(record.outcome, *message.mutable_outcome());
  return message.SerializeAsString();
}

Decoded<GameRecord> DecodeRecord(std::string_view bytes) {
  if (bytes.size() > kMaxRecordBytes) {
    return Malformed{StrCat("game record of ", bytes.size(), " bytes; at most ", kMaxRecordBytes)};
  }
  const google::protobuf::LogSilencer silence;  // a peer must not write our log
  proto::GameRecord message;
  if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return Malformed{"game record: not a valid message"};
  }
  return RecordReader(message).Read();
}

SealedGame Seal(const GameRecord& record, const Sha256Digest& settings_digest) {
  SealedGame game{.ticket = record.ticket,
                  .record = EncodeRecord(record),
                  .checksum = 0,
                  .settings_digest = settings_digest};
  game.checksum = Crc32c(BytesOf(game.record));
  return game;
}

Decoded<GameRecord> Unseal(const SealedGame& game) {
  if (Crc32c(BytesOf(game.record)) != game.checksum) {
    return Malformed{"game record: the checksum does not fit"};
  }
  Decoded<GameRecord> record = DecodeRecord(game.record);
  if (const auto* value = std::get_if<GameRecord>(&record);
      value != nullptr && value->ticket != game.ticket) {
    return Malformed{
        StrCat("game record: sent for ticket ", game.ticket, ", holds ticket ", value->ticket)};
  }
  return record;
}

}  // namespace powderkeg
