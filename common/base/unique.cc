#include "common/base/unique.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <exception>
#include <random>
#include <string>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/log.h"

namespace powderkeg {
namespace {

std::string Drawn(const std::function<std::uint32_t()>& device) {
  std::array<std::uint32_t, 4> words{};
  for (std::uint32_t& word : words) word = device();
  if (words[0] == words[1] && words[2] == words[3]) throw Error("it repeats itself");
  return StrCat(words[0], ' ', words[1], ' ', words[2], ' ', words[3]);
}

// Empty if the device is no use.
std::string DrawnOrNothing(const std::function<std::uint32_t()>& device) {
  try {
    return Drawn(device ? device : [] { return std::random_device()(); });
  } catch (const std::exception& error) {
    log::Warn("no random device: names are made of time, process and host", "reason", error.what());
    return {};
  }
}

}  // namespace

std::string HostName() {
  std::array<char, 256> host{};
  return gethostname(host.data(), host.size() - 1) == 0 ? host.data() : "";
}

std::uint64_t UniqueNumber(const std::function<std::uint32_t()>& device) {
  static std::atomic<std::uint64_t> count = 0;
  const Sha256Digest digest = Sha256(BytesOf(StrCat(
      DrawnOrNothing(device), '/', std::chrono::system_clock::now().time_since_epoch().count(), '/',
      std::chrono::steady_clock::now().time_since_epoch().count(), '/', getpid(), '/', HostName(),
      '/', ++count)));
  std::uint64_t number = 0;
  std::memcpy(&number, digest.data(), sizeof number);
  return number;
}

}  // namespace powderkeg
