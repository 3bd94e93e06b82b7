#include "tests/model/positions.h"

#include <algorithm>
#include <cmath>

#include "common/pommerman/generate.h"
#include "common/pommerman/step.h"

namespace powderkeg {
namespace {

int Between(Rng& rng, int low, int high) {
  return low + static_cast<int>(rng.Below(static_cast<std::uint32_t>(high - low + 1)));
}

JointAction RandomLegalActions(const State& state, Rng& rng) {
  JointAction actions{};
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (!state.agents[static_cast<std::size_t>(agent)].alive) continue;
    const ActionSet legal = LegalActions(state, agent);
    int action = Between(rng, 0, kActionCount - 1);
    while ((legal >> action & 1) == 0) action = Between(rng, 0, kActionCount - 1);
    actions[static_cast<std::size_t>(agent)] = static_cast<Action>(action);
  }
  return actions;
}

}  // namespace

std::vector<State> PlayedStates(int count, std::uint64_t seed) {
  Rng rng(seed);
  const GameSettings settings;
  std::vector<State> states;
  State state = GenerateStart(settings, StartSettings{}, rng.Split(0));
  while (std::ssize(states) < count) {
    states.push_back(state);
    for (int step = 0; step < 5; ++step) {
      if (Advance(settings, RandomLegalActions(state, rng), state).done) {
        state = GenerateStart(settings, StartSettings{}, rng.Split(states.size()));
      }
    }
  }
  return states;
}

State BusyState(Rng rng) {
  State state;
  for (Cell cell = 0; cell < kCellCount; ++cell) {
    switch (rng.Below(12)) {
      case 0: state.rigid.Add(cell); break;
      case 1: state.wood.Add(cell); [[fallthrough]];
      case 2: state.SetItem(cell, static_cast<Item>(rng.Below(4))); break;
      case 3: state.flames[rng.Below(3)].Add(cell); break;
      case 4: {
        if (state.bomb_count == kMaxBombs) break;
        Bomb bomb{.cell = static_cast<std::uint8_t>(cell),
                  .life = static_cast<std::int8_t>(Between(rng, 1, 9)),
                  .blast_strength = static_cast<std::uint8_t>(Between(rng, 2, 14))};
        bomb.set_owner(Between(rng, 0, 3));
        bomb.set_direction(static_cast<Direction>(rng.Below(5)));
        state.AddBomb(bomb);
        break;
      }
      default: break;
    }
  }
  for (AgentState& agent : state.agents) {
    agent = {.cell = static_cast<std::uint8_t>(rng.Below(kCellCount)),
             .ammo = static_cast<std::uint8_t>(rng.Below(4)),
             .blast_strength = static_cast<std::uint8_t>(Between(rng, 2, 10)),
             .alive = rng.Below(4) != 0,
             .can_kick = rng.Below(2) != 0};
  }
  state.messages[2] = {3, 4};
  state.step = static_cast<std::uint16_t>(rng.Below(801));
  return state;
}

Snapshot RandomWeights(const NetworkDescription& description, std::uint64_t seed) {
  Rng rng(seed);
  WeightsSnapshot snapshot = InitialWeights(description, rng.Split(0));
  snapshot.version = 7;
  for (NamedArray& array : snapshot.arrays) {
    const bool is_norm = array.name.find("bn") != std::string::npos;
    const bool is_last = array.name == "policy.fc.weight" || array.name == "value.fc2.weight" ||
                         array.name == "own.policy.weight" || array.name == "others.policy.weight";
    for (float& value : array.values) {
      if (is_norm) value += 0.4F * static_cast<float>(rng.Uniform() - 0.5);
      if (is_last) value *= 10.0F;
    }
  }
  return std::make_shared<const WeightsSnapshot>(std::move(snapshot));
}

std::vector<Position> PositionsOf(const std::vector<State>& states) {
  std::vector<Position> positions;
  for (const State& state : states) {
    const bool fog = positions.size() % 5 == 4;
    positions.push_back({.state = &state,
                         .viewer = static_cast<AgentId>(positions.size()) % kAgentCount,
                         .visible = fog ? BitBoard::Row(2) | BitBoard::Row(3) : BitBoard::All()});
  }
  return positions;
}

std::vector<Evaluation> EvaluateAll(Evaluator& evaluator, const std::vector<Position>& positions) {
  std::vector<Evaluation> evaluations(positions.size());
  evaluator.Evaluate(GameSettings{}, positions, evaluations);
  return evaluations;
}

CanaryDifference Compare(const std::vector<Evaluation>& a, const std::vector<Evaluation>& b) {
  CanaryDifference largest;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t action = 0; action < kActionCount; ++action) {
      largest.policy =
          std::max(largest.policy, std::abs(a[i].policy[action] - b[i].policy[action]));
    }
    for (std::size_t other = 0; other < a[i].others.size(); ++other) {
      for (std::size_t action = 0; action < kActionCount; ++action) {
        const int distance = int{a[i].others[other][action]} - b[i].others[other][action];
        const int beyond_rounding = std::max(0, std::abs(distance) - 1);
        largest.policy = std::max(largest.policy, static_cast<float>(beyond_rounding) / 255);
      }
    }
    largest.value = std::max(largest.value, std::abs(a[i].value - b[i].value));
  }
  return largest;
}

}  // namespace powderkeg
