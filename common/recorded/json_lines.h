#pragma once

// Text files of one JSON object per line, plain or gzip.

#include <memory>
#include <string>

namespace powderkeg {

// Reads .jsonl and .jsonl.gz alike. One thread.
class LineReader {
 public:
  // Throws Error if the file cannot be opened.
  explicit LineReader(const std::string& path);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  // The next line without its end; false at the end of the file. Throws Error on a damaged file.
  bool Next(std::string& line);
  // Number of the line read last, from 1.
  [[nodiscard]] int line_number() const { return line_number_; }

 private:
  struct File;
  std::unique_ptr<File> file_;
  int line_number_ = 0;
};

}  // namespace powderkeg
