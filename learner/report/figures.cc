#include "learner/report/figures.h"

#include <chrono>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using Report = IterationReport;
using Actor = ActorStatistics;
using Intake = IntakeStatistics;
using Score = MatchScore;
using Status = LiveStatus;
using Result = std::uint64_t Score::*;

constexpr FigureKind kGauge = FigureKind::kGauge;
constexpr FigureKind kCounter = FigureKind::kCounter;

constexpr Chart kResults{"Results"};
constexpr Chart kRating{"Rating"};
constexpr Chart kPolicyLoss{"Policy loss"};
constexpr Chart kValueLoss{"Value loss"};
constexpr Chart kAgreement{"Agreement with the target"};
constexpr Chart kActions{"Actions", /*stacked=*/true};
constexpr Chart kSteps{"Steps a game"};
constexpr Chart kTime{"Time", /*stacked=*/true};

constexpr const char* kWinHeading = "win %";
constexpr const char* kTieHeading = "tie %";
constexpr const char* kLossHeading = "loss %";
constexpr const char* kActionsHeading = "stop/up/down/left/right/bomb";

template <auto kMember, typename Source>
double Of(const Source& source) {
  return static_cast<double>(source.*kMember);
}

// The games that say how strong the agent is: the exams, or without any those trained on.
const MatchScore& Measured(const Report& report) {
  return report.exams.games() > 0 ? report.exams : report.score;
}

template <Result kResult>
double Rate(const Report& report) {
  const MatchScore& score = Measured(report);
  return static_cast<double>(score.*kResult) / static_cast<double>(score.games());
}

template <Result kResult, double Interval::*kEnd>
double End(const Report& report) {
  const MatchScore& score = Measured(report);
  return score.games() > 0 ? WilsonInterval(score.*kResult, score.games()).*kEnd : kAbsent;
}

template <Result kResult>
constexpr auto Low = End<kResult, &Interval::low>;
template <Result kResult>
constexpr auto High = End<kResult, &Interval::high>;

template <Result kResult>
double Trained(const Report& report) {
  return static_cast<double>(report.score.*kResult);
}

template <Result kResult>
double Exams(const Report& report) {
  return report.exams.games() > 0 ? static_cast<double>(report.exams.*kResult) : kAbsent;
}

double Elo(const Report& report) { return report.progress ? report.progress->elo : kAbsent; }

template <int kSign>
double EloEnd(const Report& report) {
  return report.progress ? Elo(report) + kSign * report.progress->half_interval : kAbsent;
}

template <double Report::*kMember>
double HeldOut(const Report& report) {
  return report.held_out_samples > 0 ? report.*kMember : kAbsent;
}

double ExamGames(const Report& report) {
  const std::uint64_t games = report.exams.games();
  return games > 0 ? static_cast<double>(games) : kAbsent;
}

template <Action kAction>
double Share(const Report& report) {
  return report.action_shares[static_cast<std::size_t>(kAction)];
}

template <auto kMember>
double Beat(const Actor& actor) {
  return static_cast<double>(actor.heartbeat.*kMember);
}

double MeanBatch(const Actor& actor) {
  return Beat<&Heartbeat::evaluations>(actor) / Beat<&Heartbeat::batches>(actor);
}

double Seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}
double OldestGame(const Actor& actor) { return Seconds(actor.heartbeat.oldest_game); }
double Silence(const Actor& actor) { return Seconds(actor.silence); }

