#include "learner/train/learner_loop.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <utility>

#include "common/base/check.h"
#include "common/base/durable_file.h"
#include "common/base/log.h"
#include "common/record/ticket_set.h"

namespace powderkeg {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kWaitLogInterval = std::chrono::seconds(60);
constexpr auto kTrainLogInterval = std::chrono::seconds(60);

// Purposes of the generators split from the run's seed: iteration k uses k.
constexpr std::uint64_t kInitialWeights = 0;
constexpr std::uint64_t kHeldOut = std::uint64_t{1} << 32;

// Decisions that wait for their iteration take 400 bytes each.
constexpr int kMostAhead = 10'000'000;

int DataSetsAhead(const TrainingConfig& training) {
  if (training.sequential) return 1;
  return training.continuous ? std::max(2, kMostAhead / training.decisions_per_iteration) : 2;
}

Schedule MakeSchedule(const TrainingConfig& training, std::vector<TicketRange> data_sets) {
  const auto decisions = static_cast<std::uint64_t>(training.decisions_per_iteration);
  return Schedule({.iterations = training.iterations,
                   .decisions_per_iteration = decisions,
                   .window_data_sets = training.window_datasets,
                   .data_sets_ahead = DataSetsAhead(training),
                   .growing = training.continuous},
                  std::move(data_sets));
}

TrainerState UntrainedState(const LearnerLoopSettings& settings) {
  TrainerState state;
  state.weights = InitialWeights(
      NetworkByName(settings.training.network), Rng(settings.seed).Split(kInitialWeights),
      settings.training.initialisation == "pytorch" ? Initialisation::kPytorch
                                                    : Initialisation::kHe);
  state.weights.version = 1;
  return state;
}

// Weights of the same network without the head that foretells the others get a new one; the
// optimizer then starts anew.
void AddMissingHead(const NetworkDescription& network, Rng rng, TrainerState& state) {
  NetworkDescription with_head = state.weights.description;
  with_head.others_hidden = network.others_hidden;
  if (state.weights.description == network || with_head != network) return;
  const WeightsSnapshot fresh = InitialWeights(network, rng);
  const auto known = static_cast<std::ptrdiff_t>(state.weights.arrays.size());
  state.weights.arrays.insert(state.weights.arrays.end(), fresh.arrays.begin() + known,
                              fresh.arrays.end());
  state.weights.description = network;
  state.optimizer.clear();
  log::Info("the weights to go on from foretell nobody: they learn it from now on");
}

void FitNetwork(const LearnerLoopSettings& settings, TrainerState& state) {
  const std::string& name = settings.training.network;
  const NetworkDescription network = NetworkByName(name);
  AddMissingHead(network, Rng(settings.seed).Split(kInitialWeights), state);
  if (state.weights.description == network) return;
  throw Error(StrCat("training.network is ", name,
                     ", but the weights to go on from are of another network"));
}

IterationReport MakeReport(int iteration, const DataSet& data_set, const TrainingResult& training) {
  const PlaySummary& play = data_set.play;
  const double games = std::max(1.0, static_cast<double>(play.games));
  IterationReport report;
  report.iteration = iteration;
  report.games = play.games;
  report.decisions = play.decisions;
  report.score = play.score;
  report.exams = data_set.exam.score;
  report.mean_steps = static_cast<double>(play.steps) / games;
  for (std::size_t i = 0; i < play.actions.size(); ++i) {
    report.action_shares[i] =
        static_cast<double>(play.actions[i]) / std::max(1.0, static_cast<double>(play.decisions));
  }
  report.weights_lag = iteration - static_cast<double>(play.weights_versions) / games;
  report.total_loss = training.total_loss;
  report.policy_loss = training.policy_loss;
  report.target_entropy = training.target_entropy;
  report.value_loss = training.value_loss;
  report.policy_accuracy = training.policy_accuracy;
  report.others_accuracy = training.others_accuracy;
  report.reuse_ratio =
      static_cast<double>(training.samples) / std::max(1.0, static_cast<double>(play.decisions));
  report.samples_per_s = training.samples_per_s;
  return report;
}

void AddHeldOut(const TrainingResult& measured, IterationReport& report) {
  report.held_out_samples = measured.samples;
  report.held_out_policy_loss = measured.policy_loss;
  report.held_out_value_loss = measured.value_loss;
  report.held_out_accuracy = measured.policy_accuracy;
  report.held_out_others_accuracy = measured.others_accuracy;
}

}  // namespace

