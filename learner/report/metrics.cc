#include "learner/report/metrics.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <sstream>
#include <string_view>

#include "common/base/stats.h"

namespace powderkeg {
namespace {

constexpr const char* kCounter = "counter";
constexpr const char* kGauge = "gauge";

std::string Escaped(std::string_view label) {
  std::string text;
  for (const char c : label) {
    if (c == '\\' || c == '"') text += '\\';
    if (c == '\n') {
      text += "\\n";
    } else {
      text += c;
    }
  }
  return text;
}

double Seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

template <typename Count>
double Number(Count count) {
  return static_cast<double>(count);  // exact up to 2^53
}

// The text as it grows: families, each with its samples.
class Exposition {
 public:
  void Family(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
    text_ << "# HELP powderkeg_" << name << ' ' << help << '\n'
          << "# TYPE powderkeg_" << name << ' ' << type << '\n';
  }
  void Sample(double value) {
    text_ << "powderkeg_" << name_;
    WriteValue(value);
  }
  void Sample(std::string_view label, std::string_view label_value, double value) {
    text_ << "powderkeg_" << name_ << '{' << label << "=\"" << Escaped(label_value) << "\"}";
    WriteValue(value);
  }
  void Single(std::string_view name, std::string_view type, std::string_view help, double value) {
    Family(name, type, help);
    Sample(value);
  }

  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  void WriteValue(double value) {
    text_ << ' ';
    if (std::isnan(value)) {
      text_ << "NaN";
    } else if (std::isinf(value)) {
      text_ << (value > 0 ? "+Inf" : "-Inf");
    } else {
      text_ << std::setprecision(15) << value;
    }
    text_ << '\n';
  }