constexpr Figure kIterationFigures[] = {
    {"iteration", Of<&Report::iteration>, "", "%4.0f", "iteration", "Number of the iteration.",
     "iter"},
    {"games", Of<&Report::games>, "", "%5.0f", "games", "Games in its data set.", "games"},
    {"decisions", Of<&Report::decisions>, "", "%9.0f", "decisions", "Decisions in its data set.",
     "decisions"},
    {"exam_games", ExamGames, "", "%5.0f", "exams", "Games of exams, which are not trained on.",
     "exams"},
    {"win_rate", Rate<&Score::wins>, "%", "%5.1f", "wins",
     "Games won, of the exams or else of the games trained on.", kWinHeading, &kResults},
    {"win_rate_low95", Low<&Score::wins>, "%", " [%4.1f", "",
     "Lower end of the 95 % interval of wins.", kWinHeading},
    {"win_rate_high95", High<&Score::wins>, "%", "-%5.1f]", "",
     "Upper end of the 95 % interval of wins.", kWinHeading},
    {"tie_rate", Rate<&Score::ties>, "%", "%5.1f", "ties", "Games tied, of the same.", kTieHeading,
     &kResults},
    {"tie_rate_low95", Low<&Score::ties>, "%", " [%4.1f", "",
     "Lower end of the 95 % interval of ties.", kTieHeading},
    {"tie_rate_high95", High<&Score::ties>, "%", "-%5.1f]", "",
     "Upper end of the 95 % interval of ties.", kTieHeading},
    {"loss_rate", Rate<&Score::losses>, "%", "%5.1f", "losses", "Games lost, of the same.",
     kLossHeading, &kResults},
    {"loss_rate_low95", Low<&Score::losses>, "%", " [%4.1f", "",
     "Lower end of the 95 % interval of losses.", kLossHeading},
    {"loss_rate_high95", High<&Score::losses>, "%", "-%5.1f]", "",
     "Upper end of the 95 % interval of losses.", kLossHeading},
    {"wins", Trained<&Score::wins>, "", "%.0f", "", "Games won of those trained on."},
    {"ties", Trained<&Score::ties>, "", "%.0f", "", "Games tied of those trained on."},
    {"losses", Trained<&Score::losses>, "", "%.0f", "", "Games lost of those trained on."},
    {"exam_wins", Exams<&Score::wins>, "", "%.0f", "", "Games of exams that were won."},
    {"exam_ties", Exams<&Score::ties>, "", "%.0f", "", "Games of exams that were tied."},
    {"exam_losses", Exams<&Score::losses>, "", "%.0f", "", "Games of exams that were lost."},
    {"rating", Elo, "", "%5.0f", "Elo",
     "Rating of the newest version that was met over the oldest, from who outlived whom.", "Elo",
     &kRating},
    {"rating_low95", EloEnd<-1>, "", "%.0f", "", "Lower end of the 95 % interval of Elo."},
    {"rating_high95", EloEnd<+1>, "", "%.0f", "", "Upper end of the 95 % interval of Elo."},
    {"mean_steps", Of<&Report::mean_steps>, "", "%5.1f", "steps", "Steps a game.", "steps",
     &kSteps},
    {"share_stop", Share<Action::kStop>, "%", "%2.0f", "stop", "Searched moves that were stop.",
     kActionsHeading, &kActions},
    {"share_up", Share<Action::kUp>, "%", "/%2.0f", "up", "Searched moves that were up.",
     kActionsHeading, &kActions},
    {"share_down", Share<Action::kDown>, "%", "/%2.0f", "down", "Searched moves that were down.",
     kActionsHeading, &kActions},
    {"share_left", Share<Action::kLeft>, "%", "/%2.0f", "left", "Searched moves that were left.",
     kActionsHeading, &kActions},
    {"share_right", Share<Action::kRight>, "%", "/%2.0f", "right",
     "Searched moves that were right.", kActionsHeading, &kActions},
    {"share_bomb", Share<Action::kBomb>, "%", "/%2.0f", "bomb", "Searched moves that were bomb.",
     kActionsHeading, &kActions},
    {"total_loss", Of<&Report::total_loss>, "", "%5.3f", "",
     "Weighted sum of the losses of its training.", "loss"},
    {"policy_loss", Of<&Report::policy_loss>, "", "%6.3f", "policy loss",
     "Mean loss of the policy in its training.", "policy", &kPolicyLoss},
    {"target_entropy", Of<&Report::target_entropy>, "", "%6.3f", "target entropy",
     "Mean entropy of the policy's targets: the least that its loss can be. The difference is the "
     "Kullback-Leibler divergence.",
     "", &kPolicyLoss},
    {"value_loss", Of<&Report::value_loss>, "", "%5.3f", "value loss",
     "Mean loss of the value in its training.", "value", &kValueLoss},
    {"policy_accuracy", Of<&Report::policy_accuracy>, "%", "%5.1f", "agreement",
     "How often the network's best action was the target's.", "agree %", &kAgreement},
    {"others_accuracy", Of<&Report::others_accuracy>, "%", "%5.1f", "foretold",
     "How often the network foretold what another agent in view did next.", "foretold %",
     &kAgreement},
    {"held_out_policy_loss", HeldOut<&Report::held_out_policy_loss>, "", "%6.3f",
     "held-out policy loss", "Mean loss of the policy on games that are held out.",
     "held-out policy", &kPolicyLoss},
    {"held_out_value_loss", HeldOut<&Report::held_out_value_loss>, "", "%5.3f",
     "held-out value loss", "Mean loss of the value on games that are held out.", "held-out value",
     &kValueLoss},
    {"held_out_accuracy", HeldOut<&Report::held_out_accuracy>, "%", "%5.1f", "held-out agreement",
     "The agreement on games that are held out.", "held-out agree %", &kAgreement},
    {"held_out_others_accuracy", HeldOut<&Report::held_out_others_accuracy>, "%", "%5.1f",
     "held-out foretold", "The same on games that are held out.", "held-out foretold %",
     &kAgreement},
    {"weights_lag", Of<&Report::weights_lag>, "", "%3.1f", "lag",
     "Mean age of the weights that its games started with, in versions.", "lag"},
    {"reuse_ratio", Of<&Report::reuse_ratio>, "", "%5.2f", "reuse ratio",
     "Samples trained for each decision of its games.", "reuse"},
    {"samples_per_s", Of<&Report::samples_per_s>, "", "%9.0f", "samples/s",
     "Samples trained in a second.", "samples/s"},
    {"waited_s", Of<&Report::waited_s>, "s", "%6.0f", "waited", "Time it waited for games.",
     "wait s", &kTime},
    {"trained_s", Of<&Report::trained_s>, "s", "%7.0f", "trained", "Time it trained.", "train s",
     &kTime},
};

