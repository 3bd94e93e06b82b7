#pragma once

// How many lines a stranger can cause: nobody may fill the disk.

#include <chrono>

namespace powderkeg::log {

// One thread.
class Budget {
 public:
  // Whether one more line may be written in this second.
  [[nodiscard]] bool Spend() {
    const auto now = std::chrono::steady_clock::now();
    if (now - second_ >= std::chrono::seconds(1)) {
      second_ = now;
      left_ = kLinesPerSecond;
    }
    return left_-- > 0;
  }

 private:
  static constexpr int kLinesPerSecond = 10;

  std::chrono::steady_clock::time_point second_;
  int left_ = 0;
};

}  // namespace powderkeg::log
