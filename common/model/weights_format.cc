// The bytes of a WeightsSnapshot. All numbers are little-endian, floats are IEEE 754 binary32, and
// nothing is aligned or padded:
//
//   magic        8 bytes "PKWEIGHT"
//   format       u32, 3; older ones are read too: 2 has no others_hidden (0), 1 no checksum either
//   checksum     u32, CRC-32C of all that follows
//   version      u32, of the weights
//   description  i32 planes, stem_channels, stem_stride; u32 blocks;
//                per block: u8 kind, i32 expanded, channels, stride;
//                i32 value_channels, value_hidden, policy_channels, own_hidden, others_hidden;
//                f32 leaky_slope
//   arrays       u32 count; per array, in the order of ArraysOf(description):
//                u16 length, name, u8 rank, rank times i64, then the values as f32
//   canary       u32 count; per position: state, u8 viewer, six f32 policy, f32 value, 3 times six
//                u8 others (from format 3 on)
//
//   state        bit boards rigid, wood, item_low, item_high, flames[0..2] of two u64 each (low,
//                high); u8 bomb_count, per bomb u8 cell, i8 life, u8 blast_strength,
//                u8 owner | direction << 2; per agent u8 cell, ammo, blast_strength, flags (1:
//                alive, 2: can kick); per agent two u8 of message; u16 step
//
// Nothing may follow. Reading trusts no byte: lengths are checked against what is left before
// memory is taken.

#include "common/model/weights_format.h"

#include <array>
#include <cstring>
#include <type_traits>

#include "common/base/byte_stream.h"
#include "common/base/check.h"
#include "common/base/digest.h"

namespace powderkeg {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic = {'P', 'K', 'W', 'E', 'I', 'G', 'H', 'T'};
constexpr std::uint32_t kFormat = 3;
constexpr std::uint32_t kFormatWithoutOthers = 2;
constexpr std::uint32_t kFormatWithoutChecksum = 1;
constexpr std::size_t kChecksumOffset = kMagic.size() + sizeof(kFormat);
constexpr std::size_t kChecksummedOffset = kChecksumOffset + sizeof(std::uint32_t);
constexpr std::uint32_t kMaxBlocks = 1000;
constexpr std::uint32_t kMaxCanaryPositions = 10'000;
constexpr std::uint8_t kAliveFlag = 1;
constexpr std::uint8_t kKickFlag = 2;

template <ByteNumber T>
void RequireAtMost(const char* what, T value, std::type_identity_t<T> limit) {
  if (value > limit) {
    throw Error(StrCat("weights: ", what, " is ", +value, ", expected at most ", +limit));
  }
}

void Write(const NetworkDescription& description, ByteWriter& out) {
  for (const int value : {description.planes, description.stem_channels, description.stem_stride}) {
    out.Write(std::int32_t{value});
  }
  out.Write(static_cast<std::uint32_t>(description.blocks.size()));
  for (const BlockDescription& block : description.blocks) {
    out.Write(static_cast<std::uint8_t>(block.kind));
    for (const int value : {block.expanded, block.channels, block.stride}) {
      out.Write(std::int32_t{value});
    }
  }
  for (const int value :
       {description.value_channels, description.value_hidden, description.policy_channels,
        description.own_hidden, description.others_hidden}) {
    out.Write(std::int32_t{value});
  }
  out.Write(description.leaky_slope);
}

BlockDescription ReadBlock(ByteReader& in) {
  BlockDescription block;
  block.kind = static_cast<BlockDescription::Kind>(in.Read<std::uint8_t>());
  block.expanded = in.Read<std::int32_t>();
  block.channels = in.Read<std::int32_t>();
  block.stride = in.Read<std::int32_t>();
  return block;
}

NetworkDescription ReadDescription(std::uint32_t format, ByteReader& in) {
  NetworkDescription description;
  description.planes = in.Read<std::int32_t>();
  description.stem_channels = in.Read<std::int32_t>();
  description.stem_stride = in.Read<std::int32_t>();
  const auto blocks = in.Read<std::uint32_t>();
  RequireAtMost("number of blocks", blocks, kMaxBlocks);
  for (std::uint32_t i = 0; i < blocks; ++i) description.blocks.push_back(ReadBlock(in));
  description.value_channels = in.Read<std::int32_t>();
  description.value_hidden = in.Read<std::int32_t>();
  description.policy_channels = in.Read<std::int32_t>();
  description.own_hidden = in.Read<std::int32_t>();
  if (format > kFormatWithoutOthers) description.others_hidden = in.Read<std::int32_t>();
  description.leaky_slope = in.Read<float>();
  Validate(description);
  return description;
}

void Write(const NamedArray& array, ByteWriter& out) {
  out.Write(static_cast<std::uint16_t>(array.name.size()));
  out.WriteAll(std::span<const char>(array.name));
  out.Write(static_cast<std::uint8_t>(array.shape.size()));
  out.WriteAll(std::span<const std::int64_t>(array.shape));
  out.WriteAll(std::span<const float>(array.values));
}

NamedArray ReadArray(const ArrayShape& expected, ByteReader& in) {
  NamedArray array;
  array.name = in.ReadString(in.Read<std::uint16_t>());
  array.shape = in.ReadVector<std::int64_t>(in.Read<std::uint8_t>());
  if (array.name != expected.name || array.shape != expected.shape) {
    throw Error(StrCat("weights: array '", array.name.substr(0, 64), "' does not fit the ",
                       "description, expected '", expected.name, "' of its shape"));
  }
  array.values = in.ReadVector<float>(static_cast<std::size_t>(ElementCount(expected.shape)));
  return array;
}

void Write(BitBoard board, ByteWriter& out) {
  out.Write(board.low());
  out.Write(board.high());
}

BitBoard ReadBitBoard(ByteReader& in) {
  std::array<std::uint64_t, 2> words{};
  in.ReadAll(std::span<std::uint64_t>(words));
  BitBoard board;
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    if ((words[static_cast<std::size_t>(cell / 64)] >> (cell % 64) & 1) != 0) board.Add(cell);
  }
  if (board.high() != words[1]) throw Error("weights: canary with a cell outside the board");
  return board;
}

