#pragma once

// Finished games on disk, as HDF5 segments that other programs can read.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "common/record/game_record.h"
#include "common/segment/segment_file.h"

namespace powderkeg {

// A folder of segments `segment-<number>.h5`, each a whole number of games. Segments appear whole
// (durable_file.h), as common/segment/segment_file.h specifies them, and are never changed. One
// thread (and one store at a time in a process, because of HDF5); one process at a time (the run's
// lock). Every method throws Error where the file system refuses, or a segment is of another
// format.
//
// Whoever reads a segment and finds it damaged writes a new one of the games that are whole,
// renames the damaged one (it keeps its name and gets the ending .damaged), and says so in the log.
class ReplayStore {
 public:
  // Creates the folder if missing and deletes temporaries that a crash has left.
  explicit ReplayStore(std::filesystem::path folder);

  // Writes the games as one segment, durable when it returns: only then acknowledge them. An empty
  // span writes nothing.
  void Append(std::span<const GameRecord> games);

  // Calls `visit` for the game of every ticket that is `wanted`, once. Of segments without a wanted
  // game the tickets alone are read. Returns the tickets of all stored games, each once.
  std::vector<std::uint64_t> Load(const std::function<bool(std::uint64_t)>& wanted,
                                  const std::function<void(GameRecord&&)>& visit);

  // Rewrites small segments as few: a merged segment first, then its originals go. Worth calling
  // once per iteration and when there are many; a crash in between leaves doubles, which Load
  // drops. Takes the memory of about two large segments.
  void Merge();

  // Removes segments, the oldest first, while all together are larger than `max_bytes`: as many as
  // hold no game that is `wanted`. A crash in between has removed some of them. How many were.
  std::size_t Trim(std::uint64_t max_bytes, const std::function<bool(std::uint64_t)>& wanted);

  // What Merge would work on.
  [[nodiscard]] std::size_t small_segment_count() const;

  // Tickets of the games that were lost in damaged segments since the store was opened.
  [[nodiscard]] const std::vector<std::uint64_t>& lost_tickets() const { return lost_; }

 private:
  struct Segment {
    std::uint64_t number;
    std::uint64_t bytes;
  };
  [[nodiscard]] std::filesystem::path PathOf(const Segment& segment) const;
  // Writes what is whole of them as one segment; then they go.
  void Rewrite(std::span<const Segment> originals);
  void SetAside(const std::filesystem::path& path, const SegmentDamage& damage);

  std::filesystem::path folder_;
  std::vector<Segment> segments_;  // ascending by number
  std::vector<std::uint64_t> lost_;
};

}  // namespace powderkeg
