#include "actors/http/agent_service.h"

#include <bit>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/base/rng.h"
#include "common/policies/policy.h"
#include "common/pommerman/belief.h"
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

ServiceReply Played(Mode mode, Action action, const Message& words) {
  const int number = static_cast<int>(action);
  if (mode != Mode::kTeamRadio) return {.body = Json{{"action", number}}.dump()};
  return {.body = Json{{"action", {number, words[0], words[1]}}}.dump()};
}

// What to play while the agent has no idea: a rule's action, which knows this observation alone.
Action StandIn(const ActionRequest& request, Rng rng) {
  Belief belief(request.settings);
  belief.Observe(request.observation);
  const PolicyView view{belief.state(), request.settings, belief.self(), belief.visible()};
  const PolicyTraits traits = PolicyTraits::Draw(rng);
  PolicyMemory memory;
  const Action action = Decide(PolicyKind::kSimpleUnbiased, view, traits, memory, rng);
  // The rule also runs into walls, which is a stop.
  const bool legal = Has(LegalActions(view.state, view.self), static_cast<std::size_t>(action));
  return legal ? action : Action::kStop;
}

}  // namespace

AgentService::AgentService(std::unique_ptr<Agent> agent, std::shared_ptr<Evaluator> evaluator,
                           const ServiceSettings& settings)
    : settings_(settings), thinker_(std::move(agent), std::move(evaluator)) {}

void AgentService::WarmUp() {
  constexpr int kMoves = 4;
  const std::lock_guard lock(mutex_);
  Rehearse({}, kMoves, settings_.move_time);
}

void AgentService::Rehearse(const GameSettings& settings, int moves, Clock::duration time) {
  State state = GenerateStart(settings, {}, Rng(settings_.seed));
  for (int move = 0; move < moves && state.agents[0].alive; ++move) {
    Briefing briefing{.settings = settings,
                      .observation = powderkeg::Observe(settings, state, /*self=*/0)};
    if (move == 0) briefing.new_game = Rng(settings_.seed);
    thinker_.Start(briefing, Clock::now() + time);
    const Thought thought = thinker_.Await(kNever);
    // The others do what the agent expects: so its tree is reused.
    JointAction actions = thought.statistics.prediction;
    actions[0] = thought.action.value();
    Step(settings, actions, state);
  }
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
  auto parsed = ParseActionRequest(body);
  const Clock::time_point understood = Clock::now();
  const std::lock_guard lock(mutex_);
  if (const auto* refusal = std::get_if<Refusal>(&parsed)) return NoMove(400, refusal->reason);
  auto& request = std::get<ActionRequest>(parsed);
  if (const std::string conflict = Conflict(request); !conflict.empty()) {
    return NoMove(409, conflict);
  }
  Believe(request);
  const Clock::time_point deadline =
      settings_.move_time.count() > 0 ? arrival + settings_.move_time : kNever;
  thinker_.Start(Observe(request), deadline);
  const Thought thought = thinker_.Await(deadline);
  const Action action =
      thought.action ? *thought.action : StandIn(request, Rng(settings_.seed).Split(game_->step));
  const Clock::time_point answered = Clock::now();
  const Clock::time_point began = thought.began.value_or(answered);
  Count(thought, {.read = Between(arrival, understood),
                  .wait = Between(understood, began),
                  .think = Between(began, answered)});
  return Played(request.settings.mode, action, thought.words);
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

ServiceReply AgentService::Refused(int status, std::string_view reason) {
  // The 1st, 2nd, 4th, 8th, ... is logged: a client may go on for ever.
  if (std::has_single_bit(++statistics_.refused)) {
    log::Warn("request refused", "status", status, "reason", reason, "so_far", statistics_.refused);
  }
  return {.status = status, .body = Json{{"error", reason}}.dump()};
}

// Without an action the official runner ends the match, whatever the status.
ServiceReply AgentService::NoMove(int status, std::string_view reason) {
  ServiceReply reply = Refused(status, reason);
  reply.body = Json{{"action", static_cast<int>(Action::kStop)}, {"error", reason}}.dump();
  return reply;
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

void AgentService::Believe(ActionRequest& request) {
  if (!request.step_known && game_) {
    request.observation.step =
        static_cast<std::uint16_t>(std::min(game_->step + 1, request.settings.max_steps - 1));
  }
  if (request.believed.empty() || std::exchange(belief_said_, true)) return;
  log::Warn("observations lack what is then believed", "keys", request.believed);
}

Briefing AgentService::Observe(const ActionRequest& request) {
  const Observation& observation = request.observation;
  Briefing briefing{.settings = request.settings, .observation = observation};
  const bool follows = game_ && game_->settings == request.settings &&
                       game_->self == observation.self && game_->step + 1 == observation.step;
  if (!follows) {
    briefing.new_game = Rng(settings_.seed).Split(statistics_.games++);
    game_ = Game{.settings = request.settings, .self = observation.self, .step = 0};
  }
  game_->step = observation.step;
  return briefing;
}

void AgentService::Count(const Thought& thought, const MoveTimes& times) {
  ++statistics_.moves;
  const std::uint32_t simulations = thought.statistics.simulations;
  if (simulations > 0) ++statistics_.searches;
  statistics_.simulations += simulations;
  statistics_.evaluations += thought.evaluations;
  if (!thought.finished) ++statistics_.cut_short;
  if (!thought.action) ++statistics_.stand_ins;
  if (times.total() > statistics_.slowest_move.total()) statistics_.slowest_move = times;
  const bool late = times.total() > kPublishedMoveTime;
  if (late) ++statistics_.late_moves;
  if (!late && thought.finished) return;
  log::Debug(late ? "late move" : "move cut short", "step", game_->step, "simulations", simulations,
             "read_us", times.read.count(), "wait_us", times.wait.count(), "think_us",
             times.think.count());
}

}  // namespace powderkeg
