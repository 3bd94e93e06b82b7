#include "common/segment/segment_columns.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {
namespace {

std::uint16_t Pack(const JointAction& actions) {
  std::uint32_t packed = 0;
  for (std::size_t i = 0; i < actions.size(); ++i) {
    packed |= static_cast<std::uint32_t>(actions[i]) << (4 * i);
  }
  return static_cast<std::uint16_t>(packed);
}

// What of a segment is not as specified.
void Expect(bool condition, const char* what) {
  if (!condition) throw Error(what);
}

JointAction Unpack(std::uint16_t packed) {
  JointAction actions;
  for (std::size_t i = 0; i < actions.size(); ++i) {
    const unsigned action = packed >> (4 * i) & 15;
    Expect(action < kActionCount, "steps/actions holds an action above 5");
    actions[i] = static_cast<Action>(action);
  }
  return actions;
}

template <typename Enum>
Enum EnumFrom(std::uint8_t value, Enum first, Enum last, const char* what) {
  Expect(value >= static_cast<std::uint8_t>(first) && value <= static_cast<std::uint8_t>(last),
         what);
  return static_cast<Enum>(value);
}

std::uint32_t Unsigned(int value) { return static_cast<std::uint32_t>(value); }

void AddSetup(const GameSetup& setup, SegmentColumns::Games& games) {
  const GameSettings& settings = setup.settings;
  games.seed.push_back(setup.seed);
  games.mode.push_back(static_cast<std::uint8_t>(settings.mode));
  games.board_size.push_back(Unsigned(settings.board_size));
  games.max_steps.push_back(Unsigned(settings.max_steps));
  games.blast_strength_cap.push_back(Unsigned(settings.blast_strength_cap));
  games.view_radius.push_back(Unsigned(settings.view_radius));
  auto& collapse_steps = games.collapse_steps.emplace_back();
  std::ranges::transform(settings.collapse_steps, collapse_steps.begin(), Unsigned);
  games.generator.push_back(static_cast<std::uint8_t>(setup.start.generator));
  games.corners.push_back(static_cast<std::uint8_t>(setup.start.corners));
  auto& searches = games.seat_searches.emplace_back();
  auto& policies = games.seat_policy.emplace_back();
  for (std::size_t i = 0; i < setup.seats.size(); ++i) {
    searches[i] = setup.seats[i].searches ? 1 : 0;
    policies[i] = static_cast<std::uint8_t>(setup.seats[i].policy);
  }
}

void AddOutcome(const Outcome& outcome, SegmentColumns::Games& games) {
  games.done.push_back(outcome.done ? 1 : 0);
  games.result.push_back(static_cast<std::uint8_t>(outcome.result));
  games.winners.push_back(outcome.winners);
  games.rewards.push_back(outcome.rewards);
}

void AddDecision(const Decision& decision, std::uint32_t game,
                 SegmentColumns::Decisions& decisions) {
  decisions.game.push_back(game);
  decisions.step.push_back(decision.step);
  decisions.agent.push_back(decision.agent);
  decisions.visits.push_back(decision.visits);
  decisions.value.push_back(decision.value);
  decisions.weights_version.push_back(decision.weights_version);
}

// The index of `name`, which is appended if it is new. A segment has few distinct names.
std::uint32_t IndexOf(const std::string& name, std::vector<std::string>& names) {
  const auto found = std::ranges::find(names, name);
  const auto index = static_cast<std::uint32_t>(found - names.begin());
  if (found == names.end()) names.push_back(name);
  return index;
}

GameSetup SetupAt(const SegmentColumns::Games& games, std::size_t row) {
  GameSetup setup;
  setup.seed = games.seed[row];
  setup.settings.mode =
      EnumFrom(games.mode[row], Mode::kFreeForAll, Mode::kOneVsOne, "games/mode is unknown");
  setup.settings.board_size = static_cast<int>(games.board_size[row]);
  setup.settings.max_steps = static_cast<int>(games.max_steps[row]);
  setup.settings.blast_strength_cap = static_cast<int>(games.blast_strength_cap[row]);
  setup.settings.view_radius = static_cast<int>(games.view_radius[row]);
  for (std::size_t ring = 0; ring < setup.settings.collapse_steps.size(); ++ring) {
    setup.settings.collapse_steps[ring] = static_cast<int>(games.collapse_steps[row][ring]);
  }
  setup.start.generator = EnumFrom(games.generator[row], BoardGenerator::kOfficial,
                                   BoardGenerator::kUniform, "games/generator is unknown");
  setup.start.corners = EnumFrom(games.corners[row], StartCorners::kOfficial,
                                 StartCorners::kPermuted, "games/corners is unknown");
  for (std::size_t i = 0; i < setup.seats.size(); ++i) {
    setup.seats[i].searches = games.seat_searches[row][i] != 0;
    setup.seats[i].policy = EnumFrom(games.seat_policy[row][i], PolicyKind::kIdle,
                                     PolicyKind::kOfficialSimple, "games/seat_policy is unknown");
  }
  return setup;
}

Outcome OutcomeAt(const SegmentColumns::Games& games, std::size_t row) {
  return {.done = games.done[row] != 0,
          .result = EnumFrom(games.result[row], Result::kIncomplete, Result::kTie,
                             "games/result is unknown"),
          .winners = games.winners[row],
          .rewards = games.rewards[row]};
}

Decision DecisionAt(const SegmentColumns::Decisions& decisions, std::size_t row) {
  Expect(decisions.agent[row] < kAgentCount, "decisions/agent is above 3");
  return {.step = decisions.step[row],
          .agent = decisions.agent[row],
          .visits = decisions.visits[row],
          .value = decisions.value[row],
          .weights_version = decisions.weights_version[row]};
}

// Columns of one table are equally long.
void ExpectWholeTables(const SegmentColumns& columns) {
  ForEachColumn(columns, [&](std::string_view name, const auto& column, const char*) {
    const std::size_t rows = name.starts_with("games/")   ? columns.games.ticket.size()
                             : name.starts_with("steps/") ? columns.steps.actions.size()
                                                          : columns.decisions.game.size();
    if (column.size() != rows) {
      throw Error(StrCat(name, " has ", column.size(), " rows, expected ", rows));
    }
  });
}

}  // namespace

