#include "common/record/game_record.h"

#include <cstddef>
#include <initializer_list>

#include "common/base/check.h"
#include "common/pommerman/radio_code.h"
#include "common/record/rule_based_seat.h"

namespace powderkeg {

namespace {

using Refusal = std::optional<std::string>;

constexpr std::size_t kMaxEvaluatorName = 128;
constexpr int kMaxSteps = 65'535;
constexpr int kPolicyCount = 5;

// Purposes of Rng::Split.
constexpr std::uint64_t kBoardPurpose = 1;
constexpr std::uint64_t kSeatPurpose = 2;
constexpr std::uint64_t kSearchPurpose = 3;

struct Bounded {
  const char* what;
  int value;
  int low;
  int high;
};

Refusal CheckBounds(std::initializer_list<Bounded> values) {
  for (const auto& [what, value, low, high] : values) {
    if (value < low || value > high) {
      return StrCat(what, " ", value, ", expected ", low, " to ", high);
    }
  }
  return std::nullopt;
}

Refusal CheckSetup(const GameSetup& setup) {
  const GameSettings& settings = setup.settings;
  const auto& collapse = settings.collapse_steps;
  const auto policy = [&](int seat) { return static_cast<int>(setup.seats[seat].policy); };
  const int size = settings.mode == Mode::kOneVsOne ? 8 : kBoardSize;
  return CheckBounds({
      {"mode", static_cast<int>(settings.mode), 1, 4},
      {"board size", settings.board_size, size, size},
      {"max steps", settings.max_steps, 1, kMaxSteps},
      {"blast strength cap", settings.blast_strength_cap, 1, 10},
      {"view radius", settings.view_radius, 0, kBoardSize - 1},
      {"collapse step of ring 0", collapse[0], 0, kMaxSteps},
      {"collapse step of ring 1", collapse[1], 0, kMaxSteps},
      {"collapse step of ring 2", collapse[2], 0, kMaxSteps},
      {"collapse step of ring 3", collapse[3], 0, kMaxSteps},
      {"board generator", static_cast<int>(setup.start.generator), 0, 1},
      {"start corners", static_cast<int>(setup.start.corners), 0, 1},
      {"policy of seat 0", policy(0), 0, kPolicyCount - 1},
      {"policy of seat 1", policy(1), 0, kPolicyCount - 1},
      {"policy of seat 2", policy(2), 0, kPolicyCount - 1},
      {"policy of seat 3", policy(3), 0, kPolicyCount - 1},
  });
}

Refusal CheckLengths(const GameRecord& record) {
  if (record.evaluator.size() > kMaxEvaluatorName) {
    return StrCat("evaluator name of ", record.evaluator.size(), " bytes, expected at most ",
                  kMaxEvaluatorName);
  }
  const std::size_t steps = record.actions.size();
  if (steps == 0 || steps > static_cast<std::size_t>(record.setup.settings.max_steps)) {
    return StrCat(steps, " steps, expected 1 to ", record.setup.settings.max_steps);
  }
  return std::nullopt;
}

// Plays a record again, step by step. Requires that CheckSetup and CheckLengths found nothing.
class Replay {
 public:
  Replay(const GameRecord& record, const StepObserver& observer);

  [[nodiscard]] Refusal Run();

 private:
  [[nodiscard]] Refusal PlayStep();
  // `observed` is the position decided on; state_ differs from it where the board collapsed since.
  [[nodiscard]] Refusal CheckAction(AgentId agent, const State& observed);
  // The agent's decision of this step, if it is there.
  [[nodiscard]] Refusal TakeDecision(AgentId agent);
  [[nodiscard]] std::array<Message, kAgentCount> WordsFor(const JointAction& actions) const;
  [[nodiscard]] Refusal CheckDecisionsTaken() const;
  [[nodiscard]] Refusal CheckEnd() const;

  const GameRecord& record_;
  const GameSettings& settings_;
  const StepObserver& observer_;
  State state_;
  std::array<RuleBasedSeat, kAgentCount> rule_based_;
  std::array<std::size_t, kAgentCount> next_decision_{};  // the first one of a track not yet met
  Outcome outcome_;                                       // after the last step
};

Replay::Replay(const GameRecord& record, const StepObserver& observer)
    : record_(record),
      settings_(record.setup.settings),
      observer_(observer),
      state_(GenerateStart(settings_, record.setup.start, BoardRng(record.setup))) {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (!record.setup.seats[agent].searches) {
      rule_based_[agent] = RuleBasedSeat(record.setup, agent);
    }
  }
}

Refusal Replay::Run() {
  while (state_.step < record_.actions.size()) {
    const int step = state_.step;
    if (auto refusal = PlayStep()) return StrCat("step ", step, ": ", *refusal);
  }
  if (auto refusal = CheckDecisionsTaken()) return refusal;
  return CheckEnd();
}

// As a game does it: everybody decides, then the board may collapse, then the step is played.
Refusal Replay::PlayStep() {
  if (outcome_.done || EndsEarly(record_.setup, state_)) return "the game is over before it";
  const State observed = state_;
  Collapse(settings_, state_);
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (auto refusal = CheckAction(agent, observed)) return refusal;
    if (auto refusal = TakeDecision(agent)) return refusal;
  }
  const JointAction& actions = record_.actions[state_.step];
  if (observer_) observer_(observed, actions);
  Step(settings_, actions, WordsFor(actions), state_);
  outcome_ = OutcomeOf(settings_, state_);
  return std::nullopt;
}

