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
  games.lineup.push_back(setup.lineup);
  games.to_the_end.push_back(setup.to_the_end ? 1 : 0);
  auto& searches = games.seat_searches.emplace_back();
  auto& policies = games.seat_policy.emplace_back();
  auto& teaches = games.seat_teaches.emplace_back();
  auto& measured = games.seat_measured.emplace_back();
  auto& players = games.seat_player.emplace_back();
  for (std::size_t i = 0; i < setup.seats.size(); ++i) {
    const Seat& seat = setup.seats[i];
    searches[i] = seat.searches ? 1 : 0;
    policies[i] = static_cast<std::uint8_t>(seat.policy);
    teaches[i] = static_cast<std::uint8_t>(seat.teaches);
    measured[i] = seat.measured ? 1 : 0;
    players[i] = seat.player;
  }
}

void AddOutcome(const Outcome& outcome, SegmentColumns::Games& games) {
  games.done.push_back(outcome.done ? 1 : 0);
  games.result.push_back(static_cast<std::uint8_t>(outcome.result));
  games.winners.push_back(outcome.winners);
  games.rewards.push_back(outcome.rewards);
}

void AddTracks(const GameRecord& game, SegmentColumns& columns) {
  const auto row = static_cast<std::uint32_t>(columns.games.ticket.size() - 1);
  auto& versions = columns.games.weights_version.emplace_back();
  auto& counts = columns.games.decision_count.emplace_back();
  SegmentColumns::Decisions& decisions = columns.decisions;
  for (std::uint8_t agent = 0; agent < kAgentCount; ++agent) {
    const Track& track = game.tracks[agent];
    versions[agent] = track.weights_version;
    counts[agent] = static_cast<std::uint32_t>(track.decisions.size());
    for (const Decision& decision : track.decisions) {
      decisions.game.push_back(row);
      decisions.agent.push_back(agent);
      decisions.step.push_back(decision.step);
      decisions.visits.push_back(decision.visits);
      decisions.value.push_back(decision.value);
      decisions.weights_version.push_back(decision.weights_version);
    }
  }
}

// The index of `name`, which is appended if it is new. A segment has few distinct names.
std::uint32_t IndexOf(const std::string& name, std::vector<std::string>& names) {
  const auto found = std::ranges::find(names, name);
  const auto index = static_cast<std::uint32_t>(found - names.begin());
  if (found == names.end()) names.push_back(name);
  return index;
}

Seat SeatAt(const SegmentColumns::Games& games, std::size_t row, std::size_t agent) {
  return {.searches = games.seat_searches[row][agent] != 0,
          .policy = EnumFrom(games.seat_policy[row][agent], PolicyKind::kIdle,
                             PolicyKind::kOfficialSimple, "games/seat_policy is unknown"),
          .teaches = EnumFrom(games.seat_teaches[row][agent], Teaches::kNothing, Teaches::kMoves,
                              "games/seat_teaches is unknown"),
          .measured = games.seat_measured[row][agent] != 0,
          .player = games.seat_player[row][agent]};
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
  setup.lineup = games.lineup[row];
  setup.to_the_end = games.to_the_end[row] != 0;
  for (std::size_t i = 0; i < setup.seats.size(); ++i) setup.seats[i] = SeatAt(games, row, i);
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
  return {.step = decisions.step[row],
          .visits = decisions.visits[row],
          .value = decisions.value[row],
          .weights_version = decisions.weights_version[row]};
}

// Reads games one after the other from columns that are whole.
class GameReader {
 public:
  explicit GameReader(const SegmentColumns& columns) : columns_(columns) {}

  [[nodiscard]] GameRecord Next() {
    const SegmentColumns::Games& games = columns_.games;
    Expect(games.evaluator[row_] < columns_.evaluators.size(), "games/evaluator has no name");
    GameRecord game{.ticket = games.ticket[row_],
                    .setup = SetupAt(games, row_),
                    .evaluator = columns_.evaluators[games.evaluator[row_]],
                    .actions = NextActions(),
                    .tracks = {},
                    .outcome = OutcomeAt(games, row_)};
    for (std::uint8_t agent = 0; agent < kAgentCount; ++agent)
      game.tracks[agent] = NextTrack(agent);
    ++row_;
    return game;
  }

  void ExpectEnd() const {
    Expect(step_ == columns_.steps.actions.size(), "steps/ goes on after the last game");
    Expect(decision_ == columns_.decisions.game.size(), "decisions/ goes on after the last game");
  }

 private:
  std::vector<JointAction> NextActions() {
    const std::size_t end = step_ + columns_.games.step_count[row_];
    Expect(end <= columns_.steps.actions.size(), "steps/ ends within a game");
    std::vector<JointAction> actions;
    actions.reserve(end - step_);
    for (; step_ < end; ++step_) actions.push_back(Unpack(columns_.steps.actions[step_]));
    return actions;
  }

  Track NextTrack(std::uint8_t agent) {
    const SegmentColumns::Decisions& decisions = columns_.decisions;
    Track track{.weights_version = columns_.games.weights_version[row_][agent], .decisions = {}};
    const std::size_t end = decision_ + columns_.games.decision_count[row_][agent];
    Expect(end <= decisions.game.size(), "decisions/ ends within a game");
    track.decisions.reserve(end - decision_);
    for (; decision_ < end; ++decision_) {
      Expect(decisions.game[decision_] == row_ && decisions.agent[decision_] == agent,
             "decisions/ is out of order");
      track.decisions.push_back(DecisionAt(decisions, decision_));
    }
    return track;
  }

  const SegmentColumns& columns_;
  std::size_t row_ = 0;  // of the game to read next, and its first rows:
  std::size_t step_ = 0;
  std::size_t decision_ = 0;
};

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
    columns.games.ticket.push_back(game.ticket);
    columns.games.step_count.push_back(static_cast<std::uint32_t>(game.actions.size()));
    columns.games.evaluator.push_back(IndexOf(game.evaluator, columns.evaluators));
    AddSetup(game.setup, columns.games);
    AddOutcome(game.outcome, columns.games);
    for (const JointAction& actions : game.actions) columns.steps.actions.push_back(Pack(actions));
    AddTracks(game, columns);
  }
  return columns;
}

void ForEachGame(const SegmentColumns& columns, const std::function<void(GameRecord&&)>& visit) {
  ExpectWholeTables(columns);
  GameReader reader(columns);
  for (std::size_t row = 0; row < columns.games.ticket.size(); ++row) visit(reader.Next());
  reader.ExpectEnd();
}

}  // namespace powderkeg
