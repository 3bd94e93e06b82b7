#include "actors/search/gumbel_root.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "actors/search/portable_math.h"

namespace powderkeg {
namespace {

using testing::ElementsAre;
using Counts = std::array<std::uint32_t, kActionCount>;

constexpr RootStatistics kRoot = {.priors = {0.3F, 0.25F, 0.2F, 0.1F, 0.1F, 0.05F}};

SearchSettings Considering(int actions, int simulations) {
  SearchSettings settings = GumbelSettings();
  settings.simulations = simulations;
  settings.gumbel_scale = 0;
  settings.gumbel_considered = actions;
  return settings;
}

// Runs a search of which every simulation through an action finds that action's value.
Counts Share(const SearchSettings& settings, RootStatistics root,
             const std::array<float, kActionCount>& values, SequentialHalving& halving) {
  Rng rng(1);
  halving.Start(settings, root, rng);
  for (int i = 0; i < settings.simulations; ++i) {
    const auto a = static_cast<std::size_t>(halving.Next(root));
    ++root.visits[a];
    root.values[a] = values[a];
  }
  return root.visits;
}

TEST(PortableMath, AgreesWithTheLibrary) {
  for (const double x : {1e-12, 1e-3, 0.5, 0.99, 1.0, 1.5, 7.0, 1e6}) {
    EXPECT_NEAR(Log(x), std::log(x), 1e-13 * (1 + std::abs(std::log(x)))) << x;
    EXPECT_NEAR(LogOnePlus(x), std::log1p(x), 1e-13 * (1 + std::log1p(x))) << x;
  }
  for (const double x : {0.0, -1e-9, -0.3, -1.0, -20.0, -150.0, -699.0}) {
    EXPECT_NEAR(ExpOfNegative(x) / std::exp(x), 1, 1e-12) << x;
  }
  EXPECT_EQ(ExpOfNegative(-1000), 0);
}

// --- The improved policy -------------------------------------------------------------------------

TEST(ImprovedPolicy, WithoutVisitsIsThePriorOfLegalActions) {
  RootStatistics root = kRoot;
  root.legal = 0b010011;
  const auto policy = ImprovedPolicy(GumbelSettings(), root);
  EXPECT_NEAR(policy[0], 0.3 / 0.65, 1e-6);
  EXPECT_NEAR(policy[1], 0.25 / 0.65, 1e-6);
  EXPECT_NEAR(policy[4], 0.1 / 0.65, 1e-6);
  EXPECT_EQ(policy[2] + policy[3] + policy[5], 0);
}

// By hand: v_mix = (0.2 + 4 (0.3 * 0.5 - 0.25 * 0.5) / 0.55) / 5, sigma(q) = 53 c_scale (q + 1)
// / 2.
TEST(ImprovedPolicy, FollowsTheFormula) {
  RootStatistics root = kRoot;
  root.legal = 0b000111;
  root.visits = {3, 1, 0, 0, 0, 0};
  root.values = {0.5F, -0.5F, 0, 0, 0, 0};
  root.evaluation = 0.2F;
  SearchSettings settings = GumbelSettings();
  settings.gumbel_c_scale = 0.1;
  const double mixed = (0.2 + 4 * (0.3 * 0.5 - 0.25 * 0.5) / 0.55) / 5;
  const std::array<double, 3> weights = {0.3 * std::exp(5.3 * 1.5 / 2), 0.25 * std::exp(5.3 * 0.25),
                                         0.2 * std::exp(5.3 * (mixed + 1) / 2)};
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  const auto policy = ImprovedPolicy(settings, root);
  for (std::size_t a = 0; a < weights.size(); ++a) EXPECT_NEAR(policy[a], weights[a] / total, 1e-6);
}

// Theorem of the paper: under the completed values it is worth at least as much as the priors.
TEST(ImprovedPolicy, IsNeverWorthLessThanThePrior) {
  Rng rng(5);
  for (int i = 0; i < 1000; ++i) {
    RootStatistics root;
    double total = 0;
    double worth = 0;
    for (std::size_t a = 0; a < kActionCount; ++a) {
      root.priors[a] = static_cast<float>(rng.Uniform());
      root.values[a] = static_cast<float>(2 * rng.Uniform() - 1);
      root.visits[a] = 1 + rng.Below(50);
      total += static_cast<double>(root.priors[a]);
      worth += static_cast<double>(root.priors[a] * root.values[a]);
    }
    double improved = 0;
    const auto policy = ImprovedPolicy(GumbelSettings(), root);
    for (std::size_t a = 0; a < kActionCount; ++a) {
      improved += policy[a] * static_cast<double>(root.values[a]);
    }
    ASSERT_GE(improved, worth / total - 1e-6);
    ASSERT_NEAR(std::accumulate(policy.begin(), policy.end(), 0.0), 1, 1e-9);
  }
}

// --- Sequential halving --------------------------------------------------------------------------

// Three phases of 250 / 3 simulations: 13 for each of six, 27 for each of three, 41 for each of
// two; the 9 that are left go to the two.
TEST(SequentialHalving, SharesSimulationsOutByPhases) {
  SequentialHalving halving;
  EXPECT_THAT(Share(Considering(6, 250), kRoot, {}, halving),
              ElementsAre(13 + 27 + 41 + 5, 13 + 27 + 41 + 4, 13 + 27, 13, 13, 13));
  EXPECT_EQ(halving.Best(kRoot), Action::kStop);
}

TEST(SequentialHalving, KeepsTheBetterHalf) {
  SequentialHalving halving;
  const Counts visits =
      Share(Considering(6, 60), kRoot, {-0.5F, 0.1F, -0.2F, 0.5F, -0.9F, 0.3F}, halving);
  EXPECT_THAT(visits, ElementsAre(3, 3 + 6, 3, 3 + 6 + 12, 3, 3 + 6 + 12));
}

TEST(SequentialHalving, ConsidersOnlyTheLikeliestActions) {
  SequentialHalving halving;
  EXPECT_THAT(Share(Considering(2, 10), kRoot, {}, halving), ElementsAre(5, 5, 0, 0, 0, 0));
  EXPECT_THAT(Share(Considering(1, 10), kRoot, {}, halving), ElementsAre(10, 0, 0, 0, 0, 0));
}

TEST(SequentialHalving, FewSimulationsGoToTheLikeliestActions) {
  SequentialHalving halving;
  EXPECT_THAT(Share(Considering(6, 2), kRoot, {}, halving), ElementsAre(1, 1, 0, 0, 0, 0));
}

TEST(SequentialHalving, LeavesLostActionsAlone) {
  SequentialHalving halving;
  RootStatistics root = kRoot;
  Rng rng(1);
  halving.Start(Considering(2, 100), root, rng);
  EXPECT_EQ(halving.Next(root), Action::kStop);
  root.legal = 0b111110;
  EXPECT_EQ(halving.Next(root), Action::kUp);
  EXPECT_EQ(halving.Next(root), Action::kUp);
  EXPECT_EQ(halving.Best(root), Action::kUp);
  root.legal = 0b111100;  // of the two considered, none is left
  EXPECT_EQ(halving.Next(root), Action::kDown);
  EXPECT_EQ(halving.Next(root), Action::kLeft);
}

// A clock may end the search before every considered action was tried.
TEST(SequentialHalving, PrefersWhatWasTried) {
  SequentialHalving halving;
  RootStatistics root = kRoot;
  Rng rng(1);
  halving.Start(Considering(6, 250), root, rng);
  root.visits = {0, 0, 0, 0, 1, 0};
  root.evaluation = 0.5F;
  EXPECT_EQ(halving.Best(root), Action::kRight);
}

TEST(SequentialHalving, TakesASimulationBack) {
  SequentialHalving halving;
  Rng rng(1);
  halving.Start(Considering(6, 250), kRoot, rng);
  EXPECT_EQ(halving.Next(kRoot), Action::kStop);
  EXPECT_EQ(halving.Next(kRoot), Action::kUp);
  halving.TakeBack();
  EXPECT_EQ(halving.Next(kRoot), Action::kUp);
}

// --- One halving after another -------------------------------------------------------------------

SearchSettings Repeating(int first_halving, int simulations) {
  SearchSettings settings = Considering(6, simulations);
  settings.gumbel_first_halving = first_halving;
  return settings;
}

constexpr std::array<float, kActionCount> kValues = {-0.5F, 0.1F, -0.2F, 0.5F, -0.9F, 0.3F};

// 60 simulations: 3 for each of six, 6 for each of three, 10 for each of two. 120: 6, 13 and 20.
TEST(SequentialHalving, RepeatsWithTwiceAsMany) {
  SequentialHalving halving;
  EXPECT_THAT(Share(Repeating(60, 56), kRoot, kValues, halving), ElementsAre(3, 9, 3, 19, 3, 19));
  EXPECT_THAT(Share(Repeating(60, 56 + 115), kRoot, kValues, halving),
              ElementsAre(9, 28, 9, 58, 9, 58));
}

TEST(SequentialHalving, FirstHalvingMayBeShort) {
  SequentialHalving halving;
  const Counts visits = Share(Repeating(1, 300), kRoot, kValues, halving);
  EXPECT_THAT(visits, testing::Each(testing::Gt(0U)));
  EXPECT_GT(visits[3], 80U);
}

TEST(SequentialHalving, ServesTheBestWheneverItIsCut) {
  for (int cut = 64; cut < 3000; cut += 7) {
    SequentialHalving halving;
    RootStatistics root = kRoot;
    root.visits = Share(Repeating(64, cut), kRoot, kValues, halving);
    root.values = kValues;
    ASSERT_EQ(halving.Best(root), Action::kLeft) << cut;
    ASSERT_GE(root.visits[3] * 4, static_cast<unsigned>(cut)) << cut;
  }
}

// Of six actions that win or lose, the fourth wins a little more often.
bool FindsTheLuckiest(const SearchSettings& settings, int cut, Rng rng) {
  RootStatistics root;
  root.priors.fill(1.0F / kActionCount);
  SequentialHalving halving;
  halving.Start(settings, root, rng);
  for (int i = 0; i < cut; ++i) {
    const auto a = static_cast<std::size_t>(halving.Next(root));
    const float value = rng.Uniform() < (a == 3 ? 0.6 : 0.5) ? 1.0F : -1.0F;
    root.values[a] += (value - root.values[a]) / static_cast<float>(++root.visits[a]);
  }
  return halving.Best(root) == Action::kLeft;
}

int LuckiestFound(const SearchSettings& settings, int cut) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    found += FindsTheLuckiest(settings, cut, Rng(seed)) ? 1 : 0;
  }
  return found;
}

