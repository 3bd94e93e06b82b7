#include "learner/report/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "tests/learner/view_support.h"

namespace powderkeg {
namespace {

using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;

TEST(Metrics, SayWhatTheRunIsAt) {
  const std::string text = MetricsText(PlayingRun());
  for (const char* line : {
           "powderkeg_run_info{run=\"quick\"} 1\n",
           "powderkeg_start_time_seconds 1800000000\n",
           "powderkeg_run_iterations_done 2\n",
           "powderkeg_run_decisions 20000\n",
           "powderkeg_run_decisions_wanted 100000\n",
           "powderkeg_run_samples_wanted 0\n",
           "powderkeg_run_actors_connected 2\n",
           "powderkeg_games_total 22\n",
           "powderkeg_decisions_total 4800\n",
           "powderkeg_rejected_total 2\n",
           "powderkeg_malformed_total 6\n",
           "powderkeg_sessions_lost_total 1\n",
           "powderkeg_pending_games 8\n",
           "powderkeg_actor_evaluations_total{actor=\"actor-1\"} 50000\n",
           "powderkeg_actor_silence_s{actor=\"actor-0\"} 0.25\n",
           "powderkeg_actor_oldest_game_s{actor=\"actor-0\"} 2.5\n",
           "powderkeg_iteration 2\n",
           "powderkeg_iteration_win_rate 0.78125\n",
           "powderkeg_iteration_value_loss 0.45\n",
           "powderkeg_iteration_share_bomb 0.1\n",
           "powderkeg_iteration_trained_s 123\n",
       }) {
    EXPECT_THAT(text, HasSubstr(line));
  }
}

// The lines of a family, in the order of text format 0.0.4: help, type, then all its samples.
TEST(Metrics, EveryFamilyIsExplainedOnceBeforeItsSamples) {
  const auto sample = MatchesRegex(R"re(powderkeg_[a-z0-9_]+(\{[a-z]+="([^"\]|\\["\n])*"\})? )re"
                                   R"re((NaN|[+-]Inf|-?[0-9.]+(e[+-][0-9]+)?))re");
  RunView view = PlayingRun();
  view.intake.actors.front().name = "a\\b\"c\nd";
  std::istringstream text(MetricsText(view));
  std::set<std::string> families;
  std::string family;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("# HELP ")) {
      family = line.substr(7, line.find(' ', 7) - 7);
      EXPECT_TRUE(families.insert(family).second) << family << " comes twice";
      EXPECT_TRUE(std::getline(text, line) && line.starts_with("# TYPE " + family + " ")) << line;
      const std::string type = line.substr(line.rfind(' ') + 1);
      EXPECT_EQ(type, family.ends_with("_total") ? "counter" : "gauge") << family;
      continue;
    }
    EXPECT_THAT(line, sample);
    EXPECT_EQ(line.substr(0, line.find_first_of("{ ")), family);
  }
  EXPECT_GT(families.size(), 40U);
}

TEST(Metrics, LabelsAreEscaped) {
  RunView view = PlayingRun();
  view.run = "a\\b\"c\nd";
  EXPECT_THAT(MetricsText(view), HasSubstr(R"(powderkeg_run_info{run="a\\b\"c\nd"} 1)"));
}

TEST(Metrics, LeaveOutWhatThereIsNot) {
  EXPECT_THAT(MetricsText(PlayingRun()), Not(HasSubstr("powderkeg_iteration_exam")));
  RunView view = PlayingRun();
  view.intake.actors.clear();
  view.last_iteration.reset();
  const std::string text = MetricsText(view);
  EXPECT_THAT(text, Not(HasSubstr("powderkeg_actor_")));
  EXPECT_THAT(text, Not(HasSubstr("powderkeg_iteration_")));
}

TEST(Metrics, LargeCountersKeepTheirDigits) {
  RunView view = PlayingRun();
  view.intake.decisions = 123'456'789'012'345;
  EXPECT_THAT(MetricsText(view), HasSubstr("powderkeg_decisions_total 123456789012345\n"));
}

}  // namespace
}  // namespace powderkeg
