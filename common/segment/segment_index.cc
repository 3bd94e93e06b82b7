#include "common/segment/segment_index.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "common/base/byte_stream.h"
#include "common/base/check.h"
#include "common/base/digest.h"

// Format of one index, after which comes the next or the end of the file:
//   u64 bytes of the HDF5 part, u32 CRC-32C of it
//   u64 number of games, u64 ticket each
//   u64 number of evaluators, each u64 length and its name
//   u64 number of columns, each u64 offset in the file, u64 rows
//   u64 bytes of all that, u32 CRC-32C of it, "PKINDEX3"
namespace powderkeg {
namespace {

constexpr std::string_view kMark = "PKINDEX3";

using Count = std::uint64_t;

static_assert(kIndexEndBytes == sizeof(Count) + sizeof(std::uint32_t) + kMark.size());

SegmentIndex Parse(std::span<const std::uint8_t> bytes) {
  ByteReader in("index", bytes);
  SegmentIndex index;
  index.hdf5_bytes = in.Read<std::uint64_t>();
  in.Read<std::uint32_t>();
  index.tickets = in.ReadVector<std::uint64_t>(in.ReadCount<Count>(sizeof(std::uint64_t)));
  index.evaluators.resize(in.ReadCount<Count>(sizeof(Count)));
  for (std::string& name : index.evaluators) name = in.ReadString(in.ReadCount<Count>(1));
  index.places.resize(in.ReadCount<Count>(2 * sizeof(std::uint64_t)));
  for (SegmentIndex::Place& place : index.places) {
    place.offset = in.Read<std::uint64_t>();
    place.rows = in.Read<std::uint64_t>();
  }
  in.ExpectEnd();
  return index;
}

}  // namespace

std::vector<std::uint8_t> EndingOf(const SegmentIndex& index, std::span<const std::uint8_t> hdf5) {
  ByteWriter out;
  out.Write(std::uint64_t{hdf5.size()});
  out.Write(Crc32c(hdf5));
  out.Write(Count{index.tickets.size()});
  out.WriteAll(std::span<const std::uint64_t>(index.tickets));
  out.Write(Count{index.evaluators.size()});
  for (const std::string& name : index.evaluators) {
    out.Write(Count{name.size()});
    out.WriteAll(BytesOf(name));
  }
  out.Write(Count{index.places.size()});
  for (const SegmentIndex::Place& place : index.places) {
    out.Write(place.offset);
    out.Write(place.rows);
  }
  const std::vector<std::uint8_t> bytes = out.Take();
  for (int copy = 0; copy < 2; ++copy) {
    out.WriteAll(std::span(bytes));
    out.Write(Count{bytes.size()});
    out.Write(Crc32c(bytes));
    out.WriteAll(BytesOf(kMark));
  }
  return out.Take();
}

std::optional<std::uint64_t> IndexBytes(std::span<const std::uint8_t> end) {
  if (end.size() < kIndexEndBytes || !std::ranges::equal(end.last(kMark.size()), BytesOf(kMark)))
    return std::nullopt;
  return ByteReader("index", end.last(kIndexEndBytes)).Read<Count>() + kIndexEndBytes;
}

std::optional<SegmentIndex> IndexAtEnd(std::span<const std::uint8_t> bytes) {
  const auto size = IndexBytes(bytes);
  if (!size || *size > bytes.size() || *size < kIndexEndBytes) return std::nullopt;
  const auto index = bytes.last(*size).first(*size - kIndexEndBytes);
  ByteReader checksum("index", bytes.last(sizeof(std::uint32_t) + kMark.size()));
  if (checksum.Read<std::uint32_t>() != Crc32c(index)) return std::nullopt;
  return Parse(index);
}

FoundIndex FindIndex(std::span<const std::uint8_t> file) {
  std::optional<SegmentIndex> index = IndexAtEnd(file);
  for (std::span<const std::uint8_t> rest = file; !index;) {
    const auto mark = std::find_end(rest.begin(), rest.end(), kMark.begin(), kMark.end());
    if (mark == rest.end()) return {};
    index = IndexAtEnd({rest.begin(), mark + kMark.size()});
    rest = {rest.begin(), mark};
  }
  const std::size_t hdf5 = std::min<std::size_t>(index->hdf5_bytes, file.size());
  const bool as_written =
      std::ranges::equal(file.subspan(hdf5), EndingOf(*index, file.first(hdf5)));
  return {.index = std::move(index), .as_written = as_written};
}

}  // namespace powderkeg
