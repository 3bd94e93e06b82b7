#include "common/wire/waker.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>

#include "common/base/check.h"

namespace powderkeg {

Waker::Waker() : file_descriptor_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (file_descriptor_ < 0) throw Error(StrCat("cannot make an eventfd: ", std::strerror(errno)));
}

Waker::~Waker() { close(file_descriptor_); }

void Waker::Notify() const {
  const std::uint64_t one = 1;
  // Fails only when the counter is full: then the waiter is notified already.
  [[maybe_unused]] const auto written = write(file_descriptor_, &one, sizeof one);
}

void Waker::Clear() const {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto got = read(file_descriptor_, &count, sizeof count);
}

void Waker::Wait(std::chrono::milliseconds timeout) const {
  pollfd file{.fd = file_descriptor_, .events = POLLIN, .revents = 0};
  poll(&file, 1, static_cast<int>(timeout.count()));
  Clear();
}

}  // namespace powderkeg
