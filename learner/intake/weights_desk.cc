#include "learner/intake/weights_desk.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "common/base/log.h"

namespace powderkeg {
namespace {

constexpr std::size_t kEncodedKept = 16;

}  // namespace

void WeightsDesk::Publish(const Snapshot& snapshot) {
  Packed packed = snapshot ? Pack(snapshot->version, Serialize(*snapshot))
                           : std::make_shared<const PackedWeights>();
  const std::lock_guard lock(mutex_);
  published_ = std::move(packed);
}

bool WeightsDesk::Refresh() {
  const std::lock_guard lock(mutex_);
  if (!published_) return false;
  if (newest_ && newest_->offer.version > 0) past_.Put(newest_->offer.version, newest_);
  newest_ = std::exchange(published_, nullptr);
  encoded_.clear();
  return true;
}

std::optional<WeightsOffer> WeightsDesk::offer() const {
  return newest_ ? std::optional(newest_->offer) : std::nullopt;
}

std::shared_ptr<const std::string> WeightsDesk::Answer(const WeightsRequest& request) {
  const auto known = std::ranges::find_if(encoded_, [&](const Encoded& encoded) {
    return encoded.version == request.version && encoded.offset_bytes == request.offset_bytes;
  });
  if (known != encoded_.end()) return known->chunk;
  const WeightsChunk chunk = ChunkOf(request);
  auto answer = std::make_shared<const std::string>(Encode(chunk));
  if (chunk.data.empty()) return answer;  // it may be there one day
  if (encoded_.size() == kEncodedKept) encoded_.pop_front();
  encoded_.push_back({request.version, request.offset_bytes, answer});
  return answer;
}

WeightsChunk WeightsDesk::ChunkOf(const WeightsRequest& request) {
  WeightsChunk chunk{.offer = {.version = request.version}, .offset_bytes = request.offset_bytes};
  const Packed packed = Find(request.version);
  if (!packed || request.offset_bytes >= packed->bytes.size()) return chunk;
  chunk.offer = packed->offer;
  const auto begin = packed->bytes.begin() + static_cast<std::ptrdiff_t>(request.offset_bytes);
  const auto left = static_cast<std::size_t>(packed->bytes.end() - begin);
  chunk.data.assign(begin, begin + static_cast<std::ptrdiff_t>(std::min(left, kMaxChunkBytes)));
  return chunk;
}

// Null: gone.
Packed WeightsDesk::Find(std::uint32_t version) {
  if (version == 0) return nullptr;
  if (newest_ && newest_->offer.version == version) return newest_;
  if (Packed packed = past_.Find(version)) return packed;
  if (!load_) return nullptr;
  std::vector<std::uint8_t> bytes = load_(version);
  if (bytes.empty() || bytes.size() > kMaxWeightsBytes) return nullptr;
  Packed packed = Pack(version, std::move(bytes));
  past_.Put(version, packed);
  return packed;
}

}  // namespace powderkeg
