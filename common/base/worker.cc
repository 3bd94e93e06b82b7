#include "common/base/worker.h"

#include <pthread.h>

#include <utility>

#include "common/base/check.h"
#include "common/base/log.h"

namespace powderkeg {

Worker::Worker(std::string name, Function function)
    : name_(std::move(name)),
      function_(std::move(function)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

Worker::~Worker() {
  thread_.request_stop();
  try {
    Join();
  } catch (const std::exception& error) {
    log::Error("worker failed", "worker", name_, "error", error.what());
  }
}

void Worker::Run(const std::stop_token& stop) {
  constexpr std::size_t kLongestName = 15;  // Linux
  pthread_setname_np(pthread_self(), name_.substr(0, kLongestName).c_str());
  try {
    function_(stop);
  } catch (const Error&) {
    error_ = std::current_exception();
  } catch (const std::exception& error) {  // no memory, no descriptors
    error_ = std::make_exception_ptr(Error(StrCat(name_, ": ", error.what())));
  }
  finished_.store(true);
}

void Worker::Join() {
  if (thread_.joinable()) thread_.join();
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

}  // namespace powderkeg
