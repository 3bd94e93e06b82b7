#include "learner/train/batch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>

#include "common/model/planes.h"
#include "tests/learner/played_games.h"

namespace powderkeg {
namespace {

using testing::FloatEq;
using testing::Pointwise;

TEST(PolicyTarget, MixesTheVisitsWithTheirLargest) {
  EXPECT_THAT(PolicyTarget({1, 0, 2, 0, 1, 0}, 0.0),
              Pointwise(FloatEq(), {.25, 0., .5, 0., .25, 0.}));
  EXPECT_THAT(PolicyTarget({1, 0, 2, 0, 1, 0}, 0.5),
              Pointwise(FloatEq(), {.125, 0., .75, 0., .125, 0.}));
  EXPECT_THAT(PolicyTarget({3, 0, 1, 0, 0, 0}, 1.0),
              Pointwise(FloatEq(), {1., 0., 0., 0., 0., 0.}));
}

TEST(PolicyTarget, TiesGoToTheFirstAction) {
  EXPECT_THAT(PolicyTarget({0, 7, 0, 0, 7, 0}, 0.5),
              Pointwise(FloatEq(), {0., .75, 0., 0., .25, 0.}));
}

TEST(PolicyTarget, WithoutVisitsThereIsNone) {
  EXPECT_THAT(PolicyTarget({}, 0.0), testing::Each(0.0F));
  EXPECT_THAT(PolicyTarget({}, 0.5), testing::Each(0.0F));
}

TEST(PolicyTarget, LargeCountsDoNotOverflow) {
  EXPECT_THAT(PolicyTarget({65535, 65535, 65535, 65535, 65535, 65535}, 0.0),
              testing::Each(FloatEq(1.0F / 6)));
}

std::vector<Sample> SamplesOf(std::uint64_t ticket) {
  DataSet data_set;
  AddGame(PlayGame(ticket), data_set);
  return data_set.samples;
}

std::vector<float> PlanesOf(const State& state, AgentId viewer) {
  std::vector<float> planes(kPlanesSize);
  EncodePlanes(GameSettings{}, {&state, viewer},
               std::span(planes).first<static_cast<std::size_t>(kPlanesSize)>());
  return planes;
}

// Each sample of a batch must be exactly one of its eight turned versions, policy included.
TEST(Batch, SamplesAreTurnedAsAWhole) {
  const std::vector<Sample> samples = SamplesOf(3);
  const Sample& sample = samples[samples.size() / 2];
  const std::vector<const Sample*> same(200, &sample);
  Rng rng(4);
  TrainingBatch batch;
  BuildBatch(GameSettings{}, {.argmax_weight = 0.5}, same, rng, batch);
  ASSERT_EQ(batch.size, same.size());
  const auto target = PolicyTarget(sample.visits, 0.5);
  std::set<Symmetry> seen;
  for (std::size_t i = 0; i < batch.size; ++i) {
    const std::vector<float> planes(batch.planes.begin() + static_cast<long>(i) * kPlanesSize,
                                    batch.planes.begin() + static_cast<long>(i + 1) * kPlanesSize);
    int matches = 0;
    for (Symmetry symmetry = 0; symmetry < kSymmetryCount; ++symmetry) {
      bool equal = planes == PlanesOf(Transform(symmetry, sample.state), sample.viewer);
      for (int action = 0; action < kActionCount; ++action) {
        const auto turned = static_cast<std::size_t>(Transform(symmetry, Action(action)));
        equal = equal && batch.policies[i * kActionCount + turned] == target[action];
      }
      if (!equal) continue;
      ++matches;
      seen.insert(symmetry);
    }
    EXPECT_GE(matches, 1);
    EXPECT_EQ(batch.values[i], sample.outcome);
  }
  EXPECT_EQ(seen.size(), 8u);
}

TEST(Batch, SmallBoardsAreNotTurned) {
  Sample sample = SamplesOf(3)[0];
  GameSettings settings;
  settings.board_size = 8;
  const std::vector<const Sample*> same(20, &sample);
  Rng rng(4);
  TrainingBatch batch;
  BuildBatch(settings, {.argmax_weight = 0.5}, same, rng, batch);
  for (std::size_t i = 1; i < batch.size; ++i) {
    EXPECT_TRUE(std::equal(batch.planes.begin(), batch.planes.begin() + kPlanesSize,
                           batch.planes.begin() + static_cast<long>(i) * kPlanesSize));
  }
}

TEST(Batch, ValuesMixTheOutcomeWithWhatTheSearchFound) {
  Sample sample = SamplesOf(3)[0];
  sample.search_value = 0.5F;
  const auto value = [&sample](int outcome, const TargetSettings& targets) {
    sample.outcome = static_cast<std::int8_t>(outcome);
    const std::vector<const Sample*> one = {&sample};
    Rng rng(4);
    TrainingBatch batch;
    BuildBatch(GameSettings{}, targets, one, rng, batch);
    return batch.values[0];
  };
  EXPECT_EQ(value(-1, {}), -1.0F);
  EXPECT_EQ(value(0, {}), 0.0F);
  EXPECT_EQ(value(-1, {.search_value_weight = 0.25}), -0.625F);
  EXPECT_EQ(value(0, {.outcome_values = {.draw = -0.5}}), -0.5F);
  EXPECT_EQ(value(1, {.outcome_values = {.draw = -0.5}}), 1.0F);
  EXPECT_EQ(value(0, {.outcome_values = {.draw = -0.5}, .search_value_weight = 1}), 0.5F);
  sample.end_step = 200;  // of 800
  EXPECT_EQ(value(1, {.outcome_values = {.late_win = 0}}), 0.75F);
  EXPECT_EQ(value(-1, {.outcome_values = {.late_win = 0}}), -1.0F);
}

TEST(Batch, EqualGeneratorsGiveEqualBatches) {
  const std::vector<Sample> samples = SamplesOf(6);
  std::vector<const Sample*> pointers;
  for (const Sample& sample : samples) pointers.push_back(&sample);
  TrainingBatch first;
  TrainingBatch second;
  Rng rng(9);
  Rng same(9);
  BuildBatch(GameSettings{}, {.argmax_weight = 0.5}, pointers, rng, first);
  BuildBatch(GameSettings{}, {.argmax_weight = 0.5}, pointers, same, second);
  EXPECT_EQ(first.planes, second.planes);
  EXPECT_EQ(first.policies, second.policies);
}

// The likeliest action of an other, or none.
std::optional<Action> DidOf(const TrainingBatch& batch, std::size_t sample, std::size_t other) {
  const float* const row = batch.others.data() + (sample * 3 + other) * kActionCount;
  for (int action = 0; action < kActionCount; ++action) {
    if (row[action] == 1) return static_cast<Action>(action);
  }
  return std::nullopt;
}

TEST(Batch, HoldsWhatTheOthersDidNext) {
  const std::vector<Sample> samples = SamplesOf(3);
  for (const Sample& sample : samples) {
    const std::vector<const Sample*> one = {&sample};
    TrainingBatch batch;
    GameSettings small_board;
    small_board.board_size = 8;  // nothing is turned
    Rng rng(1);
    BuildBatch(small_board, {}, one, rng, batch);
    for (std::size_t i = 0; i < 3; ++i) {
      const AgentId agent = static_cast<AgentId>((sample.viewer + 1 + i) % 4);
      const auto did = DidOf(batch, 0, i);
      ASSERT_EQ(did.has_value(), sample.state.agents[static_cast<std::size_t>(agent)].alive);
      if (!did) continue;
      const ActionSet legal = LegalActions(sample.state, agent);
      const bool possible = (legal >> static_cast<int>(sample.others[i]) & 1) != 0;
      EXPECT_EQ(*did, possible ? sample.others[i] : Action::kStop);
      for (int action = 0; action < kActionCount; ++action) {
        EXPECT_EQ(batch.others_legal[i * kActionCount + static_cast<std::size_t>(action)],
                  static_cast<float>(legal >> action & 1));
      }
    }
  }
}

TEST(Batch, TurnsTheOthersWithTheBoard) {
  const std::vector<Sample> samples = SamplesOf(3);
  const Sample& sample = samples[samples.size() / 2];
  const std::vector<const Sample*> same(200, &sample);
  Rng rng(4);
  TrainingBatch batch;
  BuildBatch({}, {}, same, rng, batch);
  std::set<Action> seen;
  for (std::size_t i = 0; i < same.size(); ++i) {
    for (int turn = 0; turn < kSymmetryCount; ++turn) {
      const auto symmetry = static_cast<Symmetry>(turn);
      const std::vector<float> planes = PlanesOf(Transform(symmetry, sample.state), sample.viewer);
      if (!std::equal(planes.begin(), planes.end(),
                      batch.planes.begin() + static_cast<std::ptrdiff_t>(i * planes.size()))) {
        continue;
      }
      for (std::size_t other = 0; other < 3; ++other) {
        const auto did = DidOf(batch, i, other);
        if (!did) continue;
        const ActionSet legal = LegalActions(
            sample.state, static_cast<AgentId>((sample.viewer + 1 + other) % kAgentCount));
        const Action expected = (legal >> static_cast<int>(sample.others[other]) & 1) != 0
                                    ? sample.others[other]
                                    : Action::kStop;
        EXPECT_EQ(*did, Transform(symmetry, expected));
        seen.insert(*did);
      }
    }
  }
  EXPECT_GT(seen.size(), 1u);
}

}  // namespace
}  // namespace powderkeg
