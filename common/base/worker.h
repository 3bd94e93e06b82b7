#pragma once

// A thread whose failure is not lost.

#include <atomic>
#include <exception>
#include <functional>
#include <stop_token>
#include <string>
#include <thread>

namespace powderkeg {

// Runs one function on its own thread. An Error that ends the function is kept and rethrown by
// Join; any other exception is a bug and terminates. One owner; finished() and RequestStop() are
// thread-safe.
class Worker {
 public:
  // The function returns soon after a stop was requested. `name` (at most 15 characters) is what
  // debuggers and `top` show.
  using Function = std::function<void(const std::stop_token&)>;
  Worker(std::string name, Function function);
  // Requests the stop and waits; an error that nobody joined for is logged.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void RequestStop() { thread_.request_stop(); }
  // Whether the function has returned or failed.
  [[nodiscard]] bool finished() const { return finished_.load(); }
  // Waits for the end (without requesting it) and rethrows the Error that ended the function.
  void Join();

 private:
  void Run(const std::stop_token& stop);

  std::string name_;
  Function function_;
  std::exception_ptr error_;  // written by the thread, read after the join
  std::atomic<bool> finished_ = false;
  std::jthread thread_;  // last: starts when everything above is ready
};

}  // namespace powderkeg
