#include "common/recorded/json_lines.h"

#include <zlib.h>

#include <array>

#include "common/base/check.h"

namespace powderkeg {

struct LineReader::File {
  gzFile handle;
};

LineReader::LineReader(const std::string& path) : file_(std::make_unique<File>()) {
  file_->handle = gzopen(path.c_str(), "rb");
  if (file_->handle == nullptr) throw Error(StrCat("cannot open ", path));
  gzbuffer(file_->handle, 1 << 17);
}

LineReader::~LineReader() { gzclose(file_->handle); }

bool LineReader::Next(std::string& line) {
  line.clear();
  std::array<char, 1 << 16> part;
  while (gzgets(file_->handle, part.data(), static_cast<int>(part.size())) != nullptr) {
    line += part.data();
    if (!line.empty() && line.back() == '\n') {
      line.pop_back();
      ++line_number_;
      return true;
    }
  }
  int code = Z_OK;
  const char* reason = gzerror(file_->handle, &code);  // begins with the path
  if (code != Z_OK && code != Z_STREAM_END) {
    throw Error(StrCat("cannot read line ", line_number_ + 1, " of ", reason));
  }
  if (line.empty()) return false;
  ++line_number_;
  return true;
}

}  // namespace powderkeg
