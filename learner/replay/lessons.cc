#include "learner/replay/lessons.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "common/pommerman/belief.h"
#include "common/record/game_setup.h"
#include "common/recorded/recorded_game.h"

namespace powderkeg {
namespace {

// Looks on while a game is played again.
class Teacher {
 public:
  explicit Teacher(const GameRecord& game) : game_(game) {
    for (AgentId agent = 0; agent < kAgentCount; ++agent) {
      if (seat(agent).teaches != Teaches::kNothing) beliefs_[agent].emplace(settings());
    }
  }

  void Observe(const State& state, const JointAction& actions) {
    for (AgentId agent = 0; agent < kAgentCount; ++agent) {
      if (!state.agents[agent].alive) continue;
      ++lived_[agent];
      if (!beliefs_[agent]) continue;
      beliefs_[agent]->Observe(state, agent);
      if (seat(agent).teaches == Teaches::kMoves) {
        AddDemonstration(agent, actions);
      } else {
        AddDecision(agent, actions);
      }
    }
  }

  // Once the whole game was observed.
  [[nodiscard]] Lessons TakeLessons() {
    const auto teaches = [](const Seat& s) { return s.teaches != Teaches::kNothing; };
    const bool taught = std::ranges::any_of(game_.setup.seats, teaches);
    PlaySummary& summary = taught ? lessons_.play : lessons_.exam;
    Summarize(summary);
    for (Sample& sample : lessons_.samples) sample.outcome = OutcomeOf(sample.viewer);
    GameResult& result = lessons_.result.emplace();
    for (AgentId agent = 0; agent < kAgentCount; ++agent) result.finishes[agent] = FinishOf(agent);
    result.outcome = game_.outcome;
    result.lineup = game_.setup.lineup;
    lessons_.ticket = game_.ticket;
    return std::move(lessons_);
  }

 private:
  [[nodiscard]] const GameSettings& settings() const { return game_.setup.settings; }
  [[nodiscard]] const Seat& seat(AgentId agent) const { return game_.setup.seats[agent]; }

  void AddDecision(AgentId agent, const JointAction& actions) {
    const std::vector<Decision>& decisions = game_.tracks[agent].decisions;
    std::size_t& next = next_decision_[agent];
    const State& state = beliefs_[agent]->state();
    if (next == decisions.size() || decisions[next].step != state.step) return;
    Sample& sample = AddSample(agent, actions);
    sample.visits = decisions[next].visits;
    sample.searched = true;
    sample.search_value = decisions[next].value;
    ++next;
  }

  void AddDemonstration(AgentId agent, const JointAction& actions) {
    AddSample(agent, actions).visits[static_cast<std::size_t>(actions[agent])] = 1;
  }

  Sample& AddSample(AgentId agent, const JointAction& actions) {
    Sample& sample = lessons_.samples.emplace_back();
    sample.state = beliefs_[agent]->state();
    sample.viewer = static_cast<std::uint8_t>(agent);
    sample.end_step = static_cast<std::uint16_t>(game_.actions.size());
    for (AgentId i = 0; i < kAgentCount - 1; ++i) {
      sample.others[i] = actions[(agent + 1 + i) % kAgentCount];
    }
    ++lessons_.play.actions[static_cast<std::size_t>(actions[agent])];
    return sample;
  }

  [[nodiscard]] std::int8_t OutcomeOf(AgentId agent) const {
    const bool alone = !IsTeamMode(settings().mode);
    const bool outlived = lived_[agent] < game_.actions.size();
    if (game_.outcome.result == Result::kTie && alone && outlived) return -1;
    return static_cast<std::int8_t>(OutcomeFor(game_, agent));
  }

  [[nodiscard]] Finish FinishOf(AgentId agent) const {
    return {.player = seat(agent).player,
            .weights_version = game_.tracks[agent].weights_version,
            .mate = TeamMateOf(settings().mode, agent),
            .lasted = lived_[agent],
            .counts = Counts(agent),
            .outcome = static_cast<std::int8_t>(OutcomeFor(game_, agent))};
  }