// What the searching seats said in a radio game; the others are silent.
std::array<Message, kAgentCount> Replay::WordsFor(const JointAction& actions) const {
  std::array<Message, kAgentCount> words{};
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (settings_.mode != Mode::kTeamRadio || !record_.setup.seats[agent].searches) continue;
    words[agent] = EncodeReport(state_.step, state_.agents[agent].cell, actions[agent]);
  }
  return words;
}

Refusal Replay::CheckAction(AgentId agent, const State& observed) {
  const Action action = record_.actions[state_.step][agent];
  const int number = static_cast<int>(action);
  if (number >= kActionCount) return StrCat("agent ", agent, ": action ", number);
  if (!state_.agents[agent].alive) {
    if (action == Action::kStop) return std::nullopt;
    return StrCat("agent ", agent, ": action ", number, " of the dead");
  }
  if (record_.setup.seats[agent].searches) return std::nullopt;
  const Action expected = rule_based_[agent].Decide(settings_, observed);
  if (action == expected) return std::nullopt;
  return StrCat("agent ", agent, ": action ", number, ", but ",
                NameOf(record_.setup.seats[agent].policy), " plays ", static_cast<int>(expected));
}

// Decisions ascend by step; one that does not is left, and refused at the end.
Refusal Replay::TakeDecision(AgentId agent) {
  const std::vector<Decision>& decisions = record_.tracks[agent].decisions;
  std::size_t& next = next_decision_[agent];
  if (next == decisions.size() || decisions[next].step != state_.step) return std::nullopt;
  const Seat& seat = record_.setup.seats[agent];
  if (!seat.searches || seat.teaches != Teaches::kSearch) {
    return StrCat("decision of agent ", agent, ", which teaches no search");
  }
  if (!state_.agents[agent].alive) return StrCat("decision of agent ", agent, ", which is dead");
  const float value = decisions[next].value;
  if (!(value >= -1 && value <= 1)) {
    return StrCat("decision of agent ", agent, ": value ", value, ", expected -1 to 1");
  }
  ++next;
  return std::nullopt;
}

Refusal Replay::CheckDecisionsTaken() const {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (next_decision_[agent] == record_.tracks[agent].decisions.size()) continue;
    return StrCat("decision ", next_decision_[agent], " of agent ", agent,
                  ": out of order, or of a step that was not played");
  }
  return std::nullopt;
}

Refusal Replay::CheckEnd() const {
  if (record_.outcome != outcome_) return "the outcome is not the true one";
  if (outcome_.done || EndsEarly(record_.setup, state_)) return std::nullopt;
  return "ends neither with the game nor when no measured agent can win";
}

}  // namespace

Rng BoardRng(const GameSetup& setup) { return Rng(setup.seed).Split(kBoardPurpose); }

Rng SeatRng(const GameSetup& setup, AgentId seat) {
  return Rng(setup.seed).Split(kSeatPurpose).Split(static_cast<std::uint64_t>(seat));
}

Rng SearchRng(const GameSetup& setup, AgentId seat) {
  return Rng(setup.seed).Split(kSearchPurpose).Split(static_cast<std::uint64_t>(seat));
}

std::size_t DecisionCount(const GameRecord& record) {
  std::size_t count = 0;
  for (const Track& track : record.tracks) count += track.decisions.size();
  return count;
}

bool EndsEarly(const GameSetup& setup, const State& state) {
  if (setup.to_the_end) return false;
  bool measured = false;
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (!setup.seats[seat].measured) continue;
    measured = true;
    const AgentId mate = TeamMateOf(setup.settings.mode, seat);
    if (state.agents[seat].alive || (mate >= 0 && state.agents[mate].alive)) return false;
  }
  return measured;
}

int OutcomeFor(const GameRecord& record, AgentId agent) {
  const Outcome& outcome = record.outcome;
  if (!outcome.done) return record.setup.seats[agent].measured ? -1 : 0;
  if (outcome.result == Result::kTie) return 0;
  return outcome.Won(agent) ? 1 : -1;
}

std::optional<std::string> Verify(const GameRecord& record, const StepObserver& observer) {
  if (auto refusal = CheckSetup(record.setup)) return refusal;
  if (auto refusal = CheckLengths(record)) return refusal;
  return Replay(record, observer).Run();
}

}  // namespace powderkeg
