#pragma once

// Failure handling: one macro for bugs, one exception type for what a user or operator can mend.

#include <sstream>
#include <stdexcept>
#include <string>

namespace powderkeg {

// Bad configuration, a port in use, a full disk, an unreadable checkpoint: the message says in one
// line what failed, which value it had and what was expected. Worker hands it on, mains print it.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Aborts with the place of the check. Use through CHECK.
[[noreturn]] void CheckFailed(const char* file, int line, const std::string& what);

// Builds one message from its parts: StrCat("port ", port, " in use").
template <typename... Parts>
std::string StrCat(const Parts&... parts) {
  std::ostringstream out;
  (out << ... << parts);
  return out.str();
}

}  // namespace powderkeg

// A broken CHECK is a bug in this program. On in every build; further arguments are printed.
#define CHECK(condition, ...)                                                                     \
  do {                                                                                            \
    if (!(condition)) [[unlikely]] {                                                              \
      ::powderkeg::CheckFailed(__FILE__, __LINE__,                                                \
                               ::powderkeg::StrCat(#condition __VA_OPT__(, ": ", ) __VA_ARGS__)); \
    }                                                                                             \
  } while (false)

// As CHECK, for inner loops: compiled out where NDEBUG is defined.
#ifdef NDEBUG
#define DCHECK(condition, ...) \
  do {                         \
  } while (false && (condition))
#else
#define DCHECK(condition, ...) CHECK(condition __VA_OPT__(, ) __VA_ARGS__)
#endif