  // Once for each measured side: of two measured mates the first.
  [[nodiscard]] bool Counts(AgentId agent) const {
    const AgentId mate = TeamMateOf(settings().mode, agent);
    return seat(agent).measured && !(mate >= 0 && mate < agent && seat(mate).measured);
  }

  void Summarize(PlaySummary& summary) const {
    std::uint32_t newest = 1;
    for (AgentId agent = 0; agent < kAgentCount; ++agent) {
      const std::uint32_t version = game_.tracks[agent].weights_version;
      if (version < kFirstFileVersion) newest = std::max(newest, version);
      if (Counts(agent)) summary.score.Add(OutcomeFor(game_, agent));
    }
    summary.games = 1;
    summary.decisions = lessons_.samples.size();
    summary.steps = game_.actions.size();
    summary.weights_versions = newest;
  }

  const GameRecord& game_;
  std::array<std::optional<Belief>, kAgentCount> beliefs_;  // of teaching seats
  std::array<std::size_t, kAgentCount> next_decision_{};
  std::array<std::uint16_t, kAgentCount> lived_{};  // steps that it was alive to play
  Lessons lessons_;
};

// Before it is played again.
GameRecord RecordOf(const RecordedGame& game, std::uint64_t ticket) {
  GameRecord record;
  record.ticket = ticket;
  record.setup.settings = game.settings;
  for (const RecordedStep& step : game.steps) record.actions.push_back(step.actions);
  const State& end = game.steps.empty() ? game.start : game.steps.back().state;
  for (AgentId agent = 0; agent < SeatCount(game.settings.mode); ++agent) {
    const bool lost = !IsTeamMode(game.settings.mode) && !end.agents[agent].alive;
    if (game.result == Result::kIncomplete && !lost) continue;
    record.setup.seats[agent] = {.searches = true, .teaches = Teaches::kMoves, .measured = true};
  }
  return record;
}

}  // namespace

PlaySummary& PlaySummary::operator+=(const PlaySummary& other) {
  games += other.games;
  decisions += other.decisions;
  score += other.score;
  steps += other.steps;
  for (std::size_t i = 0; i < actions.size(); ++i) actions[i] += other.actions[i];
  weights_versions += other.weights_versions;
  return *this;
}

void DataSet::Add(Lessons&& lessons, Part part) {
  std::ranges::move(lessons.samples,
                    std::back_inserter(part == Part::kTraining ? samples : held_out));
  play += lessons.play;
  exam += lessons.exam;
  if (lessons.result) results.push_back(*lessons.result);
}

std::variant<Lessons, std::string> MakeLessons(const GameRecord& game) {
  Teacher teacher(game);
  const auto reason = Verify(game, [&](const State& state, const JointAction& actions) {
    teacher.Observe(state, actions);
  });
  if (reason) return *reason;
  return teacher.TakeLessons();
}

std::variant<Lessons, std::string> MakeLessons(const RecordedGame& game, std::uint64_t ticket) {
  GameRecord record = RecordOf(game, ticket);
  Teacher teacher(record);
  State state = game.start;
  for (const RecordedStep& step : game.steps) {
    if (record.outcome.done) return StrCat("step ", state.step, ": the game is over before it");
    teacher.Observe(state, step.actions);
    Collapse(game.settings, state);
    Step(game.settings, step.actions, step.messages, state);
    record.outcome = OutcomeOf(game.settings, state);
    State collapsed = state;
    Collapse(game.settings, collapsed);
    if (collapsed != step.state) {
      return StrCat("step ", state.step, ": its position does not follow from the one before");
    }
  }
  if (game.result != record.outcome.result || game.winners != record.outcome.winners) {
    return "the result does not follow from its last position";
  }
  Lessons lessons = teacher.TakeLessons();
  lessons.result.reset();
  for (Sample& sample : lessons.samples) sample.end_step = state.step;
  return lessons;
}

}  // namespace powderkeg
