// Segments as a disk may give them back: any bytes, or a whole segment with other values here and
// there and cut off somewhere. What is read from the latter is what was stored.

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/base/check.h"
#include "common/segment/segment_file.h"
#include "tests/fuzz/byte_source.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

using Bytes = std::vector<std::uint8_t>;

// A file of these bytes in memory.
class MemoryFile {
 public:
  explicit MemoryFile(const Bytes& bytes) : file_(memfd_create("segment", 0)) {
    CHECK(write(file_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  }
  ~MemoryFile() { close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] std::filesystem::path path() const { return StrCat("/proc/self/fd/", file_); }

 private:
  int file_;
};

void Read(const Bytes& bytes, const std::vector<GameRecord>& stored) {
  const MemoryFile file(bytes);
  try {
    const auto tickets = ReadTickets(file.path());
    const SegmentDamage damage = ReadSegment(file.path(), [&](const GameRecord& game) {
      CHECK(stored.empty() || std::ranges::find(stored, game) != stored.end());
    });
    CHECK(damage.reason.find('\n') == std::string::npos && !LostText(damage).empty());
    CHECK(tickets || !damage.reason.empty());
  } catch (const Error&) {
  }
}

}  // namespace
}  // namespace powderkeg

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace powderkeg;
  static const std::vector<GameRecord> stored = RandomRecords(/*first_ticket=*/7, /*count=*/5);
  static const Bytes whole = EncodeSegment(stored);
  ByteSource source(data, size);
  if (source.Next() % 4 == 0) {
    const std::string_view rest = source.Rest();
    Read({rest.begin(), rest.end()}, {});
    return 0;
  }
  Bytes bytes = whole;
  bytes.resize(bytes.size() - (source.Next() < 0xc0 ? 0 : source.Below(bytes.size())));
  Damage(source, bytes);
  Read(bytes, stored);
  return 0;
}
