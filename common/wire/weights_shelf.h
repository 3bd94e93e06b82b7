#pragma once

// Weights of several versions side by side: packed, as the learner hands them out, or loaded, as an
// actor plays by them.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "common/model/weights_snapshot.h"
#include "common/wire/codec.h"
#include "common/wire/messages.h"

namespace powderkeg {

// A serialised snapshot and what it is offered as. Immutable.
struct PackedWeights {
  WeightsOffer offer;
  std::vector<std::uint8_t> bytes;
};
using Packed = std::shared_ptr<const PackedWeights>;

// `bytes` is a serialised snapshot of this version; that is not checked. Throws Error if it is too
// large for the wire.
[[nodiscard]] Packed Pack(std::uint32_t version, std::vector<std::uint8_t> bytes);

// Whether these are the very bytes of the offer.
[[nodiscard]] bool IsWhole(const WeightsOffer& offer, std::span<const std::uint8_t> bytes);
// Whole bytes as weights to play by, or why they are no use.
[[nodiscard]] Decoded<Snapshot> Unpack(const WeightsOffer& offer,
                                       std::span<const std::uint8_t> bytes);

// Shared pointers to weights by version: beyond `capacity` (at least 1) those go that were not used
// for longest. One thread.
template <typename Weights>
class WeightsShelf {
 public:
  explicit WeightsShelf(std::size_t capacity) : capacity_(std::max<std::size_t>(capacity, 1)) {}

  void Put(std::uint32_t version, Weights weights) {
    std::erase_if(entries_, [&](const auto& entry) { return entry.first == version; });
    if (entries_.size() == capacity_) entries_.pop_back();
    entries_.insert(entries_.begin(), {version, std::move(weights)});
  }
  // Null if it is not there. Counts as use.
  [[nodiscard]] Weights Find(std::uint32_t version) {
    const auto found =
        std::ranges::find(entries_, version, [](const auto& entry) { return entry.first; });
    if (found == entries_.end()) return nullptr;
    std::rotate(entries_.begin(), found, found + 1);
    return entries_.front().second;
  }
  void Clear() { entries_.clear(); }

 private:
  const std::size_t capacity_;
  std::vector<std::pair<std::uint32_t, Weights>> entries_;  // used last first
};

}  // namespace powderkeg
