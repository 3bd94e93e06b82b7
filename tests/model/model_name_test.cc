#include "common/model/model_name.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "common/base/check.h"
#include "common/base/durable_file.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

// A home with models and runs, and a working directory elsewhere.
class ModelName : public testing::Test {
 protected:
  ModelName()
      : home_(fs::path(testing::TempDir()) / StrCat("model_name_test_", getpid())),
        before_(fs::current_path()) {
    fs::create_directories(home_ / "elsewhere");
    fs::current_path(home_ / "elsewhere");
    setenv("POWDERKEG_HOME", home_.c_str(), /*overwrite=*/1);
  }
  ~ModelName() override {
    unsetenv("POWDERKEG_HOME");
    fs::current_path(before_);
    fs::remove_all(home_);
  }

  // An empty file, written so many hours ago.
  void Write(const fs::path& file, int hours_ago = 0) const {
    const fs::path path = home_ / file;
    fs::create_directories(path.parent_path());
    std::ofstream(path).flush();
    fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(hours_ago));
  }
  [[nodiscard]] std::string In(const fs::path& file) const { return home_ / file; }

  static std::string ErrorOf(const std::string& name) {
    try {
      (void)LoadModel(name);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path home_;
  fs::path before_;
};

TEST_F(ModelName, IsAFileInModels) {
  Write("models/ffa.weights");
  EXPECT_EQ(ResolvedModel("ffa"), In("models/ffa.weights"));
}

TEST_F(ModelName, OfAFileHoldsASlashOrADot) {
  Write("models/ffa.weights");
  Write("elsewhere/ffa");
  Write("elsewhere/my.weights");
  Write("elsewhere/latest:my.run");
  EXPECT_EQ(ResolvedModel("ffa"), In("models/ffa.weights"));
  EXPECT_EQ(ResolvedModel("./ffa"), "./ffa");
  EXPECT_EQ(ResolvedModel("my.weights"), "my.weights");
  EXPECT_EQ(ResolvedModel("latest:my.run"), "latest:my.run");
  EXPECT_THAT(ErrorOf("no/such.weights"), HasSubstr("cannot open no/such.weights"));
}

TEST_F(ModelName, LatestIsTheNewestOfTheRunThatWroteLast) {
  Write("runs/old/weights/version-000009.weights", 2);
  Write("runs/new.1/weights/version-000001.weights", 3);
  Write("runs/new.1/weights/version-000002.weights", 1);
  Write("runs/new.1/weights/version-000003.weights.tmp");
  Write("runs/empty/log/learner.log");
  EXPECT_EQ(ResolvedModel("latest"), In("runs/new.1/weights/version-000002.weights"));
  EXPECT_EQ(ResolvedModel("latest:old"), In("runs/old/weights/version-000009.weights"));
  EXPECT_EQ(ResolvedModel("latest:new.1"), In("runs/new.1/weights/version-000002.weights"));
  EXPECT_THAT(ErrorOf("latest:empty"),
              AllOf(HasSubstr("model latest:empty: no such weights"), EndsWith(": old, new.1")));
}

TEST_F(ModelName, SaysWhatThereIs) {
  EXPECT_THAT(ErrorOf("latest"), HasSubstr("runs with weights: none"));
  EXPECT_THAT(ErrorOf("ffa"), HasSubstr("/models: none, and always latest, "));
  Write("models/ffa.weights");
  Write("models/team.weights");
  Write("models/ffa.md");
  EXPECT_THAT(ErrorOf("fa"), AllOf(HasSubstr("there is no model \"fa\""),
                                   HasSubstr("/models: ffa, team, and always latest"),
                                   EndsWith("; did you mean ffa?"), Not(HasSubstr("\n"))));
}

TEST_F(ModelName, UntrainedIsMadeOfANetworkAndASeed) {
  EXPECT_EQ(*LoadModel("untrained:small"), InitialWeights(SmallNetwork(), Rng(1)));
  EXPECT_EQ(*LoadModel("untrained:small:7"), InitialWeights(SmallNetwork(), Rng(7)));
  EXPECT_THAT(ErrorOf("untrained:huge"), HasSubstr("unknown network 'huge'"));
  EXPECT_THAT(ErrorOf("untrained:small:x"), HasSubstr("the seed is \"x\""));
  EXPECT_THAT(ErrorOf("untrained:small:"), HasSubstr("the seed is \"\""));
  EXPECT_THAT(ErrorOf("untrained:small:-1"), HasSubstr("the seed is \"-1\""));
}

// Without POWDERKEG_HOME the folder is found from the program, wherever that was started.
TEST_F(ModelName, IsFoundFromTheProgram) {
  unsetenv("POWDERKEG_HOME");
  EXPECT_TRUE(fs::exists(ResolvedModel("ffa")));
}

TEST(ShippedModels, AreSmallAndWholeAndHaveCards) {
  int models = 0;
  for (const fs::path& file : FilesIn("models")) {
    EXPECT_LT(fs::file_size(file), 2'000'000U) << file;
    if (file.extension() != ".weights") continue;
    ++models;
    EXPECT_FALSE(LoadModel(file)->canary.states.empty()) << file;
    EXPECT_TRUE(fs::exists(fs::path(file).replace_extension(".md"))) << file;
  }
  EXPECT_GT(models, 0);
}

}  // namespace
}  // namespace powderkeg