std::filesystem::path WeightsPath(const std::filesystem::path& run_folder, std::uint32_t version) {
  std::ostringstream name;
  name << "version-" << std::setw(6) << std::setfill('0') << version << ".weights";
  return run_folder / "weights" / name.str();
}

// Says at intervals what the loop waits for.
class LearnerLoop::WaitLog {
 public:
  explicit WaitLog(const TicketPrefix::Progress& progress)
      : last_(progress.decisions), last_time_(Clock::now()) {}

  void Update(int iteration, const TicketPrefix::Progress& progress, std::uint64_t wanted) {
    const Clock::time_point now = Clock::now();
    if (now - last_time_ < kWaitLogInterval) return;
    const double rate =
        static_cast<double>(progress.decisions - last_) / Seconds(now - last_time_).count();
    last_ = progress.decisions;
    last_time_ = now;
    const std::uint64_t have = std::min(progress.decisions_in_prefix, wanted);
    const std::string left =
        rate > 0 ? StrCat(std::llround(static_cast<double>(wanted - have) / rate)) : "unknown";
    const std::string straggler = progress.straggler ? StrCat(*progress.straggler) : "none";
    log::Info("waiting for games", "iteration", iteration, "have", have, "of", wanted, "ahead",
              progress.decisions - have, "per_s", std::llround(rate), "left_s", left,
              "missing_ticket", straggler);
  }

 private:
  std::uint64_t last_;
  Clock::time_point last_time_;
};

LearnerLoop::LearnerLoop(LearnerLoopSettings settings, LearnerLoopHooks hooks)
    : settings_(std::move(settings)),
      hooks_(std::move(hooks)),
      checkpoints_(settings_.folder / "checkpoints", settings_.training.checkpoints_kept),
      window_(settings_.training.window_datasets, settings_.window_bytes),
      schedule_(MakeSchedule(settings_.training, {})) {
  PrepareFolder(settings_.folder / "weights");
  TrainerState state = FirstOrNewestState();
  FitNetwork(settings_, state);
  version_ = state.weights.version;
  trainer_ = std::make_unique<Trainer>(
      TrainerSettings{settings_.training, settings_.game, settings_.precision}, state);
}

// Given weights are a checkpoint before the first iteration: from now on the run has them.
TrainerState LearnerLoop::FirstOrNewestState() {
  std::optional<Checkpoint> checkpoint = checkpoints_.LoadNewest();
  if (!checkpoint && settings_.first) {
    checkpoint = Checkpoint{.data_sets = {}, .trainer = *settings_.first, .table = {}};
    FitNetwork(settings_, checkpoint->trainer);
    checkpoints_.Save(*checkpoint);
  }
  if (!checkpoint) return UntrainedState(settings_);
  if (checkpoint->data_sets.empty()) first_weights_ = FirstWeights::kGiven;
  log::Info("resuming", "iterations_done", checkpoint->iteration(), "samples_seen",
            checkpoint->trainer.samples_seen);
  schedule_ = MakeSchedule(settings_.training, std::move(checkpoint->data_sets));
  table_ = std::move(checkpoint->table);
  return std::move(checkpoint->trainer);
}

LearnerLoop::~LearnerLoop() = default;

bool LearnerLoop::Wants(std::uint64_t ticket) const {
  const std::lock_guard lock(mutex_);
  return schedule_.UseOf(ticket) != Schedule::Use::kNone;
}

