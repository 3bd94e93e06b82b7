#include "learner/intake/game_pipeline.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/config/config.h"
#include "common/record/game_setup.h"
#include "common/wire/codec.h"
#include "learner/intake/plausible.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

// How long an idle thread waits before it looks whether the pipeline was drained; Close wakes it
// at once.
constexpr milliseconds kIdle{1000};

// Closes a queue when its consumer ends, so that producers never wait for it in vain.
template <typename T>
class CloseAtExit {
 public:
  explicit CloseAtExit(BoundedQueue<T>& queue) : queue_(queue) {}
  ~CloseAtExit() { queue_.Close(); }
  CloseAtExit(const CloseAtExit&) = delete;
  CloseAtExit& operator=(const CloseAtExit&) = delete;

 private:
  BoundedQueue<T>& queue_;
};

}  // namespace

GamePipeline::GamePipeline(PipelineSettings settings, AppendGames append, TicketSet stored,
                           const Waker& waker)
    : settings_(std::move(settings)),
      settings_digest_(SettingsDigest(settings_.self_play)),
      games_(settings_.self_play),
      append_(std::move(append)),
      waker_(waker),
      stored_(std::move(stored)),
      newest_version_(settings_.newest_version),
      to_verify_(settings_.capacity),
      to_store_(settings_.capacity) {
  store_ = std::make_unique<Worker>("store", [this](const std::stop_token&) { RunStore(); });
  for (int i = 0; i < settings_.verify_threads; ++i) {
    verifiers_.push_back(
        std::make_unique<Worker>("verify", [this](const std::stop_token&) { RunVerify(); }));
  }
}

GamePipeline::~GamePipeline() {
  try {
    Drain();
  } catch (const Error& error) {
    log::Error("game pipeline failed", "error", error.what());
  }
}

bool GamePipeline::Submit(SessionId session, SealedGame game) {
  return to_verify_.TryPush({.session = session, .game = std::move(game)}) == QueueResult::kOk;
}

std::vector<Verdict> GamePipeline::TakeVerdicts() {
  const std::lock_guard lock(mutex_);
  return std::exchange(verdicts_, {});
}

void GamePipeline::Drain() {
  drained_ = true;
  to_verify_.Close();
  for (const auto& verifier : verifiers_) verifier->Join();
  to_store_.Close();
  store_->Join();
}

bool GamePipeline::failed() const { return store_->finished() && !drained_; }

void GamePipeline::RunVerify() {
  while (!to_verify_.drained()) {
    const auto submitted = to_verify_.Pop(kIdle);
    if (!submitted) continue;
    VerifiedGame game = Check(*submitted);
    if (game.verdict.kind == Verdict::Kind::kRejected) {
      Report({std::move(game.verdict)});
      continue;
    }
    QueueResult pushed = QueueResult::kTimedOut;
    while (pushed == QueueResult::kTimedOut) pushed = to_store_.Push(std::move(game), kIdle);
    if (pushed == QueueResult::kClosed) return;  // the store thread failed
  }
}

GamePipeline::VerifiedGame GamePipeline::Check(const SubmittedGame& submitted) const {
  VerifiedGame checked;
  Verdict& verdict = checked.verdict;
  verdict.session = submitted.session;
  verdict.ticket = submitted.game.ticket;
  verdict.bytes = submitted.game.record.size();
  verdict.other_settings = submitted.game.settings_digest != settings_digest_;
  Decoded<GameRecord> decoded = Unseal(submitted.game);
  if (const auto* malformed = std::get_if<Malformed>(&decoded)) {
    verdict.reason = malformed->reason;
  } else {
    checked.record = std::get<GameRecord>(std::move(decoded));
    checked.record.setup = games_.SetupFor(verdict.ticket);
    auto made = MakeLessons(checked.record);
    if (const auto* reason = std::get_if<std::string>(&made)) {
      verdict.reason = *reason;
    } else {
      verdict.reason = WhyImplausible(checked.record, games_, newest_version_).value_or("");
      checked.lessons = std::get<Lessons>(std::move(made));
      verdict.decisions = checked.lessons.samples.size();
    }
    // Perhaps true when it was played.
    verdict.outdated = !verdict.reason.empty() && verdict.other_settings;
  }
  if (!verdict.reason.empty()) verdict.kind = Verdict::Kind::kRejected;
  return checked;
}

void GamePipeline::RunStore() {
  const CloseAtExit close(to_store_);
  while (!to_store_.drained()) {
    std::vector<VerifiedGame> games = CollectCommit();
    if (!games.empty()) Commit(std::move(games));
  }
}

// Waits for a game, then for those that come within the commit interval.
std::vector<GamePipeline::VerifiedGame> GamePipeline::CollectCommit() {
  using Clock = std::chrono::steady_clock;
  std::vector<VerifiedGame> games;
  auto first = to_store_.Pop(kIdle);
  if (!first) return games;
  games.push_back(*std::move(first));
  const Clock::time_point deadline = Clock::now() + settings_.commit_interval;
  while (games.size() < settings_.commit_games && !to_store_.drained()) {
    const auto left =
        std::chrono::ceil<milliseconds>(std::max(deadline - Clock::now(), Clock::duration(0)));
    auto next = to_store_.Pop(left);
    if (next) {
      games.push_back(*std::move(next));
    } else if (Clock::now() >= deadline) {
      break;
    }
  }
  return games;
}

void GamePipeline::Commit(std::vector<VerifiedGame> games) {
  std::vector<GameRecord> records;
  std::vector<Lessons> lessons;
  for (VerifiedGame& game : games) {
    if (stored_.Insert(game.verdict.ticket)) {
      records.push_back(std::move(game.record));
      lessons.push_back(std::move(game.lessons));
    } else {
      game.verdict.kind = Verdict::Kind::kDuplicate;
    }
  }
  if (!records.empty()) append_(records, std::move(lessons));
  std::vector<Verdict> verdicts;
  for (VerifiedGame& game : games) verdicts.push_back(std::move(game.verdict));
  Report(std::move(verdicts));
}

void GamePipeline::Report(std::vector<Verdict> verdicts) {
  {
    const std::lock_guard lock(mutex_);
    std::ranges::move(verdicts, std::back_inserter(verdicts_));
  }
  waker_.Notify();
}

}  // namespace powderkeg
