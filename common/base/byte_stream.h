#pragma once

// Numbers to bytes and back, for our own file formats: little-endian, nothing aligned or padded,
// floats as IEEE 754.

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/base/check.h"

namespace powderkeg {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

template <typename T>
concept ByteNumber = std::is_arithmetic_v<T> && !std::same_as<T, bool>;

// One thread.
class ByteWriter {
 public:
  template <ByteNumber T>
  void Write(T value) {
    WriteAll(std::span<const T>(&value, 1));
  }
  template <ByteNumber T>
  void WriteAll(std::span<const T> values) {
    const auto* first = reinterpret_cast<const std::uint8_t*>(values.data());
    bytes_.insert(bytes_.end(), first, first + values.size_bytes());
  }
  [[nodiscard]] std::vector<std::uint8_t> Take() { return std::exchange(bytes_, {}); }

 private:
  std::vector<std::uint8_t> bytes_;
};

// Trusts no byte: every length is checked against what is left before memory is taken. Each method
// throws Error at the end of the bytes. One thread; `bytes` must outlive it.
class ByteReader {
 public:
  // `what` is read, for messages: "weights".
  ByteReader(std::string what, std::span<const std::uint8_t> bytes)
      : what_(std::move(what)), bytes_(bytes) {}

  template <ByteNumber T>
  T Read() {
    T value;
    ReadAll(std::span<T>(&value, 1));
    return value;
  }
  template <ByteNumber T>
  void ReadAll(std::span<T> values) {
    const std::span<const std::uint8_t> bytes = Bytes(values.size_bytes());
    if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  }
  // The next `count` numbers.
  template <ByteNumber T>
  std::vector<T> ReadVector(std::size_t count) {
    Require(count, sizeof(T));
    std::vector<T> values(count);
    ReadAll(std::span<T>(values));
    return values;
  }
  std::string ReadString(std::size_t size) {
    const std::span<const std::uint8_t> bytes = Bytes(size);
    return {bytes.begin(), bytes.end()};
  }
  // The next bytes themselves.
  std::span<const std::uint8_t> Bytes(std::size_t size) {
    Require(size, 1);
    const std::span<const std::uint8_t> bytes = bytes_.first(size);
    bytes_ = bytes_.subspan(size);
    return bytes;
  }
  // A count as `T` of things that take `bytes_each` or more.
  template <std::unsigned_integral T>
  std::size_t ReadCount(std::size_t bytes_each) {
    const T count = Read<T>();
    Require(count, bytes_each);
    return static_cast<std::size_t>(count);
  }
  // Throws if something is left.
  void ExpectEnd() const {
    if (!bytes_.empty()) throw Error(StrCat(what_, ": ", bytes_.size(), " bytes after the end"));
  }

 private:
  void Require(std::uint64_t count, std::size_t bytes_each) const {
    if (count <= bytes_.size() / bytes_each) return;
    throw Error(StrCat(what_, ": truncated, ", bytes_.size(), " bytes left where ", count,
                       bytes_each == 1 ? "" : StrCat(" times ", bytes_each), " are needed"));
  }

  std::string what_;
  std::span<const std::uint8_t> bytes_;
};

}  // namespace powderkeg
