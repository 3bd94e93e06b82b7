#pragma once

// Log lines for operators: one event per line, a short message and key=value pairs.
//
//   log::Info("actor connected", "name", "node-7", "loops", 4);
//   2026-01-31 12:00:00.123 I actor connected name=node-7 loops=4
//
// Thread-safe. Numbers over time are metrics, not log lines.

#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>

namespace powderkeg::log {

enum class Level : std::uint8_t { kDebug, kInfo, kWarn, kError };

// "debug", "info", "warn", "error"; throws Error otherwise.
[[nodiscard]] Level LevelFor(std::string_view name);

// A file that reaches this size is renamed to NAME.1.ENDING (older ones to .2. and so on, as many
// as kOldFiles) and begun anew: whatever peers do, the disk does not fill with lines.
inline constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20;
inline constexpr std::size_t kOldFiles = 3;

// Writes to standard error what is of level `console` or above and, if `file` is not empty, appends
// everything to that file. Without Init lines of level info and above go to standard error. Throws
// Error if the file cannot be opened.
void Init(const std::string& file, Level level, Level console = Level::kDebug);

[[nodiscard]] bool Enabled(Level level);
// One finished line, without its end.
void Write(Level level, const std::string& line);

// Appends " key=value"; a value that holds spaces, quotes or control characters is quoted.
void AppendField(std::string& line, std::string_view key, std::string_view value);

inline void AppendFields(std::string&) {}

template <typename Value, typename... Rest>
void AppendFields(std::string& line, std::string_view key, const Value& value,
                  const Rest&... rest) {
  std::ostringstream text;
  text << value;
  AppendField(line, key, text.view());
  AppendFields(line, rest...);
}

template <typename... Fields>
void WriteEvent(Level level, std::string_view message, const Fields&... fields) {
  static_assert(sizeof...(Fields) % 2 == 0, "fields come as key, value, key, value, ...");
  if (!Enabled(level)) return;
  std::string line(message);
  AppendFields(line, fields...);
  Write(level, line);
}

template <typename... Fields>
void Debug(std::string_view message, const Fields&... fields) {
  WriteEvent(Level::kDebug, message, fields...);
}
// What an operator acts on.
template <typename... Fields>
void Info(std::string_view message, const Fields&... fields) {
  WriteEvent(Level::kInfo, message, fields...);
}
template <typename... Fields>
void Warn(std::string_view message, const Fields&... fields) {
  WriteEvent(Level::kWarn, message, fields...);
}
template <typename... Fields>
void Error(std::string_view message, const Fields&... fields) {
  WriteEvent(Level::kError, message, fields...);
}

}  // namespace powderkeg::log