constexpr LiveFigure<Status> kRunFigures[] = {
    {"iterations_done", kGauge, Of<&Status::iterations_done>, "", "", "Completed iterations."},
    {"iterations", kGauge, Of<&Status::iterations>, "", "", "Iterations of the whole run."},
    {"decisions", kGauge, Of<&Status::decisions>, "", "",
     "Decisions that the next data set can use."},
    {"decisions_wanted", kGauge, Of<&Status::decisions_wanted>, "", "",
     "Decisions that the next data set needs."},
    {"decisions_beyond", kGauge, Of<&Status::decisions_beyond>, "", "",
     "Decisions in finished games behind one that is missing."},
    {"samples", kGauge, Of<&Status::samples>, "", "",
     "Samples trained in the training in progress."},
    {"samples_wanted", kGauge, Of<&Status::samples_wanted>, "", "",
     "Samples of the training in progress; 0: none is."},
    {"actors_connected", kGauge, Of<&Status::actors>, "", "", "Actors connected."},
};

constexpr LiveFigure<Intake> kIntakeFigures[] = {
    {"games", kCounter, Of<&Intake::games>, "", "", "Games made durable."},
    {"decisions", kCounter, Of<&Intake::decisions>, "", "", "Decisions in the games made durable."},
    {"pending_games", kGauge, Of<&Intake::pending_games>, "", "pending games",
     "Games received and not yet durable."},
    {"duplicates", kCounter, Of<&Intake::duplicates>, "", "duplicates",
     "Games received that were durable already."},
    {"rejected", kCounter, Of<&Intake::rejected>, "", "rejected",
     "Games refused because they were wrong.", 0},
    {"other_settings", kCounter, Of<&Intake::other_settings>, "", "",
     "Durable games played under other settings of the search."},
    {"malformed", kCounter, Of<&Intake::malformed>, "", "malformed",
     "Messages that could not be read.", 0},
    {"sessions_lost", kCounter, Of<&Intake::sessions_lost>, "", "sessions lost",
     "Sessions of actors ended by silence.", 0},
    {"tickets_issued", kGauge, Of<&Intake::tickets_issued>, "", "",
     "Tickets handed out since the run began."},
};