void Write(const State& state, ByteWriter& out) {
  for (const BitBoard board : {state.rigid, state.wood, state.item_low, state.item_high,
                               state.flames[0], state.flames[1], state.flames[2]}) {
    Write(board, out);
  }
  out.Write(state.bomb_count);
  for (const Bomb& bomb : state.Bombs()) {
    out.Write(bomb.cell);
    out.Write(bomb.life);
    out.Write(bomb.blast_strength);
    out.Write(bomb.owner_and_direction);
  }
  for (const AgentState& agent : state.agents) {
    out.Write(agent.cell);
    out.Write(agent.ammo);
    out.Write(agent.blast_strength);
    out.Write(static_cast<std::uint8_t>((agent.alive ? kAliveFlag : 0) |
                                        (agent.can_kick ? kKickFlag : 0)));
  }
  for (const Message& message : state.messages)
    out.WriteAll(std::span<const std::uint8_t>(message));
  out.Write(state.step);
}

std::uint8_t ReadCell(ByteReader& in) {
  const auto cell = in.Read<std::uint8_t>();
  RequireAtMost("canary cell", cell, kCellCount - 1);
  return cell;
}

Bomb ReadBomb(ByteReader& in) {
  Bomb bomb;
  bomb.cell = ReadCell(in);
  bomb.life = in.Read<std::int8_t>();
  bomb.blast_strength = in.Read<std::uint8_t>();
  bomb.owner_and_direction = in.Read<std::uint8_t>();
  RequireAtMost("canary bomb direction", static_cast<int>(bomb.direction()),
                static_cast<int>(Direction::kRight));
  return bomb;
}

AgentState ReadAgent(ByteReader& in) {
  AgentState agent;
  agent.cell = ReadCell(in);
  agent.ammo = in.Read<std::uint8_t>();
  agent.blast_strength = in.Read<std::uint8_t>();
  const auto flags = in.Read<std::uint8_t>();
  RequireAtMost("canary agent flags", flags, kAliveFlag | kKickFlag);
  agent.alive = (flags & kAliveFlag) != 0;
  agent.can_kick = (flags & kKickFlag) != 0;
  return agent;
}

State ReadState(ByteReader& in) {
  State state;
  for (BitBoard* board : {&state.rigid, &state.wood, &state.item_low, &state.item_high,
                          &state.flames[0], &state.flames[1], &state.flames[2]}) {
    *board = ReadBitBoard(in);
  }
  const auto bombs = in.Read<std::uint8_t>();
  RequireAtMost("canary bombs", bombs, kMaxBombs);
  for (int i = 0; i < bombs; ++i) {
    const Bomb bomb = ReadBomb(in);
    if (state.bomb_cells.Has(bomb.cell)) throw Error("weights: canary with two bombs on a cell");
    state.AddBomb(bomb);
  }
  for (AgentState& agent : state.agents) agent = ReadAgent(in);
  for (Message& message : state.messages) in.ReadAll(std::span<std::uint8_t>(message));
  state.step = in.Read<std::uint16_t>();
  return state;
}

