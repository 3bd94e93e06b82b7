#include "actors/http/agent_service.h"

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"

namespace powderkeg {
namespace {

using Json = nlohmann::json;

using std::chrono::microseconds;

microseconds Between(AgentService::Clock::time_point from, AgentService::Clock::time_point to) {
  return std::chrono::duration_cast<microseconds>(to - from);
}

// Far away, but short of what a time point can hold.
constexpr AgentService::Clock::time_point kNever{std::chrono::hours(24 * 365 * 100)};

// Of the environment that is most likely played in this mode.
GameSettings UsualSettings(Mode mode) {
  switch (mode) {
    case Mode::kFreeForAll: return GameSettingsFor("PommeFFACompetition-v0").value();
    case Mode::kTeam: return GameSettingsFor("PommeTeamCompetition-v0").value();
    case Mode::kTeamRadio: return GameSettingsFor("PommeRadioCompetition-v2").value();
    case Mode::kOneVsOne: return GameSettingsFor("OneVsOne-v0").value();
  }
  return {};
}

ServiceReply Success() { return {.body = Json{{"success", true}}.dump()}; }

ServiceReply Played(Mode mode, const Observation& observation, Action action) {
  const int number = static_cast<int>(action);
  if (mode != Mode::kTeamRadio) return {.body = Json{{"action", number}}.dump()};
  const Message words = EncodeReport(observation.step, observation.position, action);
  return {.body = Json{{"action", {number, words[0], words[1]}}}.dump()};
}

}  // namespace

AgentService::AgentService(std::unique_ptr<Agent> agent, std::shared_ptr<Evaluator> evaluator,
                           const ServiceSettings& settings)
    : settings_(settings), agent_(std::move(agent)), evaluator_(std::move(evaluator)) {
  CHECK(agent_ != nullptr && evaluator_ != nullptr);
}

void AgentService::WarmUp() {
  constexpr int kMoves = 4;
  const std::lock_guard lock(mutex_);
  Rehearse({}, kMoves, settings_.move_time);
}

void AgentService::Rehearse(const GameSettings& settings, int moves, Clock::duration time) {
  const ServiceStatistics counted = statistics_;
  State state = GenerateStart(settings, {}, Rng(settings_.seed));
  agent_->StartGame(settings, /*self=*/0, Rng(settings_.seed));
  for (int move = 0; move < moves && state.agents[0].alive; ++move) {
    agent_->Begin(powderkeg::Observe(settings, state, 0));
    const Action action = Think(settings, Clock::now() + time);
    // The others do what the agent expects: so its tree is reused.
    JointAction actions = agent_->move_statistics().prediction;
    actions[0] = action;
    Step(settings, actions, state);
  }
  statistics_ = counted;
}

ServiceReply AgentService::Ping() const { return Success(); }

ServiceReply AgentService::InitAgent(std::string_view body) {
  const auto parsed = ParseInitRequest(body);
  const std::lock_guard lock(mutex_);
  if (const auto* refusal = std::get_if<Refusal>(&parsed)) return Refused(400, refusal->reason);
  init_ = std::get<InitRequest>(parsed);
  game_.reset();
  if (settings_.move_time.count() > 0) {
    Rehearse(UsualSettings(init_->mode), /*moves=*/2, std::chrono::milliseconds(20));
  }
  log::Info("agent initialised", "id", init_->id, "game_type", static_cast<int>(init_->mode));
  return Success();
}

ServiceReply AgentService::Act(std::string_view body, Clock::time_point arrival) {
  const auto parsed = ParseActionRequest(body);
  const Clock::time_point understood = Clock::now();
  const std::lock_guard lock(mutex_);
  if (const auto* refusal = std::get_if<Refusal>(&parsed)) return Refused(400, refusal->reason);
  const auto& request = std::get<ActionRequest>(parsed);
  if (const std::string conflict = Conflict(request); !conflict.empty()) {
    return Refused(409, conflict);
  }
  Observe(request);
  const Clock::time_point began = Clock::now();
  const bool timed = settings_.move_time.count() > 0;
  const Action action = Think(request.settings, timed ? arrival + settings_.move_time : kNever);
  Count({.read = Between(arrival, understood),
         .observe = Between(understood, began),
         .think = Between(began, Clock::now())});
  return Played(request.settings.mode, request.observation, action);
}

ServiceReply AgentService::EndEpisode(std::string_view body) {
  const auto parsed = ParseEpisodeEnd(body);
  const std::lock_guard lock(mutex_);
  if (const auto* refusal = std::get_if<Refusal>(&parsed)) return Refused(400, refusal->reason);
  if (!init_) return Refused(409, "an episode ended before /init_agent");
  log::Info("episode ended", "reward", std::get<int>(parsed), "last_step", game_ ? game_->step : 0);
  game_.reset();
  return Success();
}

ServiceReply AgentService::Shutdown() {
  const std::lock_guard lock(mutex_);
  init_.reset();
  game_.reset();
  return Success();
}

ServiceStatistics AgentService::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

std::optional<Cell> AgentService::mate() const {
  const std::lock_guard lock(mutex_);
  return game_ ? game_->mate.cell() : std::nullopt;
}

ServiceReply AgentService::Refused(int status, std::string_view reason) {
  // The 1st, 2nd, 4th, 8th, ... is logged: a client may go on for ever.
  if (std::has_single_bit(++statistics_.refused)) {
    log::Warn("request refused", "status", status, "reason", reason, "so_far", statistics_.refused);
  }
  return {.status = status, .body = Json{{"error", reason}}.dump()};
}

std::string AgentService::Conflict(const ActionRequest& request) const {
  if (!init_) return "an action was asked for before /init_agent";
  if (request.settings.mode != init_->mode) {
    return StrCat("/init_agent announced game_type ", static_cast<int>(init_->mode),
                  ", the observation has ", static_cast<int>(request.settings.mode));
  }
  if (request.observation.self != init_->id) {
    return StrCat("/init_agent announced agent ", init_->id, ", the observation is of agent ",
                  request.observation.self);
  }
  return {};
}

void AgentService::Observe(const ActionRequest& request) {
  const Observation& observation = request.observation;
  const bool follows = game_ && game_->settings == request.settings &&
                       game_->self == observation.self && game_->step + 1 == observation.step;
  if (!follows) {
    const Rng rng = Rng(settings_.seed).Split(statistics_.games++);
    agent_->StartGame(request.settings, observation.self, rng);
    game_ = Game{.settings = request.settings, .self = observation.self, .step = 0, .mate = {}};
  }
  game_->step = observation.step;
  if (request.settings.mode == Mode::kTeamRadio) ListenToMate(observation);
  agent_->Begin(observation);
}

void AgentService::ListenToMate(const Observation& observation) {
  MateTracker& mate = game_->mate;
  mate.Hear(observation.step, observation.message);
  const auto seen = std::ranges::find(observation.board,
                                      AgentValue(TeamMateOf(Mode::kTeamRadio, observation.self)));
  if (seen != observation.board.end()) {
    mate.See(observation.step, static_cast<Cell>(seen - observation.board.begin()));
  }
  if (const auto cell = mate.cell()) agent_->HearMate(*cell);
}

Action AgentService::Think(const GameSettings& settings, Clock::time_point deadline) {
  Clock::duration longest_round{0};
  Clock::time_point now = Clock::now();
  while (agent_->Gather(batch_)) {
    evaluator_->Evaluate(settings, batch_.positions(), batch_.AllocateEvaluations());
    agent_->Scatter(batch_);
    statistics_.evaluations += batch_.size();
    batch_.Clear();
    const Clock::time_point before = std::exchange(now, Clock::now());
    longest_round = std::max(longest_round, now - before);
    if (now + longest_round > deadline) break;
  }
  return agent_->action();
}

void AgentService::Count(const MoveTimes& times) {
  ++statistics_.moves;
  const std::uint32_t simulations = agent_->move_statistics().simulations;
  if (simulations > 0) ++statistics_.searches;
  statistics_.simulations += simulations;
  if (times.total() > statistics_.slowest_move.total()) statistics_.slowest_move = times;
  if (times.total() <= kPublishedMoveTime) return;
  ++statistics_.late_moves;
  log::Debug("late move", "step", game_->step, "simulations", simulations, "read_us",
             times.read.count(), "observe_us", times.observe.count(), "think_us",
             times.think.count());
}

}  // namespace powderkeg