constexpr LiveFigure<Actor> kActorFigures[] = {
    {"games", kCounter, Of<&Actor::games>, "", "", "Games of its session made durable."},
    {"rejected", kCounter, Of<&Actor::rejected>, "", "", "Games of its session refused.", 0},
    {"games_played", kCounter, Beat<&Heartbeat::games>, "", "games", "Games it finished."},
    {"decisions", kCounter, Beat<&Heartbeat::decisions>, "", "decisions",
     "Decisions in the games it finished."},
    {"simulations", kCounter, Beat<&Heartbeat::simulations>, "", "simulations",
     "Simulations in the games it finished."},
    {"evaluations", kCounter, Beat<&Heartbeat::evaluations>, "", "evaluations",
     "Positions its evaluators answered."},
    {"batches", kCounter, Beat<&Heartbeat::batches>, "", "",
     "Batches in which they were answered."},
    {"mean_batch", kGauge, MeanBatch, "", "mean batch", "Positions in a batch."},
    {"games_running", kGauge, Beat<&Heartbeat::games_running>, "", "running",
     "Games it plays now."},
    {"tickets", kGauge, Of<&Actor::tickets>, "", "tickets", "Tickets it holds."},
    {"spool_games", kGauge, Beat<&Heartbeat::outbox_games>, "", "spool",
     "Games in its spool, not yet acknowledged."},
    {"spool_bytes", kGauge, Beat<&Heartbeat::outbox_bytes>, "B", "spool size",
     "Size of its spool."},
    {"oldest_game_s", kGauge, OldestGame, "s", "", "Age of the oldest game it plays."},
    {"weights_version", kGauge, Beat<&Heartbeat::weights_version>, "", "weights",
     "Version of the weights its new games start with; 0: none."},
    {"silence_s", kGauge, Silence, "s", "last heard", "Time since its last message.", 3},
};

// The digits of a number after its point: of "%5.1f]" one.
std::string_view Digits(std::string_view format) { return format.substr(format.find('.') + 1, 1); }

void AddLine(std::string& text, std::initializer_list<std::string_view> cells) {
  char separator = '\n';
  for (const std::string_view cell : cells) (text += std::exchange(separator, '\t')) += cell;
}

template <typename Source>
void AddLive(std::string& text, std::string_view of, std::span<const LiveFigure<Source>> figures) {
  for (const auto& figure : figures) {
    const bool watched = std::isfinite(figure.alarm);
    AddLine(text, {of, figure.name, figure.unit, figure.label, "", "",
                   figure.kind == kCounter ? "counter" : "gauge",
                   watched ? StrCat(figure.alarm) : "", figure.help});
  }
}

}  // namespace

std::span<const Figure> IterationFigures() { return kIterationFigures; }
std::span<const LiveFigure<LiveStatus>> RunFigures() { return kRunFigures; }
std::span<const LiveFigure<IntakeStatistics>> IntakeFigures() { return kIntakeFigures; }
std::span<const LiveFigure<ActorStatistics>> ActorFigures() { return kActorFigures; }

std::vector<double> ValuesOf(const IterationReport& report) {
  std::vector<double> values;
  for (const Figure& figure : kIterationFigures) values.push_back(figure.value(report));
  return values;
}

std::string FiguresText() {
  std::string text = "of\tname\tunit\tlabel\tdigits\tchart\tstyle\talarm\thelp";
  for (const Figure& figure : kIterationFigures) {
    const Chart chart = figure.chart != nullptr ? *figure.chart : Chart{""};
    AddLine(text, {"iteration", figure.name, figure.unit, figure.label, Digits(figure.format),
                   chart.title, chart.stacked ? "area" : "line", "", figure.help});
  }
  AddLive(text, "run", RunFigures());
  AddLive(text, "intake", IntakeFigures());
  AddLive(text, "actor", ActorFigures());
  return text + '\n';
}

}  // namespace powderkeg
