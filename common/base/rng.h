#pragma once

// Random numbers that are the same on every machine and with every standard library.

#include <cstdint>
#include <span>
#include <utility>

namespace powderkeg {

// SplitMix64 (Steele, Lea, Flood 2014) with own distributions. A value of 8 bytes: a copy continues
// the same stream. Not for cryptography. One thread per object.
class Rng {
 public:
  explicit constexpr Rng(std::uint64_t seed = 0) : state_(seed) {}

  // The next 64 bits.
  constexpr std::uint64_t Next() {
    state_ += 0x9E3779B97F4A7C15u;
    return Mix(state_);
  }

  // Uniform in [0, bound), without bias (Lemire 2019). Requires bound > 0.
  constexpr std::uint32_t Below(std::uint32_t bound) {
    std::uint64_t product = (Next() >> 32) * bound;
    if (static_cast<std::uint32_t>(product) < bound) [[unlikely]] {
      const std::uint32_t threshold = (0u - bound) % bound;
      while (static_cast<std::uint32_t>(product) < threshold) product = (Next() >> 32) * bound;
    }
    return static_cast<std::uint32_t>(product >> 32);
  }

  // Uniform in [0, 1), a multiple of 2^-53.
  constexpr double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }

  // An independent generator for one purpose; does not advance this one.
  [[nodiscard]] constexpr Rng Split(std::uint64_t purpose) const {
    return Rng(Mix(state_ ^ Mix(purpose + 0xD1B54A32D192ED03u)));
  }

  // Uniformly random order (Fisher-Yates, from the back).
  template <typename T>
  constexpr void Shuffle(std::span<T> values) {
    for (std::size_t i = values.size(); i > 1; --i) {
      std::swap(values[i - 1], values[Below(static_cast<std::uint32_t>(i))]);
    }
  }

  // Gamma(shape, 1), shape > 0 (Marsaglia, Tsang 2000); the base of Dirichlet noise.
  double Gamma(double shape);
  // Standard normal (Marsaglia's polar method, one value per call).
  double Normal();

  [[nodiscard]] constexpr std::uint64_t state() const { return state_; }

  friend constexpr bool operator==(const Rng&, const Rng&) = default;

 private:
  static constexpr std::uint64_t Mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

}  // namespace powderkeg
