#include <fcntl.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <system_error>

#include "common/base/check.h"
#include "common/base/descriptors.h"
#include "common/base/durable_file.h"
#include "common/wire/keys.h"

namespace powderkeg {
namespace {

constexpr std::size_t kKeyLength = 40;
constexpr std::size_t kKeyBytes = 32;

bool IsKey(const std::string& text) {
  std::array<std::uint8_t, kKeyBytes> bytes{};
  return text.size() == kKeyLength && zmq_z85_decode(bytes.data(), text.c_str()) != nullptr;
}

std::optional<std::string> KeyIn(const std::filesystem::path& file) {
  std::string line;
  std::ifstream input(file);
  if (!std::getline(input, line) || !IsKey(line)) return std::nullopt;
  return line;
}

void WriteNew(const std::filesystem::path& file, const std::string& line, mode_t mode) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  const std::string text = line + "\n";
  const bool ok = descriptor >= 0 &&
                  write(descriptor, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  if (descriptor >= 0) close(descriptor);
  if (!ok) throw Error(StrCat("cannot write key ", file, ": ", std::strerror(error)));
}

}  // namespace

CurveKeyPair MakeKeyPair() {
  std::array<char, kKeyLength + 1> public_key{};
  std::array<char, kKeyLength + 1> secret_key{};
  if (zmq_curve_keypair(public_key.data(), secret_key.data()) != 0) {
    throw Error("cannot make keys: this libzmq was built without CURVE");
  }
  return {.public_key = public_key.data(), .secret_key = secret_key.data()};
}

void WriteKeyPair(const CurveKeyPair& pair, const std::filesystem::path& file) {
  CreateFolder(file.parent_path());
  WriteNew(file.string() + ".secret", pair.secret_key, 0600);
  WriteNew(file.string() + ".public", pair.public_key, 0644);
}

std::string ReadKey(const std::filesystem::path& file) {
  std::optional<std::string> key = KeyIn(file);
  if (!key) {
    throw Error(StrCat("cannot read key ", file, "; expected one line of 40 Z85 characters"));
  }
  return *std::move(key);
}

ClientKeys ReadClientKeys(const std::filesystem::path& folder, const std::string& name) {
  return {.learner_public = ReadKey(folder / "learner.public"),
          .own = {.public_key = ReadKey(folder / "actors" / (name + ".public")),
                  .secret_key = ReadKey(folder / "actors" / (name + ".secret"))}};
}

std::optional<std::string> KeyFolder::ActorOf(const std::string& public_key) {
  const ReservedDescriptors reserved;
  const auto begin = std::chrono::steady_clock::now();
  auto name = Known(public_key);
  if (name || begin < next_read_) return name;
  Read();
  const auto end = std::chrono::steady_clock::now();
  next_read_ = end + 9 * (end - begin);
  return Known(public_key);
}

void KeyFolder::Read() {
  names_.clear();
  std::error_code error;
  for (const auto& file : std::filesystem::directory_iterator(actors_, error)) {
    if (file.path().extension() != ".public" || !file.is_regular_file(error)) continue;
    if (const auto key = KeyIn(file.path())) names_.emplace(*key, file.path().stem().string());
  }
}

std::optional<std::string> KeyFolder::Known(const std::string& public_key) const {
  const auto found = names_.find(public_key);
  if (found == names_.end()) return std::nullopt;
  const std::filesystem::path file = actors_ / (found->second + ".public");
  std::error_code error;
  const bool there = std::filesystem::is_regular_file(file, error) && KeyIn(file) == public_key;
  return there ? std::optional(found->second) : std::nullopt;
}

}  // namespace powderkeg
