// 10,000 random games in every mode: turned boards, copies and the rules written down a second time
// lead to the same games.

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>

#include "common/pommerman/board_text.h"
#include "common/pommerman/step.h"
#include "common/pommerman/symmetry.h"
#include "tests/pommerman/random_game.h"
#include "tests/pommerman/reference_step.h"

namespace powderkeg {
namespace {

constexpr std::uint64_t kGames = 10'000;

// What everybody does and says in one step.
struct Turn {
  JointAction actions{};
  std::array<Message, kAgentCount> words{};
};

// Walks where it can and seldom lays a bomb, so that some games reach their last steps.
Action CarefulAction(ActionSet legal, Rng& rng) {
  const auto action = static_cast<Action>(rng.Below(kActionCount));
  const bool reckless = action == Action::kBomb && rng.Below(16) != 0;
  return reckless || (legal >> static_cast<int>(action) & 1) == 0 ? Action::kStop : action;
}

JointAction CarefulActions(const State& state, Rng& rng) {
  JointAction actions{};
  for (AgentId id = 0; id < kAgentCount; ++id) {
    if (state.agents[id].alive) actions[id] = CarefulAction(LegalActions(state, id), rng);
  }
  return actions;
}

std::array<Message, kAgentCount> RandomWords(Rng& rng) {
  std::array<Message, kAgentCount> words{};
  for (Message& message : words) {
    for (std::uint8_t& word : message) word = static_cast<std::uint8_t>(1 + rng.Below(8));
  }
  return words;
}

Turn Transform(Symmetry symmetry, Turn turn) {
  for (Action& action : turn.actions) action = powderkeg::Transform(symmetry, action);
  return turn;
}

Outcome Play(const GameSettings& settings, const Turn& turn, State& state) {
  Step(settings, turn.actions, turn.words, state);
  const Outcome outcome = OutcomeOf(settings, state);
  Collapse(settings, state);
  return outcome;
}

struct PlayedMode {
  std::string name;
  std::string environment;
};

class RandomGames : public testing::TestWithParam<PlayedMode> {
 protected:
  [[nodiscard]] Turn RandomTurn(std::uint64_t game, const State& state, Rng& rng) const {
    Turn turn{.actions = game % 4 == 3 ? CarefulActions(state, rng) : RandomActions(rng)};
    if (settings_.mode == Mode::kTeamRadio) turn.words = RandomWords(rng);
    return turn;
  }

  // Plays a step as it is, with a copy, turned, and by the reference.
  Outcome PlayEveryWay(const Turn& turn, Symmetry symmetry, State& state) const {
    const State before = state;
    const Outcome outcome = Play(settings_, turn, state);
    State copy = before;
    EXPECT_EQ(Play(settings_, turn, copy), outcome);
    State turned = Transform(symmetry, before);
    EXPECT_EQ(Play(settings_, Transform(symmetry, turn), turned), outcome);
    EXPECT_TRUE(copy == state) << ToText(before);
    EXPECT_TRUE(turned == Transform(symmetry, state)) << "symmetry " << symmetry << '\n'
                                                      << ToText(before);
    State reference = before;
    ReferenceStep(settings_, turn.actions, reference);
    reference.messages = copy.messages;
    Collapse(settings_, reference);
    EXPECT_TRUE(reference == state) << ToText(before);
    return outcome;
  }

  const GameSettings settings_ = GameSettingsFor(GetParam().environment).value();
};

// A small board comes to lie in another corner of the large one, among walls as before.
TEST_P(RandomGames, AreTheSameTurnedCopiedAndByTheReference) {
  std::uint64_t steps = 0;
  for (std::uint64_t seed = 0; seed < kGames && !HasFailure(); ++seed) {
    State state = RandomStart(settings_, seed);
    Rng rng = Rng(seed).Split(1);
    for (bool done = false; !done && !HasFailure(); ++steps) {
      const auto symmetry = static_cast<Symmetry>(1 + steps % (kSymmetryCount - 1));
      done = PlayEveryWay(RandomTurn(seed, state, rng), symmetry, state).done;
    }
  }
  std::printf("%llu games, %llu steps\n", static_cast<unsigned long long>(kGames),
              static_cast<unsigned long long>(steps));
}

INSTANTIATE_TEST_SUITE_P(
    EveryMode, RandomGames,
    testing::Values(PlayedMode{"FreeForAll", "PommeFFACompetition-v0"},
                    PlayedMode{"CollapsingFreeForAll", "PommeFFA-v1"},
                    PlayedMode{"TeamWithView", "PommeTeamCompetition-v0"},
                    PlayedMode{"CollapsingTeamWithView", "PommeTeamCompetition-v1"},
                    PlayedMode{"Radio", "PommeRadioCompetition-v2"},
                    PlayedMode{"OneVsOne", "OneVsOne-v0"}),
    [](const testing::TestParamInfo<PlayedMode>& test) { return test.param.name; });

}  // namespace
}  // namespace powderkeg
