#include "actors/play/factory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "actors/play/plain_agents.h"
#include "actors/play/search_agent.h"
#include "common/base/check.h"

namespace powderkeg {
namespace {

using ::testing::HasSubstr;

std::string ErrorOf(const std::string& text) {
  try {
    (void)ParseAgent(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(ParseAgent, ReadsRuleBasedPolicies) {
  EXPECT_EQ(ParseAgent("simple_unbiased").policy, PolicyKind::kSimpleUnbiased);
  EXPECT_EQ(ParseAgent("idle").policy, PolicyKind::kIdle);
  EXPECT_EQ(ParseAgent("idle").kind, AgentSpec::Kind::kRuleBased);
}

TEST(ParseAgent, ReadsSearches) {
  const AgentSpec description =
      ParseAgent("search:simulations=77,model=a/b.weights,opponents=idle");
  EXPECT_EQ(description.kind, AgentSpec::Kind::kSearch);
  EXPECT_EQ(description.search.simulations, 77);
  EXPECT_EQ(description.search.opponents[0], OpponentModel::kIdle);
  EXPECT_EQ(description.model_file, "a/b.weights");
  EXPECT_EQ(ParseAgent("search").search, SearchSettings());
  EXPECT_EQ(ParseAgent("search").model_file, "");
}

TEST(ParseAgent, ReadsRawNetworks) {
  EXPECT_EQ(ParseAgent("raw:model=x").kind, AgentSpec::Kind::kRawNetwork);
  EXPECT_EQ(ParseAgent("raw:model=x").model_file, "x");
}

TEST(ParseAgent, ListsTheKnownAgentsForAnUnknownOne) {
  EXPECT_THAT(ErrorOf("simple"), HasSubstr("unknown agent \"simple\""));
  EXPECT_THAT(ErrorOf("simple"), HasSubstr("simple_unbiased"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("unknown agent \"\""));
}

TEST(ParseAgent, SaysWhatIsWrongWithOptions) {
  EXPECT_THAT(ErrorOf("search:simulations"), HasSubstr("\"simulations\": expected OPTION=VALUE"));
  EXPECT_THAT(ErrorOf("search:=3"), HasSubstr("expected OPTION=VALUE"));
  EXPECT_THAT(ErrorOf("search:simulation=3"), HasSubstr("simulations"));
  EXPECT_THAT(ErrorOf("search:simulations=many"), HasSubstr("many"));
  EXPECT_THAT(ErrorOf("raw"), HasSubstr("expected raw:model=FILE"));
  EXPECT_THAT(ErrorOf("raw:model=x,simulations=3"), HasSubstr("unknown option \"simulations\""));
  EXPECT_THAT(ErrorOf("idle:simulations=3"), HasSubstr("idle"));
}

TEST(MakeAgent, MakesWhatIsDescribed) {
  EXPECT_NE(dynamic_cast<RuleBasedAgent*>(MakeAgent(ParseAgent("idle")).get()), nullptr);
  EXPECT_NE(dynamic_cast<RawNetworkAgent*>(MakeAgent(ParseAgent("raw:model=x")).get()), nullptr);
  EXPECT_NE(dynamic_cast<SearchAgent*>(MakeAgent(ParseAgent("search")).get()), nullptr);
}

TEST(MakeModel, AsksTheLoaderOnlyForFiles) {
  std::string loaded;
  const ModelLoader loader = [&loaded](const std::string& file) -> Model {
    loaded = file;
    return {std::make_shared<UniformEvaluator>(), /*weights_version=*/9};
  };
  EXPECT_EQ(MakeModel("", loader).weights_version, 0u);
  EXPECT_EQ(loaded, "");
  EXPECT_EQ(MakeModel("file", loader).weights_version, 9u);
  EXPECT_EQ(loaded, "file");
}

}  // namespace
}  // namespace powderkeg
