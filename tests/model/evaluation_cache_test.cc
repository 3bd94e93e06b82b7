#include "common/model/evaluation_cache.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <set>

#include "tests/model/positions.h"

namespace powderkeg {
namespace {

// Answers that tell positions apart, and counts the questions.
class CountingEvaluator final : public Evaluator {
 public:
  explicit CountingEvaluator(int* questions) : questions_(questions) {}
  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      ++*questions_;
      evaluations[i].policy.fill(static_cast<float>(positions[i].viewer));
      evaluations[i].value =
          static_cast<float>(positions[i].state->step) / static_cast<float>(settings.max_steps);
    }
  }
  [[nodiscard]] std::string name() const override { return "counting"; }

 private:
  int* questions_;
};

class EvaluationCacheTest : public testing::Test {
 protected:
  int questions_ = 0;
  EvaluationCache cache_{std::make_unique<CountingEvaluator>(&questions_), 1 << 20};
  std::vector<State> states_ = PlayedStates(50, /*seed=*/1);
  std::vector<Position> positions_ = PositionsOf(states_);
};

TEST_F(EvaluationCacheTest, SecondTimeNothingIsAsked) {
  const std::vector<Evaluation> first = EvaluateAll(cache_, positions_);
  EXPECT_EQ(questions_, 50);
  EXPECT_EQ(EvaluateAll(cache_, positions_), first);
  EXPECT_EQ(questions_, 50);
  EXPECT_EQ(cache_.hits(), 50U);
  EXPECT_EQ(cache_.misses(), 50U);
}

TEST_F(EvaluationCacheTest, MixedBatchesKeepTheirOrder) {
  int direct_questions = 0;
  CountingEvaluator direct(&direct_questions);
  (void)EvaluateAll(cache_, {positions_[3], positions_[17], positions_[3]});
  EXPECT_EQ(EvaluateAll(cache_, positions_), EvaluateAll(direct, positions_));
}

TEST_F(EvaluationCacheTest, APositionIsAskedOnceInABatch) {
  std::vector<Position> positions;
  for (int i = 0; i < 200; ++i) positions.push_back(positions_[static_cast<std::size_t>(i % 7)]);
  int direct_questions = 0;
  CountingEvaluator direct(&direct_questions);
  EXPECT_EQ(EvaluateAll(cache_, positions), EvaluateAll(direct, positions));
  EXPECT_EQ(questions_, 7);
  EXPECT_EQ(cache_.hits(), 193U);
  EXPECT_EQ(cache_.misses(), 7U);
}

TEST_F(EvaluationCacheTest, ClearForgetsAllAnswers) {
  (void)EvaluateAll(cache_, positions_);
  cache_.Clear();
  (void)EvaluateAll(cache_, positions_);
  EXPECT_EQ(questions_, 100);
  (void)EvaluateAll(cache_, positions_);
  EXPECT_EQ(questions_, 100);
}

TEST_F(EvaluationCacheTest, OtherSettingsAreOtherQuestions) {
  (void)EvaluateAll(cache_, positions_);
  std::vector<Evaluation> evaluations(positions_.size());
  cache_.Evaluate(GameSettings{.max_steps = 400}, positions_, evaluations);
  EXPECT_EQ(questions_, 100);
}

TEST_F(EvaluationCacheTest, FullCacheForgetsButNeverErrs) {
  EvaluationCache small(std::make_unique<CountingEvaluator>(&questions_), 1);
  int direct_questions = 0;
  CountingEvaluator direct(&direct_questions);
  const std::vector<Evaluation> expected = EvaluateAll(direct, positions_);
  for (int round = 0; round < 3; ++round) EXPECT_EQ(EvaluateAll(small, positions_), expected);
  EXPECT_EQ(small.hits() + small.misses(), 150U);
  EXPECT_GT(small.misses(), 100U);
}

TEST_F(EvaluationCacheTest, NameTellsTheInnerEvaluator) {
  EXPECT_EQ(cache_.name(), "cached counting");
}

TEST(PositionKey, EveryFieldCounts) {
  const State base = BusyState(Rng(4));
  std::vector<std::function<void(State&)>> changes = {
      [](State& s) { s.rigid ^= BitBoard::Of(120); },
      [](State& s) { s.wood ^= BitBoard::Of(0); },
      [](State& s) { s.item_low ^= BitBoard::Of(64); },
      [](State& s) { s.item_high ^= BitBoard::Of(63); },
      [](State& s) { s.flames[0] ^= BitBoard::Of(5); },
      [](State& s) { s.flames[1] ^= BitBoard::Of(5); },
      [](State& s) { s.flames[2] ^= BitBoard::Of(5); },
      [](State& s) { ++s.bombs[0].life; },
      [](State& s) { ++s.bombs[0].blast_strength; },
      [](State& s) { s.bombs[0].owner_and_direction ^= 1; },
      [](State& s) { s.bombs[--s.bomb_count] = Bomb{}; },
      [](State& s) { ++s.step; },
      [](State& s) { s.messages[0][0] ^= 1; },
  };
  for (std::size_t agent = 0; agent < kAgentCount; ++agent) {
    changes.emplace_back([agent](State& s) { s.agents[agent].cell ^= 1; });
    changes.emplace_back([agent](State& s) { ++s.agents[agent].ammo; });
    changes.emplace_back([agent](State& s) { ++s.agents[agent].blast_strength; });
    changes.emplace_back([agent](State& s) { s.agents[agent].alive ^= true; });
    changes.emplace_back([agent](State& s) { s.agents[agent].can_kick ^= true; });
  }
  std::set<std::pair<std::uint64_t, std::uint64_t>> keys;
  const auto insert = [&](const Position& position) {
    const PositionKey key = KeyOf(position);
    keys.emplace(key.low, key.high);
  };
  for (AgentId viewer = 0; viewer < kAgentCount; ++viewer) {
    insert({.state = &base, .viewer = viewer});
  }
  insert({.state = &base, .viewer = 0, .visible = BitBoard::Row(3)});
  for (const auto& change : changes) {
    State state = base;
    change(state);
    insert({.state = &state, .viewer = 0});
  }
  EXPECT_EQ(keys.size(), changes.size() + 5);
}

TEST(PositionKey, UnusedBombsAndPaddingDoNotCount) {
  const State state = BusyState(Rng(4));
  alignas(State) std::array<std::byte, sizeof(State)> memory;
  memory.fill(std::byte{0xAB});
  State* const copy = new (memory.data()) State;
  std::memcpy(static_cast<void*>(copy), &state, sizeof(State));
  ASSERT_LT(state.bomb_count, kMaxBombs);
  copy->bombs[kMaxBombs - 1].life = 3;
  EXPECT_EQ(KeyOf({.state = copy, .viewer = 1}), KeyOf({.state = &state, .viewer = 1}));
}

}  // namespace
}  // namespace powderkeg
