#include "common/wire/weights_shelf.h"

#include "common/base/check.h"

namespace powderkeg {

Packed Pack(std::uint32_t version, std::vector<std::uint8_t> bytes) {
  if (bytes.size() > kMaxWeightsBytes) {
    throw Error(StrCat("weights of ", bytes.size(), " bytes; expected at most ", kMaxWeightsBytes));
  }
  const WeightsOffer offer{.version = version, .size_bytes = bytes.size(), .sha256 = Sha256(bytes)};
  return std::make_shared<const PackedWeights>(
      PackedWeights{.offer = offer, .bytes = std::move(bytes)});
}

bool IsWhole(const WeightsOffer& offer, std::span<const std::uint8_t> bytes) {
  return bytes.size() == offer.size_bytes && Sha256(bytes) == offer.sha256;
}

Decoded<Snapshot> Unpack(const WeightsOffer& offer, std::span<const std::uint8_t> bytes) {
  try {
    auto snapshot = std::make_shared<const WeightsSnapshot>(Deserialize(bytes));
    if (snapshot->version == offer.version) return Snapshot(std::move(snapshot));
    return Malformed{StrCat("they are of version ", snapshot->version)};
  } catch (const Error& error) {
    return Malformed{error.what()};
  }
}

}  // namespace powderkeg
