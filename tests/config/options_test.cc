// What must hold for every option of every table.

#include "common/config/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/config/config.h"

namespace powderkeg {
namespace {

using testing::HasSubstr;

// A text that the option accepts and that is not its default; "" if none of these is.
template <typename Settings>
std::string OtherValueOf(const Option<Settings>& option) {
  const std::string initial = option.write(Settings{}, option.allowed);
  for (const char* text : {"2",       "0.5",         "-0.5",           "0.25",    "true",
                           "false",   "two_player",  "most_dangerous", "idle",    "reset",
                           "gumbel",  "uniform",     "official",       "at_once", "fp32",
                           "paper",   "cpu",         "newest",         "moves",   "OneVsOne-v0",
                           "pytorch", "as_foretold", "cosine"}) {
    Settings settings;
    if (text != initial && option.read(text, option.allowed, settings)) return text;
  }
  return "";
}

bool TakesAnyText(const std::string& expected) {
  return expected == "a text" || expected.starts_with("words");
}

template <typename Settings>
void ExpectWhole(OptionTable<Settings> table, const std::string& path, const std::string& help) {
  for (const Option<Settings>& option : table) {
    SCOPED_TRACE(path + std::string(option.name));
    EXPECT_FALSE(option.help.empty());
    EXPECT_THAT(help, HasSubstr("  " + path + std::string(option.name)));
    EXPECT_THAT(help, HasSubstr(std::string(option.help)));
    EXPECT_EQ(std::ranges::count(table, option.name, &Option<Settings>::name), 1);

    const std::string other = OtherValueOf(option);
    ASSERT_NE(other, "");
    Settings settings;
    ASSERT_TRUE(option.read(other, option.allowed, settings));
    EXPECT_NE(settings, Settings{});
    const std::string written = option.write(settings, option.allowed);
    if (option.name != "preset") {
      EXPECT_EQ(written, other);
      EXPECT_THAT(WriteOptions(table, settings, ""),
                  HasSubstr(StrCat(option.name, ": ", other, "\n")));
    }
    if (TakesAnyText(option.expected(option.allowed))) continue;
    const Settings before = settings;
    for (const char* bad : {"!", "", "nan", "1e308", "-1e308", "99999999999999999999"}) {
      EXPECT_FALSE(option.read(bad, option.allowed, settings)) << bad;
    }
    EXPECT_EQ(settings, before) << "what is refused changes nothing";
  }
}

TEST(OptionTables, EveryOptionIsReadWrittenRefusedAndShown) {
  const std::string help = SettingsHelp();
  ExpectWhole(SearchOptions(), "self_play.search.", help);
  ExpectWhole(SelfPlayOptions(), "self_play.", help);
  ExpectWhole(TrainingOptions(), "training.", help);
  ExpectWhole(PlayerOptions(), "player.", help);
  ExpectWhole(LineupOptions(), "lineup.", help);
}

TEST(OptionTables, EveryOptionOfGamesIsPartOfTheDigest) {
  std::set<Sha256Digest> digests = {SettingsDigest({})};
  std::size_t expected = 1;
  for (const auto& option : SearchOptions()) {
    SelfPlayConfig config;
    ASSERT_TRUE(option.read(OtherValueOf(option), option.allowed, config.search));
    if (option.name != "preset")
      expected += digests.insert(SettingsDigest(config)).second ? 1 : 100;
  }
  for (const auto& option : SelfPlayOptions()) {
    SelfPlayConfig config;
    ASSERT_TRUE(option.read(OtherValueOf(option), option.allowed, config));
    expected += digests.insert(SettingsDigest(config)).second ? 1 : 100;
  }
  EXPECT_EQ(digests.size(), expected);
}

TEST(OptionTables, EveryOptionCanBeSet) {
  const auto set = [](const std::string& name, const std::string& value) {
    (void)ParseConfig("", "x", std::vector{name + "=" + value});
  };
  for (const auto& option : SearchOptions()) {
    EXPECT_NO_THROW(set(StrCat("self_play.search.", option.name), OtherValueOf(option)));
  }
  for (const auto& option : TrainingOptions()) {
    EXPECT_NO_THROW(set(StrCat("training.", option.name), OtherValueOf(option)));
  }
}

TEST(Values, DoublesComeBackExactly) {
  for (const double value : {0.1, 1.0 / 3, 1e-4, 19652.0, -0.5, 5e-324, 1e9}) {
    double read = 7;
    EXPECT_TRUE(ReadValue(WriteValue(value, kAnything), kAnything, read));
    EXPECT_EQ(read, value);
  }
  EXPECT_EQ(WriteValue(1e-4, kAnything), "0.0001");
}

TEST(Values, BoundsMayBeExcluded) {
  double value = 1;
  EXPECT_FALSE(ReadValue("0", Above(0, 1), value));
  EXPECT_TRUE(ReadValue("0", Between(0, 1), value));
  EXPECT_EQ(Expected(Above(0, 1), &value), "a number above 0 to 1");
}

}  // namespace
}  // namespace powderkeg