  std::ostringstream text_;
  std::string name_;  // of the family
};

void AddRun(const RunView& view, Exposition& out) {
  const LiveStatus& status = view.status;
  out.Family("run_info", kGauge, "Always 1; the label is the name of the run.");
  out.Sample("run", view.run, 1);
  out.Single("start_time_seconds", kGauge, "When the learner started, in seconds since 1970.",
             Number(view.started_unix_s));
  out.Single("iterations_done", kGauge, "Completed iterations.", status.iterations_done);
  out.Single("iterations_wanted", kGauge, "Iterations of the whole run.", status.iterations);
  out.Single("dataset_decisions", kGauge, "Decisions that the next data set can use.",
             Number(status.decisions));
  out.Single("dataset_wanted_decisions", kGauge, "Decisions that the next data set needs.",
             Number(status.decisions_wanted));
  out.Single("training_samples", kGauge, "Samples trained in the training in progress.",
             Number(status.samples));
  out.Single("training_wanted_samples", kGauge,
             "Samples of the training in progress; 0: none is in progress.",
             Number(status.samples_wanted));
}

void AddIntake(const IntakeStatistics& intake, Exposition& out) {
  out.Single("games_total", kCounter, "Games made durable.", Number(intake.games));
  out.Single("decisions_total", kCounter, "Decisions in the games made durable.",
             Number(intake.decisions));
  out.Single("duplicate_games_total", kCounter, "Games received that were durable already.",
             Number(intake.duplicates));
  out.Single("rejected_games_total", kCounter, "Games refused because they were wrong.",
             Number(intake.rejected));
  out.Single("other_settings_games_total", kCounter,
             "Durable games played under other settings of the search.",
             Number(intake.other_settings));
  out.Single("malformed_messages_total", kCounter, "Messages that could not be read.",
             Number(intake.malformed));
  out.Single("lost_sessions_total", kCounter, "Sessions of actors ended by silence.",
             Number(intake.sessions_lost));
  out.Single("pending_games", kGauge, "Games received and not yet durable.",
             Number(intake.pending_games));
  out.Single("actors", kGauge, "Actors connected.", Number(intake.actors.size()));
}

// A metric that every actor has.
struct ActorMetric {
  const char* name;
  const char* type;
  const char* help;
  double (*value)(const ActorStatistics&);
};

using Actor = ActorStatistics;

constexpr std::array kActorMetrics = {
    ActorMetric{"actor_games_total", kCounter, "Games of its session made durable.",
                [](const Actor& actor) { return Number(actor.games); }},
    ActorMetric{"actor_rejected_games_total", kCounter, "Games of its session refused.",
                [](const Actor& actor) { return Number(actor.rejected); }},
    ActorMetric{"actor_decisions_total", kCounter, "Decisions in the games it finished.",
                [](const Actor& actor) { return Number(actor.heartbeat.decisions); }},
    ActorMetric{"actor_simulations_total", kCounter, "Simulations in the games it finished.",
                [](const Actor& actor) { return Number(actor.heartbeat.simulations); }},
    ActorMetric{"actor_evaluations_total", kCounter, "Positions its evaluators answered.",
                [](const Actor& actor) { return Number(actor.heartbeat.evaluations); }},
    ActorMetric{"actor_batches_total", kCounter, "Batches in which they were answered.",
                [](const Actor& actor) { return Number(actor.heartbeat.batches); }},
    ActorMetric{"actor_silence_seconds", kGauge, "Time since its last message.",
                [](const Actor& actor) { return Seconds(actor.silence); }},
    ActorMetric{"actor_tickets", kGauge, "Tickets it holds.",
                [](const Actor& actor) { return Number(actor.tickets); }},
    ActorMetric{"actor_running_games", kGauge, "Games it plays now.",
                [](const Actor& actor) { return Number(actor.heartbeat.games_running); }},
    ActorMetric{"actor_oldest_game_seconds", kGauge, "Age of the oldest game it plays.",
                [](const Actor& actor) { return Seconds(actor.heartbeat.oldest_game); }},
    ActorMetric{"actor_spool_games", kGauge, "Games in its spool, not yet acknowledged.",
                [](const Actor& actor) { return Number(actor.heartbeat.outbox_games); }},
    ActorMetric{"actor_spool_bytes", kGauge, "Size of its spool.",
                [](const Actor& actor) { return Number(actor.heartbeat.outbox_bytes); }},
    ActorMetric{"actor_weights_version", kGauge, "Version of the weights its new games start with.",
                [](const Actor& actor) { return Number(actor.heartbeat.weights_version); }},
};

void AddActors(const IntakeStatistics& intake, Exposition& out) {
  if (intake.actors.empty()) return;
  for (const ActorMetric& metric : kActorMetrics) {
    out.Family(metric.name, metric.type, metric.help);
    for (const Actor& actor : intake.actors) out.Sample("actor", actor.name, metric.value(actor));
  }
}

void AddResults(const MatchScore& score, Exposition& out) {
  const Interval wins = WilsonInterval(score.wins, score.games());
  out.Family("iteration_result_ratio", kGauge, "Share of the games of the last iteration.");
  const double games = Number(score.games());  // without any the shares are NaN
  out.Sample("result", "win", Number(score.wins) / games);
  out.Sample("result", "tie", Number(score.ties) / games);
  out.Sample("result", "loss", Number(score.losses) / games);
  out.Single("iteration_win_low95_ratio", kGauge, "Lower end of the 95 % interval of wins.",
             wins.low);
  out.Single("iteration_win_high95_ratio", kGauge, "Upper end of the 95 % interval of wins.",
             wins.high);
}

void AddIteration(const IterationReport& report, Exposition& out) {
  constexpr std::array<const char*, kActionCount> kActions = {"stop", "up",    "down",
                                                              "left", "right", "bomb"};
  out.Single("iteration", kGauge, "The last iteration, which the other iteration_... describe.",
             report.iteration);
  out.Single("iteration_games", kGauge, "Games in its data set.", Number(report.games));
  out.Single("iteration_decisions", kGauge, "Decisions in its data set.", Number(report.decisions));
  AddResults(report.score, out);
  out.Single("iteration_mean_steps", kGauge, "Steps a game.", report.mean_steps);
  out.Family("iteration_action_ratio", kGauge, "Share of the moves.");
  for (std::size_t i = 0; i < kActions.size(); ++i) {
    out.Sample("action", kActions[i], report.action_shares[i]);
  }
  out.Single("iteration_weights_lag", kGauge,
             "Mean age of the weights that its games started with, in versions.",
             report.weights_lag);
  out.Family("iteration_loss", kGauge, "Mean loss of its training, weighted sum and parts.");
  out.Sample("part", "total", report.total_loss);
  out.Sample("part", "policy", report.policy_loss);
  out.Sample("part", "value", report.value_loss);
  out.Single("iteration_policy_accuracy_ratio", kGauge,
             "How often the network's best action was the target's.", report.policy_accuracy);
  out.Single("iteration_waited_seconds", kGauge, "Time it waited for games.", report.waited_s);
  out.Single("iteration_trained_seconds", kGauge, "Time it trained.", report.trained_s);
}

}  // namespace

std::string MetricsText(const RunView& view) {
  Exposition out;
  AddRun(view, out);
  AddIntake(view.intake, out);
  AddActors(view.intake, out);
  if (view.last_iteration) AddIteration(*view.last_iteration, out);
  return out.text();
}

}  // namespace powderkeg
