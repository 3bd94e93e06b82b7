#pragma once

// Ends another thread's wait for messages.

#include <chrono>

namespace powderkeg {

// Notifications are not counted: several before the next wait end it once. Thread-safe.
class Waker {
 public:
  // Throws Error if the system has no more file descriptors.
  Waker();
  ~Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  void Notify() const;
  // Forgets the notifications so far.
  void Clear() const;
  // Returns when notified or time is up; clears.
  void Wait(std::chrono::milliseconds timeout) const;
  // Readable while there are notifications.
  [[nodiscard]] int file_descriptor() const { return file_descriptor_; }

 private:
  int file_descriptor_;
};

}  // namespace powderkeg
