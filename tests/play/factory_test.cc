#include "actors/play/factory.h"

#include <gtest/gtest.h>

#include "actors/play/plain_agents.h"
#include "actors/play/search_agent.h"

namespace powderkeg {
namespace {

TEST(MakeAgent, MakesWhatIsDescribed) {
  EXPECT_NE(dynamic_cast<RuleBasedAgent*>(MakeAgent(ParseAgent("idle")).get()), nullptr);
  EXPECT_NE(dynamic_cast<PessimistAgent*>(MakeAgent(ParseAgent("pessimist")).get()), nullptr);
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
