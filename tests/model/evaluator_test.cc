#include "common/model/evaluator.h"

#include <gtest/gtest.h>

namespace powderkeg {
namespace {

Action Best(const std::array<float, kActionCount>& policy, ActionSet legal) {
  return BestAction(policy, legal);
}

TEST(BestAction, PrefersTheLikeliestLegalActionAndTheLowestOfEquals) {
  EXPECT_EQ(Best({0.1F, 0.2F, 0.5F, 0.1F, 0.1F, 0.0F}, 0b111111), Action::kDown);
  EXPECT_EQ(Best({0.1F, 0.2F, 0.5F, 0.1F, 0.1F, 0.0F}, 0b111011), Action::kUp);
  EXPECT_EQ(Best({0.2F, 0.2F, 0.2F, 0.2F, 0.2F, 0.0F}, 0b011100), Action::kDown);
  EXPECT_EQ(Best({1.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F}, 0b100000), Action::kBomb);
}

}  // namespace
}  // namespace powderkeg
