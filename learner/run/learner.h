#pragma once

// A learner: everything between a run's folder and the end of the process.

#include <atomic>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/log_budget.h"
#include "common/http/http_server.h"
#include "common/record/game_setup.h"
#include "learner/intake/session_server.h"
#include "learner/league/exams.h"
#include "learner/league/league.h"
#include "learner/replay/store.h"
#include "learner/report/display.h"
#include "learner/report/iteration_history.h"
#include "learner/report/run_view.h"
#include "learner/run/run_folder.h"
#include "learner/train/learner_loop.h"

namespace powderkeg {

struct LearnerSettings {
  std::filesystem::path folder;      // of the run; must exist
  std::string config;                // a file of settings; empty: those stored in the folder
  std::vector<std::string> changes;  // PATH=VALUE
  std::string listen;                // tcp://... or ipc://...
  std::string keys;                  // folder of CURVE keys; empty: none
  bool insecure = false;             // other machines may come without keys
  std::string first_weights;         // of a new run, as LoadFirstState; empty: untrained
  std::vector<std::filesystem::path> demonstrations;  // of a new run
  std::optional<HttpServerSettings> http;             // of the dashboard
};

class Learner {
 public:
  // Loads the games of the run, whose RunLock the caller holds, and opens its doors. Throws Error.
  explicit Learner(const LearnerSettings& settings);

  // Returns when every iteration is done or `stop_wanted`, asked twice a second, says so. Throws
  // Error.
  void Run(const std::function<bool()>& stop_wanted);

 private:
  [[nodiscard]] LearnerLoopSettings LoopSettings(const LearnerSettings& settings) const;
  [[nodiscard]] LearnerLoopHooks LoopHooks();
  void KeepWeights() const;
  void LoadDemonstrations(std::span<const std::filesystem::path> given);
  // Where there are several.
  void ShowExams(int iteration);
  [[nodiscard]] std::vector<std::uint64_t> LoadGames();
  [[nodiscard]] std::uint32_t DrawPast();
  [[nodiscard]] std::vector<std::uint8_t> LoadWeights(std::uint32_t version);
  [[nodiscard]] std::uint32_t NewestSavedVersion() const;
  void ServeActors(const LearnerSettings& settings, std::span<const std::uint64_t> known);
  void ServeHttp(const HttpServerSettings& settings);
  void Append(const std::vector<GameRecord>& games, std::vector<Lessons> lessons);
  // Keeps the store within training.replay_mb.
  void TrimStore();
  [[nodiscard]] RunView View() const;
  [[nodiscard]] std::string IterationsDone() const;

  const std::filesystem::path folder_;
  const std::string name_;
  const std::time_t started_ = std::time(nullptr);
  RunConfig config_;
  const RunGames games_;
  Display display_;
  std::atomic<bool> merge_wanted_ = false;
  std::atomic<std::uint64_t> oldest_ticket_needed_ = 0;  // of those stored
  ReplayStore store_;
  LearnerLoop loop_;
  IterationHistory history_;
  League league_;
  Exams exams_;
  Rng past_rng_;  // of the io thread, as the next
  log::Budget log_budget_;
  std::unique_ptr<SessionServer> server_;  // its threads use what stands above
  std::optional<HttpServer> http_;         // and so do its
};

}  // namespace powderkeg
