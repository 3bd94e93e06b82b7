#include "actors/pessimist/attraction.h"

namespace powderkeg {

void Attraction::Spread(BitBoard open) {
  BitBoard settled;
  BitBoard front;
  for (int worth = kMostWorth; worth > 0; --worth) {
    front = ((front & open).Neighbours() | goals_[static_cast<std::size_t>(worth)]) & ~settled;
    settled |= front;
    ForEachCell(front, [&](Cell cell) {
      worth_[static_cast<std::size_t>(cell)] = static_cast<std::uint8_t>(worth);
    });
  }
}

}  // namespace powderkeg
