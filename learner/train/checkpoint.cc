#include "learner/train/checkpoint.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <iomanip>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/byte_stream.h"
#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/log.h"
#include "common/model/model_name.h"

// Format: "PKCHECK2", u32 CRC-32C of the rest, then
//   u64 number of data sets, each u64 first ticket, u64 last ticket
//   u64 optimizer steps, u64 samples seen
//   u64 length, that many bytes of a serialised WeightsSnapshot
//   u64 number of optimizer arrays, each u64 length and bytes of its name, u64 number of
//     dimensions, i64 each, f32 values
//   u64 length, that many bytes of the table of iterations
namespace powderkeg {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "PKCHECK2";
constexpr std::size_t kHeaderBytes = kMagic.size() + sizeof(std::uint32_t);
constexpr std::string_view kEnding = ".checkpoint";
constexpr std::int64_t kMaxArrayLength = std::int64_t{1} << 32;  // values of one array

using Counter = std::uint64_t;

void Write(const NamedArray& array, ByteWriter& out) {
  out.Write(Counter{array.name.size()});
  out.WriteAll(std::span<const char>(array.name));
  out.Write(Counter{array.shape.size()});
  out.WriteAll(std::span<const std::int64_t>(array.shape));
  out.WriteAll(std::span<const float>(array.values));
}

NamedArray ReadArray(ByteReader& in) {
  NamedArray array;
  array.name = in.ReadString(in.ReadCount<Counter>(1));
  array.shape = in.ReadVector<std::int64_t>(in.ReadCount<Counter>(sizeof(std::int64_t)));
  std::size_t values = 1;
  for (const std::int64_t length : array.shape) {
    if (length <= 0 || length > kMaxArrayLength / static_cast<std::int64_t>(values)) {
      throw Error(StrCat("checkpoint: array ", array.name, " has a dimension of ", length));
    }
    values *= static_cast<std::size_t>(length);
  }
  array.values = in.ReadVector<float>(values);
  return array;
}

std::vector<TicketRange> ReadDataSets(ByteReader& in) {
  std::vector<TicketRange> data_sets(in.ReadCount<Counter>(2 * sizeof(std::uint64_t)));
  std::uint64_t expected = 0;
  for (TicketRange& range : data_sets) {
    range.first = in.Read<std::uint64_t>();
    range.last = in.Read<std::uint64_t>();
    if (range.first != expected || range.last < range.first) {
      throw Error("checkpoint: its data sets do not follow each other");
    }
    expected = range.last + 1;
  }
  return data_sets;
}

fs::path FileName(int iteration) {
  std::ostringstream name;
  name << "iteration-" << std::setw(8) << std::setfill('0') << iteration << kEnding;
  return name.str();
}

// The checkpoints in the folder, newest first: their names sort by iteration.
std::vector<fs::path> NewestFirst(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (const fs::path& path : FilesIn(folder)) {
    if (path.extension() == kEnding) paths.push_back(path);
  }
  std::ranges::sort(paths, std::greater());
  return paths;
}

}  // namespace

std::vector<std::uint8_t> Serialize(const Checkpoint& checkpoint) {
  ByteWriter out;
  out.WriteAll(BytesOf(kMagic));
  out.Write(std::uint32_t{0});  // the checksum, once the rest is known
  out.Write(Counter{checkpoint.data_sets.size()});
  for (const TicketRange& range : checkpoint.data_sets) {
    out.Write(range.first);
    out.Write(range.last);
  }
  const TrainerState& trainer = checkpoint.trainer;
  out.Write(trainer.optimizer_steps);
  out.Write(trainer.samples_seen);
  const std::vector<std::uint8_t> weights = Serialize(trainer.weights);
  out.Write(Counter{weights.size()});
  out.WriteAll(std::span<const std::uint8_t>(weights));
  out.Write(Counter{trainer.optimizer.size()});
  for (const NamedArray& array : trainer.optimizer) Write(array, out);
  out.Write(Counter{checkpoint.table.size()});
  out.WriteAll(BytesOf(checkpoint.table));
  std::vector<std::uint8_t> bytes = out.Take();
  const std::uint32_t checksum = Crc32c(std::span(bytes).subspan(kHeaderBytes));
  std::memcpy(bytes.data() + kMagic.size(), &checksum, sizeof(checksum));
  return bytes;
}

Checkpoint DeserializeCheckpoint(std::span<const std::uint8_t> bytes) {
  ByteReader in("checkpoint", bytes);
  if (!std::ranges::equal(in.Bytes(kMagic.size()), BytesOf(kMagic))) {
    throw Error(StrCat("checkpoint: not of this format, expected \"", kMagic, "\" first"));
  }
  if (in.Read<std::uint32_t>() != Crc32c(bytes.subspan(kHeaderBytes))) {
    throw Error("checkpoint: its checksum is wrong: it is damaged or truncated");
  }
  Checkpoint checkpoint;
  checkpoint.data_sets = ReadDataSets(in);
  checkpoint.trainer.optimizer_steps = in.Read<std::uint64_t>();
  checkpoint.trainer.samples_seen = in.Read<std::uint64_t>();
  checkpoint.trainer.weights = Deserialize(in.Bytes(in.ReadCount<Counter>(1)));
  const std::size_t arrays = in.ReadCount<Counter>(2 * sizeof(Counter));
  for (std::size_t i = 0; i < arrays; ++i) checkpoint.trainer.optimizer.push_back(ReadArray(in));
  checkpoint.table = in.ReadString(in.ReadCount<Counter>(1));
  in.ExpectEnd();
  return checkpoint;
}

TrainerState LoadFirstState(const std::string& name) {
  TrainerState state;
  if (name.ends_with(kEnding)) {
    state = DeserializeCheckpoint(ReadFileBytes(name)).trainer;
  } else {
    state.weights = *LoadModel(name);
    state.weights.canary = {};
  }
  state.weights.version = 1;
  return state;
}

CheckpointFolder::CheckpointFolder(fs::path folder, int kept)
    : folder_(std::move(folder)), kept_(static_cast<std::size_t>(kept)) {
  CHECK(kept > 0);
  PrepareFolder(folder_);
}

std::optional<Checkpoint> CheckpointFolder::LoadNewest() const {
  const std::vector<fs::path> paths = NewestFirst(folder_);
  for (const fs::path& path : paths) {
    try {
      return DeserializeCheckpoint(ReadFileBytes(path));
    } catch (const Error& error) {
      log::Warn("checkpoint skipped", "file", path.string(), "reason", error.what());
    }
  }
  if (paths.empty()) return std::nullopt;
  throw Error(StrCat("none of the ", paths.size(), " checkpoints in ", folder_.string(),
                     " can be read; move them away to train anew on the stored games"));
}

void CheckpointFolder::Save(const Checkpoint& checkpoint) {
  const fs::path saved = folder_ / FileName(checkpoint.iteration());
  WriteFileDurably(saved, Serialize(checkpoint));
  // What is newer was skipped as damaged when this run was resumed.
  std::size_t kept = 0;
  for (const fs::path& path : NewestFirst(folder_)) {
    if (path > saved || kept == kept_) {
      RemoveFile(path);
    } else {
      ++kept;
    }
  }
}

}  // namespace powderkeg
