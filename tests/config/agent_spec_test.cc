#include "common/config/agent_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using ::testing::AllOf;
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
  const AgentSpec agent = ParseAgent("search:simulations=77,model=a/b.weights,opponents=idle");
  EXPECT_EQ(agent.kind, AgentSpec::Kind::kSearch);
  EXPECT_EQ(agent.search.simulations, 77);
  EXPECT_EQ(agent.search.opponents[0], OpponentModel::kIdle);
  EXPECT_EQ(agent.model_file, "a/b.weights");
  EXPECT_EQ(ParseAgent("search").search, SearchSettings());
  EXPECT_EQ(ParseAgent("search").model_file, "");
}

TEST(ParseAgent, ReadsPessimists) {
  EXPECT_EQ(ParseAgent("pessimist").kind, AgentSpec::Kind::kPessimist);
  EXPECT_EQ(ParseAgent("pessimist").pessimist, PessimistSettings());
  EXPECT_FALSE(ParseAgent("pessimist").HasNetwork());
  EXPECT_EQ(ParseAgent("pessimist:depth=3,fear=1").pessimist.depth, 3);
  EXPECT_THAT(ErrorOf("pessimist:depth=9"),
              HasSubstr("pessimist:depth is 9; expected a whole number from 1 to 4"));
  EXPECT_THAT(ErrorOf("pessimist:model=x"), HasSubstr("no setting pessimist:model"));
}

TEST(ParseAgent, ReadsRawNetworks) {
  EXPECT_EQ(ParseAgent("raw:model=x").kind, AgentSpec::Kind::kRawNetwork);
  EXPECT_EQ(ParseAgent("raw:model=x").model_file, "x");
}

TEST(ParseAgent, ReadsServers) {
  const AgentSpec agent = ParseAgent("http:[::1]:10080,move_ms=100,start_s=2");
  EXPECT_EQ(agent.kind, AgentSpec::Kind::kForeign);
  EXPECT_EQ(agent.foreign, (ForeignSettings{{.host = "::1", .port = 10080}, 100, 2}));
  EXPECT_EQ(ParseAgent("http:node7:1").foreign, (ForeignSettings{.server = {"node7", 1}}));
  EXPECT_FALSE(agent.HasNetwork());
  for (const char* text : {"http", "http:", "http:1", "http:host:0", "http:host:x", "http::1"}) {
    EXPECT_THAT(ErrorOf(text), HasSubstr("expected http:HOST:PORT with a port from 1")) << text;
  }
  EXPECT_THAT(ErrorOf("http:host:1,model=x"), HasSubstr("no setting http:model"));
  EXPECT_THAT(ErrorOf("http:host:1,move_ms=0"), HasSubstr("http:move_ms is 0; expected"));
}

TEST(CheckServers, RefusesTwoSeatsOfOne) {
  const auto check = [](const char* text) {
    const std::vector<AgentSpec> seats = {ParseAgent("http:host:1"), ParseAgent("idle"),
                                          ParseAgent("idle"), ParseAgent(text)};
    CheckServers(seats);
  };
  EXPECT_NO_THROW(check("http:host:2"));
  EXPECT_THROW(check("http:host:1,move_ms=9"), Error);
}

TEST(ParseAgent, ListsTheKnownAgentsForAnUnknownOne) {
  EXPECT_THAT(ErrorOf("simple"),
              AllOf(HasSubstr("unknown agent simple: known: idle, random, harmless, "),
                    HasSubstr("; did you mean simple_unbiased?")));
  EXPECT_THAT(ErrorOf("serch:simulations=3"), HasSubstr("; did you mean search?"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("unknown agent \"\""));
}

TEST(ParseAgent, SaysWhatIsWrongWithOptions) {
  EXPECT_THAT(ErrorOf("search:simulations"), HasSubstr("simulations: expected OPTION=VALUE"));
  EXPECT_THAT(ErrorOf("search:=3"), HasSubstr("expected OPTION=VALUE"));
  EXPECT_THAT(ErrorOf("search:simulation=3"),
              HasSubstr("no setting search:simulation; did you mean search:simulations?"));
  EXPECT_THAT(ErrorOf("search:simulations=many"),
              HasSubstr("search:simulations is many; expected a whole number from 1 to"));
  EXPECT_THAT(ErrorOf("search:simulations=3,simulations=4"), HasSubstr("twice"));
  EXPECT_THAT(ErrorOf("raw"), HasSubstr("expected raw:model=MODEL"));
  EXPECT_THAT(ErrorOf("raw:model=x,simulations=3"), HasSubstr("unknown option simulations"));
  EXPECT_THAT(ErrorOf("idle:simulations=3"), HasSubstr("idle"));
}

TEST(ParsePlayersAgent, ChangesTheRunsSearch) {
  SearchSettings base;
  base.memory = ModelMemory::kReset;
  const AgentSpec agent = ParsePlayersAgent("search:simulations=16", base);
  EXPECT_EQ(agent.search.simulations, 16);
  EXPECT_EQ(agent.search.memory, ModelMemory::kReset);
  EXPECT_EQ(ParsePlayersAgent("raw", base).kind, AgentSpec::Kind::kRawNetwork);
  EXPECT_EQ(ParsePlayersAgent("search:preset=paper", base).search, PaperSettings());
  EXPECT_THROW((void)ParsePlayersAgent("search:model=x", base), Error);
}

TEST(AgentOptionsHelp, ShowsEveryOption) {
  for (const auto& option : SearchOptions()) {
    EXPECT_THAT(AgentOptionsHelp(), AllOf(HasSubstr("  " + std::string(option.name)),
                                          HasSubstr(std::string(option.help))));
  }
  for (const auto& option : PessimistOptions()) {
    EXPECT_THAT(AgentOptionsHelp(), HasSubstr("  " + std::string(option.name) + " = "));
  }
}

}  // namespace
}  // namespace powderkeg
