#include "common/config/settings_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using testing::HasSubstr;

// "name=value,section{...}" of the fields.
std::string Shown(const std::vector<TextField>& fields) {
  std::string text;
  for (const TextField& field : fields) {
    if (!text.empty()) text += ',';
    text += field.name + (field.is_section ? "{" + Shown(field.fields) + "}" : "=" + field.value);
  }
  return text;
}
std::string Read(std::string_view text) { return Shown(ParseFields(text, "file")); }

std::string FaultOf(std::string_view text) {
  try {
    return Read(text) + " was read";
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(SettingsText, ReadsValuesAndSections) {
  EXPECT_EQ(Read(""), "");
  EXPECT_EQ(Read("a: 1 b { c: -2.5e-3 d: true } e: { f: word }"),
            "a=1,b{c=-2.5e-3,d=true},e{f=word}");
  EXPECT_EQ(Read("a:1;b:2,c:3\n# d: 4\ne:5 # f: 6"), "a=1,b=2,c=3,e=5");
  EXPECT_EQ(Read("a: \"two words # no comment\" b: 'it\\'s'"), "a=two words # no comment,b=it's");
  EXPECT_EQ(Read("a: \"\\\"\\\\\\n\\t\\303\\251\""), "a=\"\\\n\t\xC3\xA9");
}

TEST(SettingsText, UnderstandsTheLinesOfEverySystem) {
  EXPECT_EQ(Read("\xEF\xBB\xBF"
                 "a: 1\r\nb: 2\r\n"),
            "a=1,b=2");
  EXPECT_EQ(Read("a: 1\r# comment\rb: 2\r"), "a=1,b=2");
  EXPECT_THAT(FaultOf("a: 1\r\nb: 2\r\n  !"), HasSubstr("file:3:3: "));
  EXPECT_THAT(FaultOf("a: 1\rb: 2\r  !"), HasSubstr("file:3:3: "));
  EXPECT_THAT(FaultOf("a: 1\nb: 2\n\n!"), HasSubstr("file:4:1: "));
}

TEST(SettingsText, FaultsNamePlaceAndExpectation) {
  EXPECT_EQ(FaultOf("a 1"), "file:1:3: found 1; expected ':' or '{'");
  EXPECT_EQ(FaultOf("a:"), "file:1:3: found the end; expected a value");
  EXPECT_EQ(FaultOf("a {"), "file:1:4: found the end; expected '}'");
  EXPECT_EQ(FaultOf("}"), "file:1:1: found \"}\"; expected the name of a setting");
  EXPECT_THAT(FaultOf("a: \"open\nb: 1"), HasSubstr("file:1:9: "));
  EXPECT_THAT(FaultOf("a: \"\\q\""), HasSubstr("expected one of \\n"));
  EXPECT_THAT(FaultOf("a: \"\\"), HasSubstr("an escape"));
  EXPECT_THAT(FaultOf(std::string("a: \0", 4)), HasSubstr("found \"\\000\""));
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "a{";
  EXPECT_THAT(FaultOf(deep), HasSubstr("fewer sections"));
}

TEST(SettingsText, QuotedComesBackAsItWas) {
  EXPECT_EQ(Quoted("PommeFFA-v1"), "PommeFFA-v1");
  EXPECT_EQ(Quoted(""), "\"\"");
  EXPECT_EQ(Quoted("a b"), "\"a b\"");
  std::string every;
  for (int c = 0; c < 256; ++c) every += static_cast<char>(c);
  EXPECT_EQ(ParseFields("a: " + Quoted(every), "x").at(0).value, every);
}

}  // namespace
}  // namespace powderkeg
