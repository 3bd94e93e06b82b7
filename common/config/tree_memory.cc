#include "common/config/tree_memory.h"

#include <unistd.h>

#include <algorithm>
#include <set>
#include <utility>

#include "common/base/check.h"
#include "common/base/format.h"
#include "common/base/log.h"

namespace powderkeg {
namespace {

constexpr std::size_t kWorthALine = 500'000'000;

std::size_t MachineBytes() {
  return static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

std::string Gigabytes(std::size_t bytes) {
  return Format("%.1f GB", static_cast<double>(bytes) / 1e9);
}

}  // namespace

std::size_t TreeBytes(const AgentSpec& agent) {
  if (agent.kind != AgentSpec::Kind::kSearch) return 0;
  const SearchSettings& search = agent.search;
  int simulations = search.simulations;
  if (search.full_search_share < 1) simulations = std::max(simulations, search.fast_simulations);
  const int plies = search.tree == TreeKind::kTwoPlayer ? 2 : 1;
  return (1 + static_cast<std::size_t>(plies * simulations)) * kTreeNodeBytes;
}

std::size_t TreeBytesOfLoop(const SelfPlayConfig& config) {
  const Players players = ResolvePlayers(config);
  std::set<std::pair<int, bool>> trees;  // a player has others in exams
  for (const Lineup& lineup : players.lineups) {
    for (int seat = 0; seat < lineup.seat_count; ++seat) {
      trees.emplace(lineup.seats[static_cast<std::size_t>(seat)], lineup.exam);
    }
  }
  std::size_t bytes = 0;
  for (const auto& [player, exam] : trees) {
    bytes += TreeBytes(players.players[static_cast<std::size_t>(player)].agent);
  }
  const int games = config.games_in_flight * SeatCount(GameOf(config).mode);
  return bytes * static_cast<std::size_t>(games);
}

void WarnOfTrees(std::string_view whose, std::size_t bytes) {
  if (bytes < kWorthALine) return;
  log::Warn("search trees take much memory", "of", whose, "at_least", Gigabytes(bytes));
}

void RequireMemoryForTrees(std::string_view whose, std::size_t bytes) {
  if (bytes > MachineBytes()) {
    throw Error(StrCat("the search trees of ", whose, " take at least ", Gigabytes(bytes),
                       "; expected fewer simulations or games side by side, for the ",
                       Gigabytes(MachineBytes()), " of this machine"));
  }
  WarnOfTrees(whose, bytes);
}

}  // namespace powderkeg
