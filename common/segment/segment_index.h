#pragma once

// What stands behind the HDF5 part of a segment: how the games are found without that library, and
// which games there are, whatever is damaged.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace powderkeg {

struct SegmentIndex {
  struct Place {
    std::uint64_t offset = 0;  // in the file
    std::uint64_t rows = 0;

    friend bool operator==(const Place&, const Place&) = default;
  };
  std::vector<std::uint64_t> tickets;  // of the games, in order
  std::vector<std::string> evaluators;
  std::vector<Place> places = {};  // of the columns, in the order of segment_columns.h
  std::uint64_t hdf5_bytes = 0;    // what stands before

  friend bool operator==(const SegmentIndex&, const SegmentIndex&) = default;
};

// What follows `hdf5` in the file: the index, which gets the size and checksum of that, twice.
[[nodiscard]] std::vector<std::uint8_t> EndingOf(const SegmentIndex& index,
                                                 std::span<const std::uint8_t> hdf5);

// How long the index is that ends a file, of which `end` are the last kIndexEndBytes; nullopt:
// these are damaged.
inline constexpr std::size_t kIndexEndBytes = 20;
[[nodiscard]] std::optional<std::uint64_t> IndexBytes(std::span<const std::uint8_t> end);

// The index that `bytes` end in; nullopt: it is damaged.
[[nodiscard]] std::optional<SegmentIndex> IndexAtEnd(std::span<const std::uint8_t> bytes);

struct FoundIndex {
  std::optional<SegmentIndex> index;
  bool as_written = false;  // the file is, every byte of it
};
// The last index in the file that is whole, if there is one.
[[nodiscard]] FoundIndex FindIndex(std::span<const std::uint8_t> file);

}  // namespace powderkeg
