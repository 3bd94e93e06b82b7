#include "common/config/tree_memory.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>

#include "common/base/check.h"
#include "common/config/config.h"

namespace powderkeg {
namespace {

std::size_t NodesOfLoop(std::string_view self_play) {
  const std::string text =
      StrCat("self_play { search { simulations: 99 } games_in_flight: 2 ", self_play, " }");
  return TreeBytesOfLoop(ParseConfig(text, "test", {}).self_play) / kTreeNodeBytes;
}

TEST(TreeMemoryTest, AnAgentHasANodeForEachSimulationAndTheRoot) {
  EXPECT_EQ(TreeBytes(ParseAgent("search:simulations=1000000")), 1'000'001 * kTreeNodeBytes);
  EXPECT_EQ(TreeBytes(ParseAgent("search:simulations=10,tree=two_player")), 21 * kTreeNodeBytes);
  EXPECT_EQ(TreeBytes(ParseAgent("search:simulations=10,full_search_share=0.5,"
                                 "fast_simulations=30")),
            31 * kTreeNodeBytes);
  EXPECT_EQ(TreeBytes(ParseAgent("simple_unbiased")), 0U);
}

TEST(TreeMemoryTest, ALoopHasATreeForEachGameSeatAndPlayerAndOthersInExams) {
  constexpr std::size_t kOfAPlayer = 2 * 4 * 100;  // games, seats, nodes
  EXPECT_EQ(NodesOfLoop("lineup { seats: 'me me simple_unbiased idle' }"), kOfAPlayer);
  EXPECT_EQ(NodesOfLoop(
                "lineup { seats: 'me me me me' } lineup { seats: 'me idle idle idle' exam: true }"),
            2 * kOfAPlayer);
  EXPECT_EQ(
      NodesOfLoop("player { name: 'me' teaches: search } player { name: 'past' weights: past }"
                  "lineup { seats: 'me past past past' }"),
      2 * kOfAPlayer);
}

TEST(TreeMemoryTest, MuchIsSaidAndWhatTheMachineLacksRefused) {
  testing::internal::CaptureStderr();
  RequireMemoryForTrees("a small search", 499'999'999);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  testing::internal::CaptureStderr();
  WarnOfTrees("a large search", 1'234'567'890);
  EXPECT_TRUE(testing::internal::GetCapturedStderr().ends_with(
      " W search trees take much memory of=\"a large search\" at_least=\"1.2 GB\"\n"));
  try {
    RequireMemoryForTrees("a search", std::numeric_limits<std::size_t>::max());
    FAIL();
  } catch (const Error& error) {
    EXPECT_TRUE(std::string(error.what())
                    .starts_with("the search trees of a search take at least 18446744073.7 GB; "
                                 "expected fewer simulations "
                                 "or games side by side, for the "))
        << error.what();
  }
}

}  // namespace
}  // namespace powderkeg
