#pragma once

// The training examples of the last data sets, in memory.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "common/base/rng.h"
#include "learner/replay/lessons.h"

namespace powderkeg {

// Holds whole data sets within a number and a budget of memory; the oldest go first, the newest
// stays whatever its size. About 400 bytes a sample. One thread.
class ReplayWindow {
 public:
  // Requires data_sets > 0.
  ReplayWindow(int data_sets, std::size_t max_bytes);

  void Push(std::vector<Sample> data_set);

  [[nodiscard]] std::size_t size() const { return ends_.empty() ? 0 : ends_.back(); }
  [[nodiscard]] std::size_t bytes() const { return size() * sizeof(Sample); }

  // Samples are numbered from the oldest data set to the newest. Requires index < size(). Valid
  // until the next Push.
  [[nodiscard]] const Sample& operator[](std::size_t index) const;
  // Every index once, in random order.
  [[nodiscard]] std::vector<std::uint32_t> ShuffledOrder(Rng& rng) const;

 private:
  void RenewEnds();

  std::size_t max_data_sets_;
  std::size_t max_bytes_;
  std::deque<std::vector<Sample>> data_sets_;
  std::vector<std::size_t> ends_;  // of each data set, the index after its last sample
};

}  // namespace powderkeg
