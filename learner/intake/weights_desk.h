#pragma once

// The learner's weights for actors: the newest, and past ones that the run still keeps.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/wire/messages.h"
#include "common/wire/weights_shelf.h"

namespace powderkeg {

// The serialised snapshot of a past version; empty: it is gone. Called on the io thread.
using LoadWeights = std::function<std::vector<std::uint8_t>(std::uint32_t version)>;

// Answers with messages, sends nothing. Publish is thread-safe, the rest is one thread's.
class WeightsDesk {
 public:
  // Keeps up to `kept` past versions in memory; `load` may be empty.
  WeightsDesk(LoadWeights load, std::size_t kept) : load_(std::move(load)), past_(kept) {}

  // These are the newest from now on. Null: there are none yet. Throws Error if they are too large
  // for the wire.
  void Publish(const Snapshot& snapshot);

  // Whether something was published since the last call: what offer() says is news.
  [[nodiscard]] bool Refresh();
  // nullopt before the first Refresh that was true.
  [[nodiscard]] std::optional<WeightsOffer> offer() const;

  // The bytes asked for, or that they are gone: an encoded WeightsChunk.
  [[nodiscard]] std::shared_ptr<const std::string> Answer(const WeightsRequest& request);

 private:
  struct Encoded {
    std::uint32_t version;
    std::uint64_t offset_bytes;
    std::shared_ptr<const std::string> chunk;
  };

  [[nodiscard]] Packed Find(std::uint32_t version);
  [[nodiscard]] WeightsChunk ChunkOf(const WeightsRequest& request);

  const LoadWeights load_;
  Packed newest_;
  WeightsShelf<Packed> past_;
  std::deque<Encoded> encoded_;  // what was asked for last: many ask for the same
  std::mutex mutex_;             // guards published_
  Packed published_;
};

}  // namespace powderkeg
