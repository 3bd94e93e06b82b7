#include "common/model/network_description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using testing::HasSubstr;

TEST(NetworkDescription, PaperNetworkHasTheParametersOfThePaper) {
  EXPECT_EQ(ParameterCount(PaperNetwork()), 344'425);
  EXPECT_EQ(TowerBoardSize(PaperNetwork()), 6);
}

TEST(NetworkDescription, NamedNetworksAreValid) {
  for (const char* name : {"paper", "small"}) EXPECT_NO_THROW(Validate(NetworkByName(name)));
  EXPECT_EQ(NetworkByName("paper"), PaperNetwork());
  EXPECT_EQ(NetworkByName("small"), SmallNetwork());
  EXPECT_THROW((void)NetworkByName("large"), Error);
}

TEST(NetworkDescription, TextsSayWhatTheNamedNetworksAre) {
  EXPECT_EQ(NetworkByName("stem16+residual16x2+value4-64+policy4+own64+others64"), SmallNetwork());
  EXPECT_EQ(NetworkByName("stem16+residual16+residual16"), SmallNetwork())
      << "the rest as in small";
  EXPECT_EQ(NetworkByName("stem64+inverted256-64x2+inverted512-128-2+inverted512-128+value1-256"
                          "+policy16"),
            PaperNetwork())
      << "no heads of cells on a smaller board";
  EXPECT_EQ(NetworkByName("stem32+residual32+own0").own_hidden, 0);
  EXPECT_EQ(NetworkByName("stem32-2").stem_stride, 2);
}

TEST(NetworkDescription, TextsThatSayNoNetworkAreErrorsWithThePart) {
  const auto error = [](const char* text) -> std::string {
    try {
      (void)NetworkByName(text);
    } catch (const Error& refused) {
      return refused.what();
    }
    return "none";
  };
  EXPECT_THAT(error("stem32+residul32"), HasSubstr("\"residul32\""));
  EXPECT_THAT(error("stem32+residual"), HasSubstr("residualCHANNELS"));
  EXPECT_THAT(error("stem32+inverted32"), HasSubstr("invertedEXPANDED-CHANNELS"));
  EXPECT_THAT(error("stem32x2"), HasSubstr("stemCHANNELS"));
  EXPECT_THAT(error("stem32+residual32x0"), HasSubstr("times"));
  EXPECT_THAT(error("stem32+residual32x"), HasSubstr("whole numbers"));
  EXPECT_THAT(error("stem32+residual3a2"), HasSubstr("whole numbers"));
  EXPECT_THAT(error("stem32++policy4"), HasSubstr("\"\""));
  EXPECT_THAT(error("stem99999999999"), HasSubstr("whole numbers"));
  EXPECT_THAT(error("stem0"), HasSubstr("stem_channels is 0"));
  EXPECT_THAT(error("stem32-2+own64"), HasSubstr("own_hidden with a stride"));
}

TEST(NetworkDescription, ArrayNamesAreUnique) {
  std::set<std::string> names;
  const auto arrays = ArraysOf(PaperNetwork());
  for (const ArrayShape& array : arrays) names.insert(array.name);
  EXPECT_EQ(names.size(), arrays.size());
  EXPECT_TRUE(names.contains("blocks.2.bn3.running_var"));
}

TEST(NetworkDescription, SkipNeedsEqualShapes) {
  EXPECT_TRUE(HasSkip({.expanded = 8, .channels = 4, .stride = 1}, 4));
  EXPECT_FALSE(HasSkip({.expanded = 8, .channels = 4, .stride = 2}, 4));
  EXPECT_FALSE(HasSkip({.expanded = 8, .channels = 4, .stride = 1}, 5));
}

TEST(NetworkDescription, RefusesWhatCannotBeBuilt) {
  const auto changed = [](const std::function<void(NetworkDescription&)>& change) {
    NetworkDescription network = PaperNetwork();
    change(network);
    return network;
  };
  const std::vector<std::function<void(NetworkDescription&)>> changes = {
      [](auto& n) { n.planes = 22; },
      [](auto& n) { n.stem_channels = 0; },
      [](auto& n) { n.stem_channels = 1'000'000; },
      [](auto& n) { n.stem_stride = 3; },
      [](auto& n) { n.blocks[1].channels = -64; },
      [](auto& n) { n.blocks[1].expanded = 0; },
      [](auto& n) { n.blocks[1].stride = 0; },
      [](auto& n) { n.blocks[1].kind = static_cast<BlockDescription::Kind>(9); },
      [](auto& n) {
        n.blocks[1] = {BlockDescription::Kind::kResidual, 32, 64, 1};
      },
      [](auto& n) { n.blocks.resize(65, n.blocks[0]); },
      [](auto& n) { n.value_channels = 0; },
      [](auto& n) { n.value_hidden = -1; },
      [](auto& n) { n.policy_channels = 0; },
      [](auto& n) { n.own_hidden = -1; },
      [](auto& n) { n.own_hidden = 8; },  // the paper's network has a stride
      [](auto& n) { n.leaky_slope = -0.1F; },
      [](auto& n) { n.leaky_slope = std::numeric_limits<float>::quiet_NaN(); },
      [](auto& n) {
        n.blocks.assign(64, {BlockDescription::Kind::kResidual, 2048, 2048, 1});
      },
  };
  for (std::size_t i = 0; i < changes.size(); ++i) {
    EXPECT_THROW(Validate(changed(changes[i])), Error) << i;
  }
}

}  // namespace
}  // namespace powderkeg
