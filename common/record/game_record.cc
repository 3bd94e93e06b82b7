#include "common/record/game_record.h"

#include <cstddef>
#include <initializer_list>

#include "common/base/check.h"
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
  Replay(const GameRecord& record, PositionVisitor visitor, void* context);

  [[nodiscard]] Refusal Run();

 private:
  [[nodiscard]] Refusal PlayStep();
  // `observed` is the position decided on; state_ differs from it where the board collapsed since.
  [[nodiscard]] Refusal CheckAction(AgentId agent, const State& observed);
  [[nodiscard]] Refusal TakeDecisions(const State& observed);
  [[nodiscard]] Refusal CheckDecision(const Decision& decision) const;
  [[nodiscard]] Refusal CheckEnd() const;
  [[nodiscard]] bool SearcherLives() const;

  const GameRecord& record_;
  const GameSettings& settings_;
  PositionVisitor visitor_;
  void* context_;
  State state_;
  std::array<RuleBasedSeat, kAgentCount> rule_based_;
  std::size_t next_decision_ = 0;  // the first one not yet met
  bool searcher_lived_ = false;    // when the last step began
  Outcome outcome_;                // after the last step
};

Replay::Replay(const GameRecord& record, PositionVisitor visitor, void* context)
    : record_(record),
      settings_(record.setup.settings),
      visitor_(visitor),
      context_(context),
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
  if (next_decision_ < record_.decisions.size()) {
    return StrCat("decision ", next_decision_, ": out of order, or of a step that was not played");
  }
  return CheckEnd();
}

// As a game does it: everybody decides, then the board may collapse, then the step is played.
Refusal Replay::PlayStep() {
  if (outcome_.done) return "the game is over before it";
  searcher_lived_ = SearcherLives();
  const State observed = state_;
  Collapse(settings_, state_);
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (auto refusal = CheckAction(agent, observed)) return refusal;
  }
  if (auto refusal = TakeDecisions(observed)) return refusal;
  Step(settings_, record_.actions[state_.step], state_);
  outcome_ = OutcomeOf(settings_, state_);
  return std::nullopt;
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

// Decisions of this step come next and ascend by agent; any other is left, and refused at the end.
Refusal Replay::TakeDecisions(const State& observed) {
  const std::vector<Decision>& decisions = record_.decisions;
  for (int last_agent = -1; next_decision_ < decisions.size(); ++next_decision_) {
    const Decision& decision = decisions[next_decision_];
    if (decision.step != state_.step || decision.agent <= last_agent) break;
    if (auto refusal = CheckDecision(decision)) return refusal;
    last_agent = decision.agent;
    if (visitor_ == nullptr) continue;
    visitor_(context_, observed, decision, record_.actions[state_.step][decision.agent]);
  }
  return std::nullopt;
}

Refusal Replay::CheckDecision(const Decision& decision) const {
  const int agent = decision.agent;
  if (agent >= kAgentCount) return StrCat("decision of agent ", agent);
  if (!record_.setup.seats[agent].searches) {
    return StrCat("decision of agent ", agent, ", which does not search");
  }
  if (!state_.agents[agent].alive) return StrCat("decision of agent ", agent, ", which is dead");
  if (decision.value >= -1 && decision.value <= 1) return std::nullopt;
  return StrCat("decision of agent ", agent, ": value ", decision.value, ", expected -1 to 1");
}

Refusal Replay::CheckEnd() const {
  if (record_.outcome != outcome_) return "the outcome is not the true one";
  if (outcome_.done || (searcher_lived_ && !SearcherLives())) return std::nullopt;
  return "ends neither with the game nor with the death of the last searching agent";
}

bool Replay::SearcherLives() const {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (record_.setup.seats[agent].searches && state_.agents[agent].alive) return true;
  }
  return false;
}

}  // namespace

Rng BoardRng(const GameSetup& setup) { return Rng(setup.seed).Split(kBoardPurpose); }

Rng SeatRng(const GameSetup& setup, AgentId seat) {
  return Rng(setup.seed).Split(kSeatPurpose).Split(static_cast<std::uint64_t>(seat));
}

Rng SearchRng(const GameSetup& setup, AgentId seat) {
  return Rng(setup.seed).Split(kSearchPurpose).Split(static_cast<std::uint64_t>(seat));
}

int OutcomeFor(const GameRecord& record, AgentId agent) {
  const Outcome& outcome = record.outcome;
  if (!outcome.done) return record.setup.seats[agent].searches ? -1 : 0;
  if (outcome.result == Result::kTie) return 0;
  return (outcome.winners >> agent & 1) != 0 ? 1 : -1;
}

std::optional<std::string> Verify(const GameRecord& record, PositionVisitor visitor,
                                  void* context) {
  if (auto refusal = CheckSetup(record.setup)) return refusal;
  if (auto refusal = CheckLengths(record)) return refusal;
  return Replay(record, visitor, context).Run();
}

}  // namespace powderkeg
