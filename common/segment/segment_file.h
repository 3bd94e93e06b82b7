#pragma once

// Segments as HDF5 files: what the learner stores games in, and what other programs read.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/record/game_record.h"

namespace powderkeg {

// A segment holds typed little-endian arrays, contiguous and uncompressed: those listed in
// segment_columns.h (n, or n x k values where a row has k values), each with its meaning as
// attribute `description`, and `evaluators`, zero-padded strings of one length. The file's
// attribute `powderkeg_format` is kSegmentFormat. In Python:
// h5py.File(path)["decisions/visits"][:].
//
// Behind what HDF5 reads stands an index (segment_index.h), by which this program reads: a restart
// reads no more than it of games that were used long ago, and a damaged file loses only games whose
// own rows are hit.
//
// The bytes of the file. Made in memory: the errors of a disk are met by whoever writes them. HDF5
// is not thread-safe: one thread of a process at a time may call this.
[[nodiscard]] std::vector<std::uint8_t> EncodeSegment(std::span<const GameRecord> games);

struct SegmentDamage {
  std::string reason;  // empty: there is none
  // Tickets of the games that cannot be read; nullopt: nobody knows.
  std::optional<std::vector<std::uint64_t>> lost = std::vector<std::uint64_t>{};
};

// "3-5 9", "none" or "unknown".
[[nodiscard]] std::string LostText(const SegmentDamage& damage);

// Calls `visit` for each game that agrees with its checksum, in order (the games themselves are
// not verified). Throws Error that names the file if the file system does not give it or it is of
// another format.
[[nodiscard]] SegmentDamage ReadSegment(const std::filesystem::path& path,
                                        const std::function<void(GameRecord&&)>& visit);

// The tickets of the games, in order, without reading the rest; nullopt: they are damaged, or it is
// no such file. Throws Error as ReadSegment.
[[nodiscard]] std::optional<std::vector<std::uint64_t>> ReadTickets(
    const std::filesystem::path& path);

}  // namespace powderkeg