void LearnerLoop::AddDemonstrations(std::vector<Lessons> games) {
  const auto is_held_out = [this](const Lessons& game) {
    return PartOf(game.ticket) == DataSet::Part::kHeldOut;
  };
  if (std::ranges::all_of(games, is_held_out)) {
    throw Error(StrCat("all ", games.size(),
                       " recorded games are held out; expected more games, or ", "less than ",
                       settings_.training.held_out_share, " as training.held_out_share"));
  }
  for (Lessons& game : games) Add(std::move(game));
  const std::lock_guard lock(mutex_);
  demonstrated_ = true;
  schedule_.CloseFirstDataSet();
}

void LearnerLoop::Add(Lessons&& game) {
  const std::lock_guard lock(mutex_);
  if (settings_.training.sequential && !IsOfItsIteration(game)) PassOver(game);
  const auto decisions = static_cast<std::uint32_t>(game.samples.size());
  const Schedule::Use use = schedule_.Add(game.ticket, decisions);
  if (use == Schedule::Use::kNone || (use == Schedule::Use::kWindow && window_restored_)) return;
  games_.emplace(game.ticket, std::move(game));
  games_added_.notify_all();
}

// It is there, but nothing is learned from it.
void LearnerLoop::PassOver(Lessons& game) {
  game.samples.clear();
  game.play = {};
}

// Whether it was played with the weights that its iteration began with.
bool LearnerLoop::IsOfItsIteration(const Lessons& game) const {
  return game.play.weights_versions ==
         static_cast<std::uint64_t>(schedule_.IterationOf(game.ticket));
}

std::uint64_t LearnerLoop::next_ticket() const {
  const std::lock_guard lock(mutex_);
  return schedule_.next_ticket();
}

std::uint64_t LearnerLoop::OldestTicketNeeded() const {
  const std::lock_guard lock(mutex_);
  return schedule_.OldestTicketNeeded(settings_.training.checkpoints_kept);
}

std::uint64_t LearnerLoop::GamesWanted() const {
  const std::lock_guard lock(mutex_);
  return demonstrated_ && version_ == 1 ? 0 : schedule_.GamesWanted();
}

LearnerLoop::Progress LearnerLoop::progress() const {
  const std::lock_guard lock(mutex_);
  return {.iteration = static_cast<int>(version_) - 1,
          .games = schedule_.progress(),
          .decisions_wanted = schedule_.decisions_wanted(),
          .training = training_progress_};
}

void LearnerLoop::Run(const std::stop_token& stop) {
  log::Info("training", "device", trainer_->description(), "network", settings_.training.network);
  RestoreWindow();
  Publish(trainer_->state(version_));
  while (!stop.stop_requested() && !schedule_.finished()) {
    const Clock::time_point start = Clock::now();
    auto data_set = NextDataSet(stop);
    if (!data_set || !RunIteration(*std::move(data_set), Clock::now() - start, stop)) return;
  }
}

void LearnerLoop::RestoreWindow() {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint64_t> missing;
  for (const TicketRange& range : schedule_.WindowOfNext()) {
    for (std::uint64_t ticket = range.first; ticket <= range.last; ++ticket) {
      if (!games_.contains(ticket)) missing.push_back(ticket);
    }
    window_.Push(DataSetOf(TakeGames(range)).samples);
  }
  window_restored_ = true;
  if (missing.empty()) return;
  log::Warn("games of finished iterations are not in the store: training goes on without them",
            "tickets", TicketsText(std::move(missing)));
}

std::vector<Lessons> LearnerLoop::TakeGames(const TicketRange& range) {
  std::vector<Lessons> games;
  for (std::uint64_t ticket = range.first; ticket <= range.last; ++ticket) {
    auto game = games_.extract(ticket);
    if (!game.empty()) games.push_back(std::move(game.mapped()));
  }
  return games;
}

