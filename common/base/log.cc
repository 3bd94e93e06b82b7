#include "common/base/log.h"

#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "common/base/check.h"

namespace powderkeg::log {
namespace {

constexpr const char* kPattern = "%Y-%m-%d %H:%M:%S.%e %L %v";

spdlog::level::level_enum SpdlogLevel(Level level) {
  switch (level) {
    case Level::kDebug: return spdlog::level::debug;
    case Level::kInfo: return spdlog::level::info;
    case Level::kWarn: return spdlog::level::warn;
    case Level::kError: return spdlog::level::err;
  }
  return spdlog::level::info;
}

std::shared_ptr<spdlog::logger> MakeLogger(const std::string& file, Level level, Level console) {
  std::vector<spdlog::sink_ptr> sinks = {std::make_shared<spdlog::sinks::stderr_sink_mt>()};
  if (!file.empty()) {
    sinks.push_back(
        std::make_shared<spdlog::sinks::rotating_file_sink_mt>(file, kMaxFileBytes, kOldFiles));
  }
  auto logger = std::make_shared<spdlog::logger>("", sinks.begin(), sinks.end());
  logger->set_pattern(kPattern);
  // A live line may stand on the terminal: write over it.
  if (isatty(STDERR_FILENO) != 0) sinks[0]->set_pattern(std::string("\r\033[K") + kPattern);
  sinks[0]->set_level(SpdlogLevel(console));
  logger->set_level(SpdlogLevel(level));
  logger->flush_on(spdlog::level::info);
  return logger;
}

std::mutex mutex;  // guards the slot below

std::shared_ptr<spdlog::logger>& Slot() {
  static std::shared_ptr<spdlog::logger> logger = MakeLogger("", Level::kInfo, Level::kInfo);
  return logger;
}

std::shared_ptr<spdlog::logger> Logger() {
  const std::lock_guard lock(mutex);
  return Slot();
}

bool IsPlain(char c) { return static_cast<unsigned char>(c) > ' ' && c != '"' && c != '\x7f'; }

}  // namespace

Level LevelFor(std::string_view name) {
  constexpr std::array<std::string_view, 4> kNames = {"debug", "info", "warn", "error"};
  const auto found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) {
    throw powderkeg::Error(
        StrCat("log level \"", name, "\" is unknown; expected debug, info, warn or error"));
  }
  return static_cast<Level>(found - kNames.begin());
}

void Init(const std::string& file, Level level, Level console) {
  try {
    auto logger = MakeLogger(file, level, console);
    const std::lock_guard lock(mutex);
    Slot() = std::move(logger);
  } catch (const spdlog::spdlog_ex& error) {
    throw powderkeg::Error(StrCat("cannot open log file \"", file, "\": ", error.what()));
  }
}

bool Enabled(Level level) { return Logger()->should_log(SpdlogLevel(level)); }

void Write(Level level, const std::string& line) { Logger()->log(SpdlogLevel(level), line); }

void AppendField(std::string& line, std::string_view key, std::string_view value) {
  line.append(" ").append(key).append("=");
  if (!value.empty() && std::all_of(value.begin(), value.end(), IsPlain)) {
    line.append(value);
    return;
  }
  line.push_back('"');
  for (const char c : value) {
    if (c == '"' || c == '\\') line.push_back('\\');
    line.push_back(IsPlain(c) || c == '"' || c == ' ' ? c : '?');
  }
  line.push_back('"');
}

}  // namespace powderkeg::log