SegmentColumns ToColumns(std::span<const GameRecord> games) {
  SegmentColumns columns;
  for (const GameRecord& game : games) {
    const auto row = static_cast<std::uint32_t>(columns.games.ticket.size());
    columns.games.ticket.push_back(game.ticket);
    columns.games.weights_version.push_back(game.weights_version);
    columns.games.step_count.push_back(static_cast<std::uint32_t>(game.actions.size()));
    columns.games.decision_count.push_back(static_cast<std::uint32_t>(game.decisions.size()));
    columns.games.evaluator.push_back(IndexOf(game.evaluator, columns.evaluators));
    AddSetup(game.setup, columns.games);
    AddOutcome(game.outcome, columns.games);
    for (const JointAction& actions : game.actions) columns.steps.actions.push_back(Pack(actions));
    for (const Decision& decision : game.decisions) {
      AddDecision(decision, row, columns.decisions);
    }
  }
  return columns;
}

void ForEachGame(const SegmentColumns& columns, const std::function<void(GameRecord&&)>& visit) {
  ExpectWholeTables(columns);
  const SegmentColumns::Games& games = columns.games;
  std::size_t step = 0;
  std::size_t decision = 0;
  for (std::size_t row = 0; row < games.ticket.size(); ++row) {
    const std::size_t steps_end = step + games.step_count[row];
    const std::size_t decisions_end = decision + games.decision_count[row];
    Expect(steps_end <= columns.steps.actions.size(), "steps/ ends within a game");
    Expect(decisions_end <= columns.decisions.game.size(), "decisions/ ends within a game");
    Expect(games.evaluator[row] < columns.evaluators.size(), "games/evaluator has no name");
    GameRecord game{.ticket = games.ticket[row],
                    .setup = SetupAt(games, row),
                    .weights_version = games.weights_version[row],
                    .evaluator = columns.evaluators[games.evaluator[row]],
                    .actions = {},
                    .decisions = {},
                    .outcome = OutcomeAt(games, row)};
    game.actions.reserve(games.step_count[row]);
    game.decisions.reserve(games.decision_count[row]);
    for (; step < steps_end; ++step) game.actions.push_back(Unpack(columns.steps.actions[step]));
    for (; decision < decisions_end; ++decision) {
      Expect(columns.decisions.game[decision] == row, "decisions/game is out of order");
      game.decisions.push_back(DecisionAt(columns.decisions, decision));
    }
    visit(std::move(game));
  }
  Expect(step == columns.steps.actions.size(), "steps/ goes on after the last game");
  Expect(decision == columns.decisions.game.size(), "decisions/ goes on after the last game");
}

}  // namespace powderkeg
