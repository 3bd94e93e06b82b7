#include "common/base/number.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace powderkeg {
namespace {

TEST(ParseNumber, TakesTheWholeTextOnly) {
  EXPECT_EQ(ParseNumber<int>("-17"), -17);
  EXPECT_EQ(ParseNumber<double>("2.5e3"), 2500);
  for (const char* text : {"", " 1", "1 ", "+1", "1x", "x", "0x10", "1,5"}) {
    EXPECT_EQ(ParseNumber<int>(text), std::nullopt) << text;
    EXPECT_EQ(ParseNumber<double>(text), std::nullopt) << text;
  }
  EXPECT_EQ(ParseNumber<int>("1.5"), std::nullopt);
}

TEST(ParseNumber, KeepsToTheRangeOfItsType) {
  EXPECT_EQ(ParseNumber<std::uint16_t>("65535"), 65535);
  EXPECT_EQ(ParseNumber<std::uint16_t>("65536"), std::nullopt);
  EXPECT_EQ(ParseNumber<std::uint16_t>("-1"), std::nullopt);
  EXPECT_EQ(ParseNumber<double>("1e400"), std::nullopt);
}

}  // namespace
}  // namespace powderkeg
