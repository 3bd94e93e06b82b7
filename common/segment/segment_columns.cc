#include "common/segment/segment_columns.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

#include "common/base/byte_stream.h"
#include "common/base/check.h"
#include "common/base/digest.h"

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

// Throws Error if the rows are not all there.
void ExpectRows(std::uint64_t first, std::uint64_t count, std::size_t rows, const char* what) {
  Expect(first <= rows && count <= rows - first, what);
}

std::vector<JointAction> ActionsAt(const SegmentColumns& columns, std::size_t row) {
  const std::vector<std::uint16_t>& steps = columns.steps.actions;
  const std::uint64_t first = columns.games.first_step[row];
  const std::uint64_t count = columns.games.step_count[row];
  ExpectRows(first, count, steps.size(), "steps/ ends within a game");
  std::vector<JointAction> actions;
  actions.reserve(count);
  for (std::uint64_t i = first; i < first + count; ++i) actions.push_back(Unpack(steps[i]));
  return actions;
}

std::array<Track, kAgentCount> TracksAt(const SegmentColumns& columns, std::size_t row) {
  const SegmentColumns::Decisions& decisions = columns.decisions;
  std::array<Track, kAgentCount> tracks;
  std::uint64_t next = columns.games.first_decision[row];
  for (std::uint8_t agent = 0; agent < kAgentCount; ++agent) {
    const std::uint64_t count = columns.games.decision_count[row][agent];
    ExpectRows(next, count, decisions.game.size(), "decisions/ ends within a game");
    tracks[agent].weights_version = columns.games.weights_version[row][agent];
    tracks[agent].decisions.reserve(count);
    for (const std::uint64_t end = next + count; next < end; ++next) {
      Expect(decisions.game[next] == row && decisions.agent[next] == agent,
             "decisions/ is out of order");
      tracks[agent].decisions.push_back(DecisionAt(decisions, next));
    }
  }
  return tracks;
}

void AddGame(const GameRecord& game, SegmentColumns& columns) {
  columns.games.ticket.push_back(game.ticket);
  columns.games.first_step.push_back(columns.steps.actions.size());
  columns.games.step_count.push_back(Unsigned(static_cast<int>(game.actions.size())));
  columns.games.first_decision.push_back(columns.decisions.game.size());
  columns.games.evaluator.push_back(IndexOf(game.evaluator, columns.evaluators));
  columns.games.checksum.push_back(0);
  AddSetup(game.setup, columns.games);
  AddOutcome(game.outcome, columns.games);
  for (const JointAction& actions : game.actions) columns.steps.actions.push_back(Pack(actions));
  AddTracks(game, columns);
}

std::uint32_t ChecksumOf(const GameRecord& game) {
  SegmentColumns alone;
  AddGame(game, alone);
  ByteWriter bytes;
  ForEachColumn(alone, [&](const char*, const auto& column, const char*) {
    const std::span rows(column);
    bytes.WriteAll(
        std::span(reinterpret_cast<const std::uint8_t*>(rows.data()), rows.size_bytes()));
  });
  bytes.WriteAll(BytesOf(game.evaluator));
  return Crc32c(bytes.Take());
}

GameRecord GameAt(const SegmentColumns& columns, std::size_t row) {
  const SegmentColumns::Games& games = columns.games;
  Expect(games.evaluator[row] < columns.evaluators.size(), "games/evaluator has no name");
  GameRecord game{.ticket = games.ticket[row],
                  .setup = SetupAt(games, row),
                  .evaluator = columns.evaluators[games.evaluator[row]],
                  .actions = ActionsAt(columns, row),
                  .tracks = TracksAt(columns, row),
                  .outcome = OutcomeAt(games, row)};
  Expect(games.checksum[row] == ChecksumOf(game), "games/checksum is wrong");
  return game;
}

// What keeps columns of one table from being equally long; empty: nothing.
std::string Unevenness(const SegmentColumns& columns) {
  std::string uneven;
  ForEachColumn(columns, [&](std::string_view name, const auto& column, const char*) {
    const std::size_t rows = name.starts_with("games/")   ? columns.games.ticket.size()
                             : name.starts_with("steps/") ? columns.steps.actions.size()
                                                          : columns.decisions.game.size();
    if (column.size() == rows) return;
    uneven = StrCat(name, " has ", column.size(), " rows, expected ", rows);
  });
  return uneven;
}

}  // namespace

SegmentColumns ToColumns(std::span<const GameRecord> games) {
  SegmentColumns columns;
  for (const GameRecord& game : games) {
    AddGame(game, columns);
    columns.games.checksum.back() = ChecksumOf(game);
  }
  return columns;
}

std::string ForEachWholeGame(const SegmentColumns& columns,
                             const std::function<void(GameRecord&&)>& visit) {
  std::string damage = Unevenness(columns);
  if (!damage.empty()) return damage;
  for (std::size_t row = 0; row < columns.games.ticket.size(); ++row) {
    std::optional<GameRecord> game;
    try {
      game = GameAt(columns, row);
    } catch (const Error& error) {
      damage = error.what();
    }
    if (game) visit(*std::move(game));
  }
  return damage;
}

}  // namespace powderkeg
