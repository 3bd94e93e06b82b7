// Checkpoints as a disk may give them back, with a checksum that fits, so that the rest is looked
// at: what is read comes back from its own bytes, or there is an Error.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "learner/train/checkpoint.h"
#include "tests/fuzz/byte_source.h"

namespace powderkeg {
namespace {

using Bytes = std::vector<std::uint8_t>;

// With a network that is as small as can be.
Bytes WholeCheckpoint() {
  NetworkDescription network;
  network.stem_channels = 1;
  network.value_hidden = 1;
  network.policy_channels = 1;
  Checkpoint checkpoint;
  checkpoint.data_sets = {{.first = 0, .last = 4}, {.first = 5, .last = 9}};
  checkpoint.trainer.weights = InitialWeights(network, Rng(1));
  checkpoint.trainer.optimizer = {{.name = "a.exp_avg", .shape = {2, 2}, .values = {1, 2, 3, 4}}};
  checkpoint.table = "iteration,games\n1,5\n2,5\n";
  return Serialize(checkpoint);
}

void Seal(Bytes& bytes) {
  constexpr std::string_view kMark = "PKCHECK2";
  constexpr std::size_t kHeader = kMark.size() + sizeof(std::uint32_t);
  if (bytes.size() < kHeader) return;
  std::memcpy(bytes.data(), kMark.data(), kMark.size());
  const std::uint32_t checksum = Crc32c(std::span(bytes).subspan(kHeader));
  std::memcpy(bytes.data() + kMark.size(), &checksum, sizeof checksum);
}

}  // namespace
}  // namespace powderkeg

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace powderkeg;
  static const Bytes whole = WholeCheckpoint();
  ByteSource source(data, size);
  Bytes bytes;
  if (source.Next() % 2 == 0) {
    const std::string_view rest = source.Rest();
    bytes.assign(rest.begin(), rest.end());
  } else {
    bytes = whole;
    Damage(source, bytes);
  }
  Seal(bytes);
  try {
    CHECK(Serialize(DeserializeCheckpoint(bytes)) == bytes);
  } catch (const Error&) {
  }
  return 0;
}
