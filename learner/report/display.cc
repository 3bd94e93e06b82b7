#include "learner/report/display.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <chrono>
#include <iostream>

#include "learner/report/iteration_table.h"

namespace powderkeg {

Display::Display() : terminal_(isatty(STDOUT_FILENO) != 0) {}

void Display::ShowStatus(const LiveStatus& status) {
  const auto now = LiveLine::Clock::now();
  const std::string line = live_.Next(status, now, Width());
  if (terminal_) {
    std::cout << "\r\033[K" << line << std::flush;
  } else if (now - last_plain_ >= std::chrono::seconds(15)) {
    std::cout << line << std::endl;
    last_plain_ = now;
  }
}

void Display::ShowLine(const std::string& line) {
  Clear();
  std::cout << line << std::endl;
}

void Display::ShowIteration(const IterationReport& report) {
  Clear();
  const std::string header = TableHeader(report, Width());
  if (lines_++ % 20 == 0 || header != header_) std::cout << header << '\n';
  header_ = header;
  std::cout << TableLine(report, Width()) << std::endl;
}

void Display::Clear() {
  if (terminal_) std::cout << "\r\033[K" << std::flush;
}

// Characters that fit into a line of the terminal, which may change, without a wrap.
std::size_t Display::Width() const {
  winsize size{};
  if (!terminal_ || ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 2) {
    return std::string::npos;
  }
  return size.ws_col - std::size_t{1};
}

}  // namespace powderkeg
