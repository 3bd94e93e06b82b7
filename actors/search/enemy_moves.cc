#include "actors/search/enemy_moves.h"

#include <bit>
#include <cmath>

#include "actors/search/portable_math.h"

namespace powderkeg {
namespace {

std::size_t MostOwed(const Node& ply, ActionSet among) {
  auto best = static_cast<std::size_t>(std::countr_zero(among));
  for (std::size_t a = best + 1; a < kActionCount; ++a) {
    if (Has(among, a) && ply.urge[a] > ply.urge[best]) best = a;
  }
  return best;
}

}  // namespace

ActionSet ConsideredMoves(const SearchSettings& settings, const Node& ply) {
  if (settings.widening == 0) return ply.legal;
  const double visits = 1.0 + ply.visit_count;
  const double power = 1 / ExpOfNegative(-settings.widening_exponent * Log(visits));
  const double most = std::ceil(settings.widening * power);
  ActionSet left = ply.legal;
  ActionSet considered = 0;
  for (int count = 0; left != 0 && (count == 0 || count < most); ++count) {
    const auto likeliest = static_cast<unsigned>(BestAction(ply.prior, left));
    considered = static_cast<ActionSet>(considered | 1U << likeliest);
    left = static_cast<ActionSet>(left & ~considered);
  }
  return considered;
}

Action ChooseEnemyMove(const SearchSettings& settings, const Tree& tree, const Node& ply) {
  if (settings.simulated_moves == SimulatedMoves::kAsForetold) {
    return static_cast<Action>(MostOwed(ply, ConsideredMoves(settings, ply)));
  }
  if (settings.widening == 0) return tree.Select(ply);
  return tree.SelectAmong(ply, ConsideredMoves(settings, ply));
}

}  // namespace powderkeg
