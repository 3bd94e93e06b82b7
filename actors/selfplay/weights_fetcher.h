#pragma once

// An actor's weights: the newest, and the past ones that its games need.

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/model/weights_snapshot.h"
#include "common/wire/messages.h"
#include "common/wire/waker.h"
#include "common/wire/weights_shelf.h"

namespace powderkeg {

// Where the weights of one version are.
struct WantedWeights {
  Snapshot snapshot{};  // null: not here
  std::string fault{};  // not empty: they will not come, and why
};

// Downloads one version at a time, chunk by chunk, the newest before past ones; goes on where it
// was on the next connection. What is damaged is fetched again a few times; what is whole and no
// use, or gone, is not asked for again on the same connection. Returns messages, sends nothing. The
// first three methods are thread-safe, the rest is one thread's.
class WeightsFetcher {
 public:
  using Clock = std::chrono::steady_clock;

  // Keeps up to `kept` versions besides the newest. `waker`, which must outlive it, is notified
  // when there is something new to fetch.
  WeightsFetcher(std::size_t kept, const Waker& waker) : waker_(waker), shelf_(kept + 1) {}

  // Whole and checked; null before the first.
  [[nodiscard]] Snapshot newest() const;
  // Whether the learner has said that there are none yet.
  [[nodiscard]] bool none_yet() const;
  // Asks for a version, unless it is here; does not wait.
  [[nodiscard]] WantedWeights Want(std::uint32_t version);

  // A fresh connection is made.
  void StartAnew();
  // The learner's run is this one. What is here of another goes; the newest serves until the
  // learner offers its own.
  void ServeRun(const std::string& run_id);
  void Handle(const WeightsOffer& offer);
  void Handle(const WeightsChunk& chunk);
  void Handle(const WeightsReceipt& receipt);
  // What is to be sent: nothing while an answer is on its way.
  [[nodiscard]] std::optional<WeightsRequest> NextRequest(Clock::time_point now);
  // Since when an answer is on its way; nullopt: none is.
  [[nodiscard]] std::optional<Clock::time_point> asked_at() const { return asked_at_; }

  // Counts what Want, newest and none_yet would say differently now.
  [[nodiscard]] std::uint64_t changes() const { return changes_; }

 private:
  struct Download {
    WeightsOffer offer;                 // of a past version only its number, before the first chunk
    std::vector<std::uint8_t> bytes{};  // so far
    int damaged = 0;                    // times that they had to be fetched anew
  };

  void Forget();
  [[nodiscard]] std::optional<Download> NextDownload();
  void Retry(const std::string& fault);
  void Finish();
  void Fail(const std::string& fault);

  const Waker& waker_;

  // The io thread's.
  std::string run_id_;
  std::optional<WeightsOffer> offered_;  // as newest
  std::optional<WeightsOffer> held_;     // what newest_ was offered as
  std::optional<Download> download_;
  std::optional<Clock::time_point> asked_at_;
  std::uint64_t receipt_ = 0;
  std::uint64_t changes_ = 0;

  mutable std::mutex mutex_;  // guards these
  Snapshot newest_;
  bool none_yet_ = false;
  WeightsShelf<Snapshot> shelf_;
  std::set<std::uint32_t> wanted_;
  std::map<std::uint32_t, std::string> faults_;  // by version
};

}  // namespace powderkeg
