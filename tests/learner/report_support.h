#pragma once

// Reports with every field set.

#include "learner/train/iteration_report.h"

namespace powderkeg {

inline IterationReport ReportOf(int iteration) {
  IterationReport report;
  report.iteration = iteration;
  report.games = 512;
  report.decisions = 100'123;
  report.score = {.wins = 400, .ties = 50, .losses = 62};
  report.mean_steps = 195.55;
  report.action_shares = {0.31, 0.14, 0.15, 0.16, 0.14, 0.10};
  report.weights_lag = 0.25;
  report.total_loss = 0.9;
  report.policy_loss = 0.95;
  report.value_loss = 0.45;
  report.policy_accuracy = 0.625;
  report.samples_per_s = 2345;
  report.waited_s = 61;
  report.trained_s = 123;
  return report;
}

}  // namespace powderkeg
