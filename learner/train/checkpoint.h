#pragma once

// The state of training on disk: all that a restart needs besides the games.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "learner/replay/prefix.h"
#include "learner/train/trainer_state.h"

namespace powderkeg {

// After a completed iteration (their number is that of the data sets). The generators of later
// iterations follow from the run's seed and the iteration, so none is stored. A value.
struct Checkpoint {
  std::vector<TicketRange> data_sets;  // of every completed iteration; they follow each other
  TrainerState trainer;
  std::string table;  // of the iterations, as the hook iteration_trained gave it

  [[nodiscard]] int iteration() const { return static_cast<int>(data_sets.size()); }
  friend bool operator==(const Checkpoint&, const Checkpoint&) = default;
};

// Little-endian bytes with a CRC-32C of all that follows it (format: checkpoint.cc).
[[nodiscard]] std::vector<std::uint8_t> Serialize(const Checkpoint& checkpoint);
// Throws Error that says what is wrong.
[[nodiscard]] Checkpoint DeserializeCheckpoint(std::span<const std::uint8_t> bytes);

// What a run can start from: a .checkpoint file with its optimizer, or a model (LoadModel), which
// has none. Version 1, no canary. Throws Error.
[[nodiscard]] TrainerState LoadFirstState(const std::string& name);

// A folder of checkpoints `iteration-<number>.checkpoint`. One thread.
class CheckpointFolder {
 public:
  // Keeps the newest `kept` (at least 1). Creates the folder if missing. Throws Error.
  CheckpointFolder(std::filesystem::path folder, int kept);

  // The checkpoint of the latest iteration that can be read; damaged ones are skipped with a
  // warning. nullopt if there is no checkpoint. Throws Error if there are some and none can be
  // read: to train anew without a word would throw the run's iterations away.
  [[nodiscard]] std::optional<Checkpoint> LoadNewest() const;

  // Durable when it returns; then deletes all but the `kept` checkpoints up to this
  // one. Throws Error.
  void Save(const Checkpoint& checkpoint);

 private:
  std::filesystem::path folder_;
  std::size_t kept_;
};

}  // namespace powderkeg