void Write(const Canary& canary, ByteWriter& out) {
  CHECK(canary.viewers.size() == canary.states.size() &&
        canary.evaluations.size() == canary.states.size());
  out.Write(static_cast<std::uint32_t>(canary.states.size()));
  for (std::size_t i = 0; i < canary.states.size(); ++i) {
    Write(canary.states[i], out);
    out.Write(static_cast<std::uint8_t>(canary.viewers[i]));
    out.WriteAll(std::span<const float>(canary.evaluations[i].policy));
    out.Write(canary.evaluations[i].value);
    for (const auto& policy : canary.evaluations[i].others) {
      out.WriteAll(std::span<const std::uint8_t>(policy));
    }
  }
}

// Answers that are not numbers are kept: no evaluator agrees with them.
Canary ReadCanary(std::uint32_t format, ByteReader& in) {
  const auto count = in.Read<std::uint32_t>();
  RequireAtMost("canary positions", count, kMaxCanaryPositions);
  Canary canary;
  for (std::uint32_t i = 0; i < count; ++i) {
    canary.states.push_back(ReadState(in));
    const auto viewer = in.Read<std::uint8_t>();
    RequireAtMost("canary viewer", viewer, kAgentCount - 1);
    canary.viewers.push_back(viewer);
    Evaluation evaluation{};
    in.ReadAll(std::span<float>(evaluation.policy));
    evaluation.value = in.Read<float>();
    if (format > kFormatWithoutOthers) {
      for (auto& policy : evaluation.others) in.ReadAll(std::span<std::uint8_t>(policy));
    }
    canary.evaluations.push_back(evaluation);
  }
  return canary;
}

// Returns the format.
std::uint32_t ReadHeader(std::span<const std::uint8_t> bytes, ByteReader& in) {
  std::array<std::uint8_t, kMagic.size()> magic{};
  in.ReadAll(std::span<std::uint8_t>(magic));
  if (magic != kMagic) throw Error("weights: bad magic, expected 'PKWEIGHT'");
  const auto format = in.Read<std::uint32_t>();
  if (format == kFormatWithoutChecksum) return format;
  if (format != kFormat && format != kFormatWithoutOthers) {
    throw Error(StrCat("weights: format ", format, ", expected at most ", kFormat));
  }
  if (in.Read<std::uint32_t>() != Crc32c(bytes.subspan(kChecksummedOffset))) {
    throw Error("weights: the checksum is wrong: damaged or truncated");
  }
  return format;
}

}  // namespace

std::vector<std::uint8_t> Serialize(const WeightsSnapshot& snapshot) {
  ByteWriter out;
  out.WriteAll(std::span<const std::uint8_t>(kMagic));
  out.Write(kFormat);
  out.Write(std::uint32_t{0});  // the checksum, once the rest is known
  out.Write(snapshot.version);
  Write(snapshot.description, out);
  out.Write(static_cast<std::uint32_t>(snapshot.arrays.size()));
  for (const NamedArray& array : snapshot.arrays) Write(array, out);
  Write(snapshot.canary, out);
  std::vector<std::uint8_t> bytes = out.Take();
  const std::uint32_t checksum = Crc32c(std::span(bytes).subspan(kChecksummedOffset));
  std::memcpy(bytes.data() + kChecksumOffset, &checksum, sizeof(checksum));
  return bytes;
}

std::vector<std::uint8_t> SerializeCanary(const Canary& canary) {
  ByteWriter out;
  Write(canary, out);
  return out.Take();
}

Canary DeserializeCanary(std::span<const std::uint8_t> bytes) {
  ByteReader in("canary", bytes);
  Canary canary = ReadCanary(kFormat, in);
  in.ExpectEnd();
  return canary;
}

WeightsSnapshot Deserialize(std::span<const std::uint8_t> bytes) {
  ByteReader in("weights", bytes);
  const std::uint32_t format = ReadHeader(bytes, in);
  WeightsSnapshot snapshot;
  snapshot.version = in.Read<std::uint32_t>();
  snapshot.description = ReadDescription(format, in);
  const std::vector<ArrayShape> expected = ArraysOf(snapshot.description);
  const auto count = in.Read<std::uint32_t>();
  if (count != expected.size()) {
    throw Error(StrCat("weights: ", count, " arrays, expected ", expected.size()));
  }
  for (const ArrayShape& array : expected) snapshot.arrays.push_back(ReadArray(array, in));
  snapshot.canary = ReadCanary(format, in);
  in.ExpectEnd();
  Validate(snapshot);
  return snapshot;
}

}  // namespace powderkeg
