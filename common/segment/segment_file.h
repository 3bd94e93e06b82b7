#pragma once

// Segments as HDF5 files: what the learner stores games in, and what other programs read.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "common/record/game_record.h"

namespace powderkeg {

// A segment holds typed little-endian arrays, contiguous and uncompressed: those listed in
// segment_columns.h (n, or n x k values where a row has k values), each with its meaning as
// attribute `description`, and `evaluators`, zero-padded strings of one length. The file's
// attribute `powderkeg_format` is kSegmentFormat. In Python:
// h5py.File(path)["decisions/visits"][:].
//
// HDF5 is not thread-safe: one thread of a process at a time may call these functions.

// The bytes of the file. Made in memory: the errors of a disk are met by whoever writes them.
[[nodiscard]] std::vector<std::uint8_t> EncodeSegment(std::span<const GameRecord> games);

// Calls `visit` for each game in order (the games themselves are not verified). Throws Error that
// names the file and says what is wrong; some games may have been visited by then.
void ReadSegment(const std::filesystem::path& path, const std::function<void(GameRecord&&)>& visit);

// The tickets of the games, in order, without reading the rest: what a restart needs of games that
// were used long ago. Throws Error as ReadSegment.
[[nodiscard]] std::vector<std::uint64_t> ReadTickets(const std::filesystem::path& path);

}  // namespace powderkeg
