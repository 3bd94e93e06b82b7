#include "actors/play/seat_statistics.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/play/support.h"

namespace powderkeg {
namespace {

StepEvents DeathOf(AgentId victim, AgentSet killers) {
  StepEvents events;
  events.burnt = static_cast<AgentSet>(1 << victim);
  events.killers[victim] = killers;
  return events;
}

TEST(CountEvents, CountsBombsAndKicks) {
  GameStatistics statistics{};
  CountEvents({.laid = 0b0101, .kicked = 0b0100}, Mode::kFreeForAll, statistics);
  CountEvents({.laid = 0b0001}, Mode::kFreeForAll, statistics);
  EXPECT_EQ(statistics[0].bombs, 2u);
  EXPECT_EQ(statistics[2].bombs, 1u);
  EXPECT_EQ(statistics[2].kicks, 1u);
  EXPECT_EQ(statistics[1].bombs + statistics[3].bombs + statistics[0].kicks, 0u);
}

TEST(CountEvents, CountsADeathForEachKillerButTheVictim) {
  GameStatistics statistics{};
  CountEvents(DeathOf(/*victim=*/1, 0b1110), Mode::kFreeForAll, statistics);
  EXPECT_EQ(statistics[2].kills, 1u);
  EXPECT_EQ(statistics[3].kills, 1u);
  EXPECT_EQ(statistics[1].kills, 0u);
  EXPECT_EQ(statistics[1].own_deaths, 0u);  // others had a share in it
}

TEST(CountEvents, CountsOwnDeathsApart) {
  GameStatistics statistics{};
  CountEvents(DeathOf(/*victim=*/1, 0b0010), Mode::kFreeForAll, statistics);
  CountEvents(DeathOf(/*victim=*/2, 0), Mode::kFreeForAll, statistics);  // nobody knows
  EXPECT_EQ(statistics[1].own_deaths, 1u);
  EXPECT_EQ(statistics[1].kills, 0u);
  EXPECT_EQ(statistics[2].own_deaths, 0u);
}

TEST(CountEvents, CountsMatesApart) {
  GameStatistics statistics{};
  CountEvents(DeathOf(/*victim=*/1, 0b1001), Mode::kTeam, statistics);
  EXPECT_EQ(statistics[0].kills, 1u);
  EXPECT_EQ(statistics[3].kills, 0u);
  EXPECT_EQ(statistics[3].mate_kills, 1u);
}

TEST(RecentCells, CountsDistinctCellsOfTheLastTwentyMoves) {
  RecentCells recent;
  SeatStatistics statistics;
  for (Cell cell = 0; cell < 19; ++cell) CountCell(cell, kBoardSize, recent, statistics);
  EXPECT_FALSE(recent.full());
  EXPECT_EQ(statistics.windows, 0u);
  CountCell(0, kBoardSize, recent, statistics);  // cells 0 to 18 in 20 moves
  EXPECT_EQ(statistics.windows, 1u);
  EXPECT_EQ(statistics.window_cells, 19u);
  CountCell(120, kBoardSize, recent,
            statistics);  // the first move drops out, its cell is still there
  EXPECT_EQ(recent.Distinct(), 20);
  for (int i = 0; i < 30; ++i) CountCell(5, kBoardSize, recent, statistics);
  EXPECT_EQ(recent.Distinct(), 1);
  EXPECT_EQ(statistics.windows, 32u);
}

TEST(CountCell, MirrorsTheBoardSoThatEveryStartIsTopLeft) {
  // Row and column of a start, of a cell two rows below it on the mirrored board, and the size.
  constexpr std::array<std::array<int, 5>, 5> kStarts = {
      {{1, 1, 3, 1, 11}, {9, 1, 7, 1, 11}, {9, 9, 7, 9, 11}, {1, 9, 3, 9, 11}, {6, 6, 4, 6, 8}}};
  for (const auto& [row, column, next_row, next_column, board_size] : kStarts) {
    RecentCells recent;
    SeatStatistics statistics;
    CountCell(CellAt(row, column), board_size, recent, statistics);
    CountCell(CellAt(next_row, next_column), board_size, recent, statistics);
    EXPECT_EQ(statistics.cells[CellAt(1, 1)], 1u) << row << " " << column;
    EXPECT_EQ(statistics.cells[CellAt(3, 1)], 1u) << row << " " << column;
  }
}

TEST(SeatStatistics, AddsUpEverything) {
  SeatStatistics one;
  one.bombs = 1;
  one.kicks = 2;
  one.kills = 3;
  one.mate_kills = 4;
  one.own_deaths = 5;
  one.cells[7] = 6;
  one.windows = 7;
  one.window_cells = 8;
  SeatStatistics sum = one;
  sum += one;
  EXPECT_EQ(sum.bombs, 2u);
  EXPECT_EQ(sum.kicks, 4u);
  EXPECT_EQ(sum.kills, 6u);
  EXPECT_EQ(sum.mate_kills, 8u);
  EXPECT_EQ(sum.own_deaths, 10u);
  EXPECT_EQ(sum.cells[7], 12u);
  EXPECT_EQ(sum.windows, 14u);
  EXPECT_EQ(sum.window_cells, 16u);
}

// Every move is on a cell, bombs are laid by bomb actions, and whoever died was killed by somebody.
TEST(Game, CountsAgreeWithEachOther) {
  std::uint32_t kills = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    GamePlan plan;
    plan.setup = SetupOfSeats(
        {kSimpleUnbiasedSeat, kSimpleUnbiasedSeat, kSimpleUnbiasedSeat, kSimpleUnbiasedSeat}, seed);
    Game game;
    EvaluationBatches batches;
    game.Start(plan);
    ASSERT_FALSE(game.Gather(batches));
    std::uint32_t shares = 0;  // in deaths
    std::uint32_t deaths = 0;
    for (AgentId seat = 0; seat < kAgentCount; ++seat) {
      const SeatStatistics& statistics = game.statistics(seat);
      EXPECT_EQ(std::accumulate(statistics.cells.begin(), statistics.cells.end(), 0u),
                statistics.moves);
      EXPECT_LE(statistics.bombs, statistics.actions[static_cast<std::size_t>(Action::kBomb)]);
      EXPECT_EQ(statistics.windows, statistics.moves < 20 ? 0 : statistics.moves - 19);
      EXPECT_LE(statistics.window_cells, 20u * statistics.windows);
      shares += statistics.kills + statistics.own_deaths;
      deaths += game.state().agents[seat].alive ? 0 : 1;
      kills += statistics.kills;
    }
    EXPECT_GE(shares, deaths) << "seed " << seed;
  }
  EXPECT_GT(kills, 0u);
}

}  // namespace
}  // namespace powderkeg
