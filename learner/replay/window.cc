#include "learner/replay/window.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {

ReplayWindow::ReplayWindow(int data_sets, std::size_t max_bytes)
    : max_data_sets_(static_cast<std::size_t>(data_sets)), max_bytes_(max_bytes) {
  CHECK(data_sets > 0);
}

void ReplayWindow::Push(std::vector<Sample> data_set) {
  data_sets_.push_back(std::move(data_set));
  RenewEnds();
  while (data_sets_.size() > 1 && (data_sets_.size() > max_data_sets_ || bytes() > max_bytes_)) {
    data_sets_.pop_front();
    RenewEnds();
  }
}

void ReplayWindow::RenewEnds() {
  ends_.clear();
  std::size_t end = 0;
  for (const std::vector<Sample>& data_set : data_sets_) ends_.push_back(end += data_set.size());
}

const Sample& ReplayWindow::operator[](std::size_t index) const {
  DCHECK(index < size());
  const auto end = std::ranges::upper_bound(ends_, index);
  const std::vector<Sample>& data_set =
      data_sets_[static_cast<std::size_t>(std::distance(ends_.begin(), end))];
  return data_set[index + data_set.size() - *end];
}

std::vector<std::uint32_t> ReplayWindow::ShuffledOrder(Rng& rng) const {
  std::vector<std::uint32_t> order(size());
  std::iota(order.begin(), order.end(), 0U);
  rng.Shuffle(std::span(order));
  return order;
}

}  // namespace powderkeg
