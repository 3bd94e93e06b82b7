#include "actors/search/enemy_moves.h"

#include <cmath>
#include <span>

#include "actors/search/portable_math.h"

namespace powderkeg {

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
    return BestAction(std::span(ply.urge).first<kActionCount>(), ConsideredMoves(settings, ply));
  }
  if (settings.widening == 0) return tree.Select(ply);
  return tree.SelectAmong(ply, ConsideredMoves(settings, ply));
}

}  // namespace powderkeg