DataSet LearnerLoop::DataSetOf(std::vector<Lessons> games) const {
  DataSet data_set;
  std::size_t samples = 0;
  for (const Lessons& game : games) samples += game.samples.size();
  data_set.samples.reserve(samples);
  for (Lessons& game : games) {
    const DataSet::Part part = PartOf(game.ticket);
    data_set.Add(std::exchange(game, {}), part);  // its memory is free at once
  }
  return data_set;
}

// Drawn by the ticket, so that a game that was held out once is held out ever after.
DataSet::Part LearnerLoop::PartOf(std::uint64_t ticket) const {
  Rng rng = Rng(settings_.seed).Split(kHeldOut).Split(ticket);
  return rng.Uniform() < settings_.training.held_out_share ? DataSet::Part::kHeldOut
                                                           : DataSet::Part::kTraining;
}

std::optional<DataSet> LearnerLoop::NextDataSet(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  WaitLog wait_log(schedule_.progress());
  while (!stop.stop_requested()) {
    if (const auto range = schedule_.StartIteration()) {
      std::vector<Lessons> games = TakeGames(*range);
      if (settings_.training.sequential) {
        for (auto& [ticket, game] : games_) PassOver(game);
        schedule_.PassOver();
      }
      lock.unlock();  // it takes a while, and games come
      return DataSetOf(std::move(games));
    }
    const std::uint64_t wanted = schedule_.decisions_wanted();
    games_added_.wait_for(lock, stop, kWaitLogInterval,
                          [&] { return schedule_.progress().decisions_in_prefix >= wanted; });
    wait_log.Update(schedule_.iteration() + 1, schedule_.progress(), wanted);
  }
  return std::nullopt;
}

bool LearnerLoop::RunIteration(DataSet data_set, Seconds waited, const std::stop_token& stop) {
  const Clock::time_point start = Clock::now();
  const int iteration = schedule_.iteration();
  window_.Push(std::move(data_set.samples));
  const TrainingResult result = Train(iteration, stop);
  if (!result.finished) return false;

  IterationReport report = MakeReport(iteration, data_set, result);
  if (!data_set.held_out.empty()) AddHeldOut(trainer_->Measure(data_set.held_out), report);
  report.waited_s = waited.count();
  report.trained_s = Seconds(Clock::now() - start).count();
  std::string table = hooks_.iteration_trained(report, data_set.results);
  const TrainerState state = trainer_->state(version_ + 1);
  checkpoints_.Save(
      {.data_sets = schedule_.data_sets(), .trainer = state, .table = std::move(table)});
  Publish(state);  // before more games are wanted
  {
    const std::lock_guard lock(mutex_);
    ++version_;
    training_progress_ = {};
  }
  hooks_.iteration_done(report);
  return true;
}

TrainingResult LearnerLoop::Train(int iteration, const std::stop_token& stop) {
  Clock::time_point last_log = Clock::now();
  const auto show_progress = [&](const TrainingProgress& progress) {
    {
      const std::lock_guard lock(mutex_);
      training_progress_ = progress;
    }
    if (Clock::now() - last_log < kTrainLogInterval) return;
    last_log = Clock::now();
    log::Info("training", "iteration", iteration, "samples", progress.samples_done, "of",
              progress.samples);
  };
  const Rng rng = Rng(settings_.seed).Split(static_cast<std::uint64_t>(iteration));
  return trainer_->Train(window_, iteration, rng, stop, show_progress);
}

void LearnerLoop::Publish(const TrainerState& state) {
  const Snapshot snapshot = MakePublishedSnapshot(state, window_);
  SaveSnapshot(*snapshot, WeightsPath(settings_.folder, snapshot->version).string());
  const int iterations_done = static_cast<int>(snapshot->version) - 1;
  hooks_.publish(VersionToPlay(iterations_done, first_weights_) == 0 ? nullptr : snapshot);
}

}  // namespace powderkeg
