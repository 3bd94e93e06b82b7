#include "common/base/name.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/base/check.h"

namespace powderkeg {
namespace {

TEST(Name, IsAFileOfTheFolderItIsIn) {
  const std::vector<std::string> names = {"a", "node-7.example.org", "My_run.2", "-",
                                          std::string(64, 'x')};
  for (const std::string& name : names) EXPECT_TRUE(IsName(name)) << name;
  const std::vector<std::string> others = {"",
                                           ".",
                                           "..",
                                           ".hidden",
                                           "a/b",
                                           "../../x",
                                           "two words",
                                           "a\n",
                                           "caf\xc3\xa9",
                                           std::string(65, 'x'),
                                           std::string("a\0b", 3)};
  for (const std::string& text : others) EXPECT_FALSE(IsName(text)) << text;
}

TEST(Name, IsRefusedWithItsValueAndWhatWasExpected) {
  EXPECT_NO_THROW(RequireName("--name", "node7"));
  EXPECT_THAT(
      [] { RequireName("--name", ".."); },
      testing::ThrowsMessage<Error>(
          "--name is '..', expected 1 to 64 letters, digits, '.', '_' and '-', not '.' first"));
}

}  // namespace
}  // namespace powderkeg
