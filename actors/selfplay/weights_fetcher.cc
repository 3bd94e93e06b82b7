#include "actors/selfplay/weights_fetcher.h"

#include <utility>
#include <variant>

#include "common/base/log.h"

namespace powderkeg {
namespace {

constexpr int kMostDamaged = 3;

}  // namespace

Snapshot WeightsFetcher::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

bool WeightsFetcher::none_yet() const {
  const std::lock_guard lock(mutex_);
  return none_yet_;
}

WantedWeights WeightsFetcher::Want(std::uint32_t version) {
  const std::lock_guard lock(mutex_);
  if (Snapshot snapshot = shelf_.Find(version)) return {.snapshot = std::move(snapshot)};
  const auto fault = faults_.find(version);
  if (fault != faults_.end()) return {.fault = fault->second};
  if (wanted_.insert(version).second) waker_.Notify();
  return {};
}

void WeightsFetcher::Forget() {
  offered_.reset();
  held_.reset();
  download_.reset();
  const std::lock_guard lock(mutex_);
  shelf_.Clear();
  wanted_.clear();
  faults_.clear();
}

void WeightsFetcher::StartAnew() {
  asked_at_.reset();
  receipt_ = 0;
  const std::lock_guard lock(mutex_);
  faults_.clear();
}

void WeightsFetcher::ServeRun(const std::string& run_id) {
  if (run_id != std::exchange(run_id_, run_id)) Forget();
}

void WeightsFetcher::Handle(const WeightsOffer& offer) {
  // Equal or lower versions of other weights: past ones would be others too.
  const bool rewritten = held_ && offer.version <= held_->version && offer != *held_;
  if (rewritten) Forget();
  if (offered_ != offer) download_.reset();
  offered_ = offer;
  if (offer.version > 0) return;
  ++changes_;
  const std::lock_guard lock(mutex_);
  newest_ = nullptr;
  none_yet_ = true;
}

std::optional<WeightsRequest> WeightsFetcher::NextRequest(Clock::time_point now) {
  if (asked_at_) return std::nullopt;
  if (!download_) download_ = NextDownload();
  if (!download_) return std::nullopt;
  asked_at_ = now;
  return WeightsRequest{.version = download_->offer.version,
                        .offset_bytes = download_->bytes.size(),
                        .receipt = receipt_};
}

std::optional<WeightsFetcher::Download> WeightsFetcher::NextDownload() {
  const std::lock_guard lock(mutex_);
  if (offered_ && offered_->version > 0 && offered_ != held_ &&
      !faults_.contains(offered_->version)) {
    return Download{.offer = *offered_};
  }
  if (wanted_.empty()) return std::nullopt;
  return Download{.offer = {.version = *wanted_.begin()}};
}

void WeightsFetcher::Handle(const WeightsReceipt& receipt) {
  asked_at_.reset();
  receipt_ = receipt.receipt;
}

void WeightsFetcher::Handle(const WeightsChunk& chunk) {
  if (!download_ || chunk.offer.version != download_->offer.version ||
      chunk.offset_bytes != download_->bytes.size()) {
    return;  // of a download that was given up
  }
  if (download_->offer.size_bytes == 0) download_->offer = chunk.offer;
  if (chunk.data.empty()) {
    Fail("the learner does not have them any more");
  } else if (chunk.offer != download_->offer) {
    Retry("they are other than was said, again and again");
  } else {
    download_->bytes.insert(download_->bytes.end(), chunk.data.begin(), chunk.data.end());
    if (download_->bytes.size() == download_->offer.size_bytes) Finish();
  }
}

// From the beginning: they may have been written anew meanwhile.
void WeightsFetcher::Retry(const std::string& fault) {
  const std::uint32_t version = download_->offer.version;
  if (++download_->damaged == kMostDamaged) return Fail(fault);
  download_->bytes.clear();
  download_->offer =
      offered_ && offered_->version == version ? *offered_ : WeightsOffer{.version = version};
}

void WeightsFetcher::Finish() {
  const WeightsOffer offer = download_->offer;
  if (!IsWhole(offer, download_->bytes)) {
    log::Warn("weights are damaged", "version", offer.version);
    return Retry("the SHA-256 does not fit, again and again");
  }
  Decoded<Snapshot> unpacked = Unpack(offer, download_->bytes);
  if (const auto* malformed = std::get_if<Malformed>(&unpacked)) return Fail(malformed->reason);
  log::Info("received weights", "version", offer.version, "bytes", offer.size_bytes);
  ++changes_;
  download_.reset();
  const std::lock_guard lock(mutex_);
  wanted_.erase(offer.version);
  if (held_) (void)shelf_.Find(held_->version);  // the newest is never the one to go
  shelf_.Put(offer.version, std::get<Snapshot>(unpacked));
  if (offer != offered_) return;
  held_ = offer;
  newest_ = std::get<Snapshot>(unpacked);
}

void WeightsFetcher::Fail(const std::string& fault) {
  const std::uint32_t version = download_->offer.version;
  log::Error("weights refused", "version", version, "reason", fault);
  ++changes_;
  download_.reset();
  const std::lock_guard lock(mutex_);
  wanted_.erase(version);
  faults_[version] = fault;
}

}  // namespace powderkeg
