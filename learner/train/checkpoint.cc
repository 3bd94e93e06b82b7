#include "learner/train/checkpoint.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <functional>
#include <iomanip>
#include <numeric>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/log.h"
#include "learner/replay/durable_file.h"

// Format: "PKCHECK1", u32 CRC-32C of the rest, then
//   u64 number of data sets, each u64 first ticket, u64 last ticket
//   u64 optimizer steps, u64 samples seen
//   u64 length, that many bytes of a serialised WeightsSnapshot
//   u64 number of optimizer arrays, each u64 length and bytes of its name, u64 number of
//     dimensions, i64 each, f32 values
namespace powderkeg {
namespace {

namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

constexpr std::string_view kMagic = "PKCHECK1";
constexpr std::size_t kHeaderBytes = kMagic.size() + sizeof(std::uint32_t);
constexpr std::string_view kEnding = ".checkpoint";

class Writer {
 public:
  template <typename T>
  void Number(T value) {
    Bytes({reinterpret_cast<const std::uint8_t*>(&value), sizeof(value)});
  }
  void Count(std::size_t count) { Number<std::uint64_t>(count); }
  void Bytes(std::span<const std::uint8_t> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void Array(const NamedArray& array) {
    Count(array.name.size());
    Bytes(BytesOf(array.name));
    Count(array.shape.size());
    for (const std::int64_t length : array.shape) Number(length);
    Bytes({reinterpret_cast<const std::uint8_t*>(array.values.data()),
           array.values.size() * sizeof(float)});
  }
  [[nodiscard]] std::vector<std::uint8_t>& bytes() { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

// Every length is checked against what is left before anything is allocated.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  template <typename T>
  T Number() {
    T value;
    std::memcpy(&value, Bytes(sizeof(value)).data(), sizeof(value));
    return value;
  }
  // A number of things that take at least `bytes_each`.
  std::size_t Count(std::size_t bytes_each) {
    const auto count = Number<std::uint64_t>();
    if (count > bytes_.size() / bytes_each) throw Error("it is truncated");
    return count;
  }
  std::span<const std::uint8_t> Bytes(std::size_t count) {
    if (count > bytes_.size()) throw Error("it is truncated");
    const auto bytes = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return bytes;
  }
  NamedArray Array() {
    NamedArray array;
    const auto name = Bytes(Count(1));
    array.name.assign(name.begin(), name.end());
    std::size_t values = 1;
    for (std::size_t dimensions = Count(sizeof(std::int64_t)); dimensions > 0; --dimensions) {
      const auto length = Number<std::int64_t>();
      if (length <= 0 || static_cast<std::size_t>(length) > bytes_.size() / values) {
        throw Error(StrCat("array ", array.name, " has a bad shape"));
      }
      array.shape.push_back(length);
      values *= static_cast<std::size_t>(length);
    }
    const auto bytes = Bytes(values * sizeof(float));
    array.values.resize(values);
    std::memcpy(array.values.data(), bytes.data(), bytes.size());
    return array;
  }
  [[nodiscard]] bool done() const { return bytes_.empty(); }

 private:
  std::span<const std::uint8_t> bytes_;
};

std::vector<TicketRange> ReadDataSets(Reader& reader) {
  std::vector<TicketRange> data_sets(reader.Count(2 * sizeof(std::uint64_t)));
  std::uint64_t expected = 0;
  for (TicketRange& range : data_sets) {
    range.first = reader.Number<std::uint64_t>();
    range.last = reader.Number<std::uint64_t>();
    if (range.first != expected || range.last < range.first) {
      throw Error("its data sets do not follow each other");
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
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == kEnding) paths.push_back(entry.path());
  }
  std::ranges::sort(paths, std::greater());
  return paths;
}

}  // namespace

std::vector<std::uint8_t> Serialize(const Checkpoint& checkpoint) {
  Writer writer;
  writer.Bytes(BytesOf(kMagic));
  writer.Number<std::uint32_t>(0);  // the checksum, once the rest is known
  writer.Count(checkpoint.data_sets.size());
  for (const TicketRange& range : checkpoint.data_sets) {
    writer.Number(range.first);
    writer.Number(range.last);
  }
  const TrainerState& trainer = checkpoint.trainer;
  writer.Number(trainer.optimizer_steps);
  writer.Number(trainer.samples_seen);
  const std::vector<std::uint8_t> weights = Serialize(trainer.weights);
  writer.Count(weights.size());
  writer.Bytes(weights);
  writer.Count(trainer.optimizer.size());
  for (const NamedArray& array : trainer.optimizer) writer.Array(array);
  std::vector<std::uint8_t>& bytes = writer.bytes();
  const std::uint32_t checksum = Crc32c(std::span(bytes).subspan(kHeaderBytes));
  std::memcpy(bytes.data() + kMagic.size(), &checksum, sizeof(checksum));
  return std::move(bytes);
}

Checkpoint DeserializeCheckpoint(std::span<const std::uint8_t> bytes) {
  Reader reader(bytes);
  if (!std::ranges::equal(reader.Bytes(kMagic.size()), BytesOf(kMagic))) {
    throw Error("it is not a checkpoint of this format");
  }
  if (reader.Number<std::uint32_t>() != Crc32c(bytes.subspan(kHeaderBytes))) {
    throw Error("its checksum is wrong: it is damaged or truncated");
  }
  Checkpoint checkpoint;
  checkpoint.data_sets = ReadDataSets(reader);
  checkpoint.trainer.optimizer_steps = reader.Number<std::uint64_t>();
  checkpoint.trainer.samples_seen = reader.Number<std::uint64_t>();
  checkpoint.trainer.weights = Deserialize(reader.Bytes(reader.Count(1)));
  const std::size_t arrays = reader.Count(1);
  for (std::size_t i = 0; i < arrays; ++i) checkpoint.trainer.optimizer.push_back(reader.Array());
  if (!reader.done()) throw Error("something follows its end");
  return checkpoint;
}

CheckpointFolder::CheckpointFolder(fs::path folder, int kept)
    : folder_(std::move(folder)), kept_(static_cast<std::size_t>(kept)) {
  CHECK(kept > 0);
  PrepareFolder(folder_);
}

std::optional<Checkpoint> CheckpointFolder::LoadNewest() const {
  for (const fs::path& path : NewestFirst(folder_)) {
    try {
      return DeserializeCheckpoint(ReadFileBytes(path));
    } catch (const Error& error) {
      log::Warn("checkpoint skipped", "file", path.string(), "reason", error.what());
    }
  }
  return std::nullopt;
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
