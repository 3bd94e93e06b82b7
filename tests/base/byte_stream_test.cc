#include "common/base/byte_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace powderkeg {
namespace {

using testing::ElementsAre;

std::string FaultOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ByteStreamTest, WritesLittleEndianWithoutPadding) {
  ByteWriter out;
  out.Write(std::uint8_t{1});
  out.Write(std::uint32_t{0x0A0B0C0D});
  out.Write(std::int16_t{-2});
  EXPECT_THAT(out.Take(), ElementsAre(1, 0x0D, 0x0C, 0x0B, 0x0A, 0xFE, 0xFF));
  EXPECT_TRUE(out.Take().empty());
}

TEST(ByteStreamTest, ReadsBackWhatWasWritten) {
  ByteWriter out;
  out.Write(-1.5F);
  out.Write(std::numeric_limits<std::uint64_t>::max());
  out.Write(std::uint16_t{3});
  out.WriteAll(std::span<const char>("abc", 3));
  out.WriteAll(std::span<const float>());
  out.WriteAll(std::span<const std::int64_t>(std::vector<std::int64_t>{7, -8}));
  const std::vector<std::uint8_t> bytes = out.Take();
  ByteReader in("test", bytes);
  EXPECT_EQ(in.Read<float>(), -1.5F);
  EXPECT_EQ(in.Read<std::uint64_t>(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(in.ReadString(in.ReadCount<std::uint16_t>(1)), "abc");
  EXPECT_TRUE(in.ReadVector<float>(0).empty());
  EXPECT_THAT(FaultOf([&] { in.ExpectEnd(); }), "test: 16 bytes after the end");
  EXPECT_THAT(in.ReadVector<std::int64_t>(2), ElementsAre(7, -8));
  EXPECT_NO_THROW(in.ExpectEnd());
}

TEST(ByteStreamTest, TruncatedBytesSayWhatIsMissing) {
  const std::vector<std::uint8_t> bytes = {5, 0, 0};
  EXPECT_EQ(FaultOf([&] { (void)ByteReader("test", bytes).Read<std::uint32_t>(); }),
            "test: truncated, 3 bytes left where 4 are needed");
  EXPECT_EQ(FaultOf([&] { (void)ByteReader("test", bytes).ReadCount<std::uint8_t>(1); }),
            "test: truncated, 2 bytes left where 5 are needed");
  EXPECT_EQ(FaultOf([&] { (void)ByteReader("test", bytes).ReadVector<float>(1); }),
            "test: truncated, 3 bytes left where 1 times 4 are needed");
}

// Nothing is allocated for a count that cannot be, and no product overflows.
TEST(ByteStreamTest, HugeCountsAreRefusedBeforeMemoryIsTaken) {
  const std::vector<std::uint8_t> bytes(8, 0xFF);
  const std::size_t huge = std::numeric_limits<std::size_t>::max();
  EXPECT_THROW((void)ByteReader("x", bytes).ReadVector<std::uint64_t>(huge), Error);
  EXPECT_THROW((void)ByteReader("x", bytes).ReadVector<std::uint64_t>(huge / 8 + 2), Error);
  EXPECT_THROW((void)ByteReader("x", bytes).ReadCount<std::uint64_t>(16), Error);
  EXPECT_THROW((void)ByteReader("x", bytes).ReadString(huge), Error);
}

}  // namespace
}  // namespace powderkeg