// A clock leaves some hundred of 20,000 simulations: one halving of all would never choose.
TEST(SequentialHalving, CutShortRepeatingFindsMoreThanOneOfAll) {
  for (const int cut : {500, 900}) {
    const int known = LuckiestFound(Considering(6, cut), cut);
    const int repeating = LuckiestFound(Repeating(64, 20'000), cut);
    const int one_of_all = LuckiestFound(Considering(6, 20'000), cut);
    EXPECT_GT(repeating, one_of_all + 20) << cut;
    EXPECT_GT(repeating, known - 60) << cut;
  }
}

// The Gumbel-max trick: the highest of g + ln P is a draw from P.
TEST(SequentialHalving, DrawsWhatItConsidersFromThePriors) {
  constexpr int kDraws = 20'000;
  SearchSettings settings = Considering(1, 1);
  settings.gumbel_scale = 1;
  std::array<int, kActionCount> counts{};
  for (std::uint64_t seed = 0; seed < kDraws; ++seed) {
    SequentialHalving halving;
    Rng rng(seed);
    halving.Start(settings, kRoot, rng);
    ++counts[static_cast<std::size_t>(halving.Next(kRoot))];
  }
  for (std::size_t a = 0; a < kActionCount; ++a) {
    const auto prior = static_cast<double>(kRoot.priors[a]);
    EXPECT_NEAR(counts[a], kDraws * prior, 4 * std::sqrt(kDraws * prior)) << a;
  }
}

}  // namespace
}  // namespace powderkeg
