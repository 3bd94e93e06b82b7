#include "common/base/descriptors.h"

#include <sys/resource.h>

#include <mutex>

#include "common/base/check.h"

namespace powderkeg {
namespace {

constexpr rlim_t kReserve = 64;
constexpr rlim_t kFewest = 160;

// The process's, as its limit is.
std::mutex mutex;     // guards what follows
rlimit unreserved{};  // 0: there is no reserve
int scopes = 0;

void SetLimit(rlim_t limit) {
  if (unreserved.rlim_max == 0) return;
  const rlimit now{.rlim_cur = limit, .rlim_max = unreserved.rlim_max};
  setrlimit(RLIMIT_NOFILE, &now);
}

}  // namespace

void AllowManyDescriptors() {
  const std::lock_guard lock(mutex);
  if (getrlimit(RLIMIT_NOFILE, &unreserved) != 0) return;
  if (unreserved.rlim_max < kFewest) {
    throw Error(StrCat("this process may have ", unreserved.rlim_max,
                       " descriptors (ulimit -n); expected at least ", kFewest));
  }
  unreserved.rlim_cur = unreserved.rlim_max - kReserve;
  SetLimit(unreserved.rlim_cur);
}

std::size_t DescriptorLimit() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  return static_cast<std::size_t>(limit.rlim_cur);
}

ReservedDescriptors::ReservedDescriptors() {
  const std::lock_guard lock(mutex);
  if (scopes++ == 0) SetLimit(unreserved.rlim_max);
}

ReservedDescriptors::~ReservedDescriptors() {
  const std::lock_guard lock(mutex);
  if (--scopes == 0) SetLimit(unreserved.rlim_cur);
}

}  // namespace powderkeg
