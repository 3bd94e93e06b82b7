#include "actors/selfplay/self_play.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "actors/selfplay/ticket_host.h"
#include "common/base/check.h"
#include "common/base/log.h"
#include "common/base/worker.h"
#include "common/config/tree_memory.h"
#include "common/pommerman/game_settings.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds kPoll{100};           // for a stop; everything else is notified
constexpr milliseconds kReport{200};         // between two reports of a loop's progress
constexpr std::size_t kOtherEvaluators = 4;  // of past weights and of files, beside games in play

bool IsUniform(const SelfPlayConfig& config) { return config.evaluator == "uniform"; }

// Largest differences from the learner's fp32 answers that rounding explains.
CanaryDifference ToleranceOf(std::string_view evaluator) {
  if (evaluator.ends_with("fp32")) return {.policy = 1e-3F, .value = 1e-3F};
  if (evaluator.ends_with("int8")) return {.policy = 0.4F, .value = 0.6F};
  return {.policy = 0.1F, .value = 0.1F};
}

// Whether this machine computes what the learner means.
void CheckCanary(const WeightsSnapshot& weights, Evaluator& evaluator) {
  const CanaryDifference difference = CompareCanary(weights, evaluator);
  const CanaryDifference tolerance = ToleranceOf(evaluator.name());
  if (difference.policy <= tolerance.policy && difference.value <= tolerance.value) return;
  throw Error(StrCat("evaluator ", evaluator.name(), " answers the canary of weights ",
                     weights.version, " wrongly: policy differs by ", difference.policy,
                     ", value by ", difference.value, "; expected at most ", tolerance.policy,
                     " and ", tolerance.value));
}

// Without weights: the uniform evaluator, version 0.
Model ModelFor(const SelfPlayConfig& config, const Snapshot& weights,
               const EvaluatorFactory& make_evaluator) {
  if (IsUniform(config) || !weights) return {.evaluator = std::make_shared<UniformEvaluator>()};
  Model model{.evaluator = make_evaluator(config, weights), .weights_version = weights->version};
  CheckCanary(*weights, *model.evaluator);
  return model;
}

}  // namespace

SelfPlay::SelfPlay(SelfPlaySettings settings, Connect connect, EvaluatorFactory make_evaluator)
    : settings_(std::move(settings)),
      make_evaluator_(std::move(make_evaluator)),
      outbox_(settings_.spool, settings_.outbox_limit_bytes),
      progress_(settings_.session.loops),
      client_(settings_.session, std::move(connect), outbox_, tickets_,
              [this] { return Statistics(); }) {
  if (outbox_.size() > 0) log::Info("found games in the spool", "games", outbox_.size());
}

void SelfPlay::Run(const std::stop_token& stop) {
  while (!stop.stop_requested() && !client_.ended()) {
    if (const auto welcome = WaitUntilReady(stop)) Play(stop, welcome);
  }
  client_.Leave(settings_.patience);
}

// The settings, once everything that they need has arrived; null when there is nothing to wait for.
std::shared_ptr<const Welcome> SelfPlay::WaitUntilReady(const std::stop_token& stop) const {
  while (!stop.stop_requested() && !client_.ended()) {
    const std::uint64_t version = client_.version();
    const auto welcome = client_.welcome();
    const bool knows_weights = client_.weights() || client_.no_weights_yet();
    if (welcome && (IsUniform(welcome->self_play) || knows_weights)) return welcome;
    client_.WaitForChange(version, kPoll);
  }
  return nullptr;
}

// Until the settings change, somebody fails or the end.
void SelfPlay::Play(const std::stop_token& stop, const std::shared_ptr<const Welcome>& welcome) {
  RequireMemoryForTrees("the run's games",
                        settings_.session.loops * TreeBytesOfLoop(welcome->self_play));
  std::vector<std::unique_ptr<Worker>> loops;
  for (std::size_t i = 0; i < settings_.session.loops; ++i) {
    loops.push_back(std::make_unique<Worker>(
        "games", [this, &welcome, i](const auto& loop_stop) { RunLoop(loop_stop, *welcome, i); }));
  }
  const auto failed = [&] {
    return std::ranges::any_of(loops, [](const auto& loop) { return loop->finished(); });
  };
  while (!stop.stop_requested() && !client_.ended() && !failed() && client_.welcome() == welcome) {
    client_.WaitForChange(client_.version(), kPoll);
  }
  for (const auto& loop : loops) loop->RequestStop();
  for (const auto& loop : loops) loop->Join();
  progress_.StartAnew();
}

// The model of other weights than the newest; nullopt while they are on their way. Throws Error if
// they will not come.
std::optional<Model> SelfPlay::ModelOf(std::uint32_t version, const SelfPlayConfig& config,
                                       WeightsShelf<std::shared_ptr<Evaluator>>& evaluators) {
  if (IsUniform(config)) return ModelFor(config, nullptr, make_evaluator_);
  if (const auto evaluator = evaluators.Find(version)) {
    return Model{.evaluator = evaluator, .weights_version = version};
  }
  const WantedWeights wanted = client_.Want(version);
  if (!wanted.fault.empty()) throw Error(wanted.fault);
  if (!wanted.snapshot) return std::nullopt;
  const Model model = ModelFor(config, wanted.snapshot, make_evaluator_);
  evaluators.Put(version, model.evaluator);
  return model;
}

void SelfPlay::RunLoop(const std::stop_token& stop, const Welcome& welcome, std::size_t loop) {
  const SelfPlayConfig& config = welcome.self_play;
  WeightsShelf<std::shared_ptr<Evaluator>> evaluators(kOtherEvaluators);
  TicketHost host(
      welcome, tickets_, outbox_, [this] { client_.GameAdded(); },
      [&](std::uint32_t version) { return ModelOf(version, config, evaluators); });
  GameLoop games(host, host.settings(), config.games_in_flight);
  Snapshot weights;
  Clock::time_point reported;
  while (!stop.stop_requested()) {
    const Snapshot newest = client_.weights();
    if (newest != weights || !host.newest().evaluator) {
      weights = newest;
      host.SetNewest(ModelFor(config, weights, make_evaluator_));
      games.SetModel(host.newest());
    }
    const bool playing = games.RunRound();
    if (const auto now = Clock::now(); now - reported >= kReport || !playing) {
      reported = now;
      LoopProgress progress{.metrics = games.metrics(),
                            .games_running = games.games_running(),
                            .oldest_ticket = 0,
                            .oldest_start = now,
                            .weights_version = host.newest().weights_version};
      host.FillOldest(progress);
      progress_.Set(loop, progress);
    }
    if (playing) continue;
    outbox_.WaitForRoom(kPoll);
    tickets_.WaitForTicket(kPoll);
  }
}

Heartbeat SelfPlay::Statistics() const {
  Heartbeat heartbeat = progress_.Sum(Clock::now());
  heartbeat.tickets_waiting = static_cast<std::uint32_t>(tickets_.waiting());
  heartbeat.outbox_games = static_cast<std::uint32_t>(outbox_.size());
  heartbeat.outbox_bytes = outbox_.bytes();
  return heartbeat;
}

}  // namespace powderkeg
