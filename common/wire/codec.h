#pragma once

// Messages and game records to bytes and back. Decoding is total: whatever a peer sends gives a
// value or the reason why not, never a crash, an exception or unbounded memory.

#include <string>
#include <string_view>
#include <variant>

#include "common/record/game_record.h"
#include "common/wire/messages.h"

namespace powderkeg {

// Why something could not be read, in one line.
struct Malformed {
  std::string reason;

  friend bool operator==(const Malformed&, const Malformed&) = default;
};

template <typename T>
using Decoded = std::variant<T, Malformed>;

// Values of decisions are rounded to multiples of 1 / 32,767 (QuantiseValue); the setup is not sent
// (it follows from the ticket) and comes back empty; the rest comes back as it was.
[[nodiscard]] std::string EncodeRecord(const GameRecord& record);
// Checks forms and ranges; whether the game is true is for Verify.
[[nodiscard]] Decoded<GameRecord> DecodeRecord(std::string_view bytes);

// The value of a decision as it comes back from the wire. Requires -1 to +1.
[[nodiscard]] float QuantiseValue(float value);

// Encodes the record and adds the checksum.
[[nodiscard]] SealedGame Seal(const GameRecord& record, const Sha256Digest& settings_digest);
// Checks the checksum and that the tickets agree.
[[nodiscard]] Decoded<GameRecord> Unseal(const SealedGame& game);

[[nodiscard]] std::string Encode(const WireMessage& message);
[[nodiscard]] Decoded<WireMessage> Decode(std::string_view bytes);

}  // namespace powderkeg
