#include "learner/run/learner.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <unordered_set>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/base/format.h"
#include "common/base/log.h"
#include "common/base/unique.h"
#include "common/base/worker.h"
#include "common/config/config.h"
#include "common/record/ticket_set.h"
#include "common/wire/zmq_transport.h"
#include "learner/replay/demonstrations.h"
#include "learner/report/dashboard.h"
#include "learner/report/figures.h"
#include "learner/report/iteration_table.h"

namespace powderkeg {
namespace {

// Small segments that are merged within an iteration too, that long ones do not fill the folder.
constexpr std::size_t kManySegments = 1000;

std::vector<std::string> NamesOfPlayers(const RunGames& games) {
  std::vector<std::string> names;
  for (const Player& player : games.players()) names.push_back(player.name);
  return names;
}

bool AsksForPredictions(const Player& player) {
  return player.agent.kind == AgentSpec::Kind::kSearch && Predicts(player.agent.search);
}

LiveStatus StatusOf(const LearnerLoop::Progress& progress, const IntakeStatistics& intake,
                    int iterations) {
  LiveStatus status;
  status.iterations_done = progress.iteration;
  status.iterations = iterations;
  status.decisions = progress.games.decisions_in_prefix;
  status.decisions_wanted = progress.decisions_wanted;
  status.decisions_beyond = progress.games.decisions - progress.games.decisions_in_prefix;
  status.straggler = progress.games.straggler;
  status.samples = progress.training.samples_done;
  status.samples_wanted = progress.training.samples;
  status.actors = intake.actors.size();
  status.totals.games = intake.games;
  status.totals.decisions = intake.decisions;
  for (const ActorStatistics& actor : intake.actors) {
    status.totals.evaluations += actor.heartbeat.evaluations;
    status.totals.batches += actor.heartbeat.batches;
  }
  return status;
}

// Of a game that was verified before it was stored.
Lessons LessonsOf(const GameRecord& game) {
  auto made = MakeLessons(game);
  if (const auto* reason = std::get_if<std::string>(&made)) {
    throw Error(StrCat("the stored game of ticket ", game.ticket, " is refused: ", *reason));
  }
  return std::get<Lessons>(std::move(made));
}

}  // namespace

Learner::Learner(const LearnerSettings& settings)
    : folder_(settings.folder),
      name_(RunNameOf(settings.folder)),
      config_(ConfigOfRun(settings.folder, settings.config, settings.changes)),
      games_(config_.self_play),
      store_(settings.folder / "replay"),
      loop_(LoopSettings(settings), LoopHooks()),
      history_(settings.folder / "iterations.csv", loop_.progress().iteration, loop_.table()),
      league_(settings.folder / "league.csv", NamesOfPlayers(games_), loop_.progress().iteration),
      exams_(settings.folder / "exams.csv", games_, loop_.progress().iteration),
      past_rng_(UniqueNumber()) {
  KeepWeights();
  LoadDemonstrations(settings.demonstrations);
  const std::vector<std::uint64_t> known = LoadGames();
  log::Info("run opened", "folder", settings.folder.string(), "games", known.size(),
            "iterations_done", loop_.progress().iteration);
  ServeActors(settings, known);
  if (settings.http) ServeHttp(*settings.http);
  StoreConfig(settings.folder, config_);  // nothing has turned out wrong
  WriteFileDurably(settings.folder / "figures.tsv", BytesOf(FiguresText()));
  display_.ShowLine(StrCat(settings.folder.string(), ": ", IterationsDone(), ", ", known.size(),
                           " games stored"));
  display_.ShowLine(StrCat("actors connect to ", server_->endpoint()));
}

void Learner::Run(const std::function<bool()>& stop_wanted) {
  Worker trainer("trainer", [this](const std::stop_token& stop) { loop_.Run(stop); });
  while (!stop_wanted() && !trainer.finished() && !server_->failed()) {
    display_.ShowStatus(View().status);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
  display_.Clear();
  // A trainer that failed has finished too: actors that then left would not come back.
  const bool complete = loop_.progress().iteration >= config_.training.iterations;
  trainer.RequestStop();
  server_->Stop({complete ? "the run is complete" : "the learner stops", complete});
  trainer.Join();
  log::Info(complete ? "run complete" : "stopped", "iterations_done", loop_.progress().iteration);
  display_.ShowLine(StrCat(complete ? "run complete" : "stopped", ": ", IterationsDone()));
}

// Fewer may be wanted than are done: settings can change.
std::string Learner::IterationsDone() const {
  const int done = loop_.progress().iteration;
  const int wanted = config_.training.iterations;
  if (done <= wanted) return StrCat(done, " of ", wanted, " iterations done");
  return StrCat(done, " iterations done, ", wanted, " are wanted");
}

LearnerLoopSettings Learner::LoopSettings(const LearnerSettings& settings) const {
  RunConfig tied = config_;
  TieOutcomesToSearch(tied);
  LearnerLoopSettings loop;
  loop.training = tied.training;
  loop.game = GameOf(config_.self_play);
  loop.folder = settings.folder;
  loop.seed = config_.self_play.seed;
  if (!settings.first_weights.empty()) loop.first = LoadFirstState(settings.first_weights);
  return loop;
}

LearnerLoopHooks Learner::LoopHooks() {
  return {.publish = [this](const Snapshot& snapshot) { server_->Publish(snapshot); },
          .iteration_trained =
              [this](IterationReport& report, std::span<const GameResult> results) {
                league_.Add(report.iteration, results);
                exams_.Add(report.iteration, results);
                report.progress = league_.Progress();
                return history_.Append(report);
              },
          .iteration_done =
              [this](const IterationReport& report) {
                log::Write(log::Level::kInfo, LogLine(report));
                display_.ShowIteration(report);
                ShowExams(report.iteration);
                oldest_ticket_needed_ = loop_.OldestTicketNeeded();
                merge_wanted_ = true;
              }};
}

// Those that are named by files, from now on copies of the run; they can be read.
void Learner::KeepWeights() const {
  for (const Player& player : games_.players()) {
    NetworkDescription network = NetworkByName(config_.training.network);
    if (player.weights == PlayerSpec::Weights::kFile) {
      network = LoadSnapshot(WeightsOfPlayer(folder_, player).string())->description;
    }
    if (network.others_hidden > 0 || !AsksForPredictions(player)) continue;
    throw Error(StrCat("self_play.player ", player.name,
                       " searches with opponents predicted or chosen, but its network foretells "
                       "nobody; expected training.network small, or other weights"));
  }
}

void Learner::LoadDemonstrations(std::span<const std::filesystem::path> given) {
  const std::vector<std::filesystem::path> files = DemonstrationsOfRun(folder_, given);
  if (files.empty() || !loop_.Wants(0)) return;
  std::vector<Lessons> games;
  ReadDemonstrations(files, config_.self_play.environment,
                     [&](Lessons&& game) { games.push_back(std::move(game)); });
  display_.ShowLine(StrCat(games.size(), " recorded games to learn from first"));
  loop_.AddDemonstrations(std::move(games));
}

void Learner::ShowExams(int iteration) {
  const std::vector<Exams::Row> exams = exams_.Of(iteration);
  for (const auto& [exam, score] : exams) {
    const Interval win = WilsonInterval(score.wins, score.games());
    log::Info("exam", "iteration", iteration, "exam", exam, "wins", score.wins, "ties", score.ties,
              "losses", score.losses, "win_low95", win.low, "win_high95", win.high);
    if (exams.size() < 2) continue;
    const auto percent = [&](double share) { return 100 * share; };
    const auto games = static_cast<double>(score.games());
    display_.ShowLine(Format("      exam %s: %.1f %% won [%.1f-%.1f], %.1f %% tied of %.0f",
                             exam.c_str(), percent(static_cast<double>(score.wins) / games),
                             percent(win.low), percent(win.high),
                             percent(static_cast<double>(score.ties) / games), games));
  }
}

// The tickets of the games stored so far; those that are still needed go to the loop.
std::vector<std::uint64_t> Learner::LoadGames() {
  std::vector<std::uint64_t> stored =
      store_.Load([&](std::uint64_t ticket) { return loop_.Wants(ticket); },
                  [&](GameRecord&& game) { loop_.Add(LessonsOf(game)); });
  std::vector<std::uint64_t> lost = store_.lost_tickets();
  const std::unordered_set<std::uint64_t> elsewhere(stored.begin(), stored.end());
  std::erase_if(lost, [&](std::uint64_t ticket) { return elsewhere.contains(ticket); });
  if (lost.empty()) return stored;
  std::vector<std::uint64_t> again = lost;
  std::erase_if(again, [&](std::uint64_t ticket) { return ticket < loop_.next_ticket(); });
  log::Warn("games were lost in damaged segments", "tickets", TicketsText(std::move(lost)),
            "played_again", TicketsText(std::move(again)));
  return stored;
}

// Untrained weights, version 1, are not met: nobody plays by them.
std::uint32_t Learner::DrawPast() {
  const auto newest = static_cast<std::uint32_t>(loop_.progress().iteration) + 1;
  return league_.DrawPast(/*oldest=*/2, newest, past_rng_);
}

// Empty: there are none.
std::vector<std::uint8_t> Learner::LoadWeights(std::uint32_t version) {
  try {
    if (version < kFirstFileVersion) return ReadFileBytes(WeightsPath(folder_, version));
    const std::size_t player = version - kFirstFileVersion;
    if (player >= games_.players().size()) return {};
    WeightsSnapshot snapshot =
        *LoadSnapshot(WeightsOfPlayer(folder_, games_.players()[player]).string());
    snapshot.version = version;
    return Serialize(snapshot);
  } catch (const Error& error) {
    if (log_budget_.Spend()) {
      log::Warn("weights cannot be served", "version", version, "reason", error.what());
    }
    return {};
  }
}

// It may have been published, and be later than the checkpoint that the run goes on from.
std::uint32_t Learner::NewestSavedVersion() const {
  auto version = static_cast<std::uint32_t>(loop_.progress().iteration) + 1;
  while (std::filesystem::exists(WeightsPath(folder_, version + 1))) ++version;
  return version;
}

void Learner::ServeActors(const LearnerSettings& settings, std::span<const std::uint64_t> known) {
  std::optional<std::filesystem::path> keys;
  if (!settings.keys.empty()) keys = settings.keys;
  SessionServerSettings server;
  server.run_id = RunIdOf(settings.folder);
  server.self_play = config_.self_play;
  server.newest_version = NewestSavedVersion();
  server.newest_weights_only = config_.training.sequential;
  server.games_always_wanted = config_.training.continuous;
  server.games_wanted = [this] { return loop_.GamesWanted(); };
  server.load_weights = [this](std::uint32_t version) { return LoadWeights(version); };
  if (std::ranges::find(games_.players(), PlayerSpec::Weights::kPast, &Player::weights) !=
      games_.players().end()) {
    server.draw_past = [this] { return DrawPast(); };
  }
  server_ = std::make_unique<SessionServer>(
      server, ListenZmq({settings.listen, keys, settings.insecure}),
      [this](const std::vector<GameRecord>& games, std::vector<Lessons> lessons) {
        Append(games, std::move(lessons));
      },
      known, loop_.next_ticket());
  log::Info("listening", "endpoint", server_->endpoint(), "keys", keys ? "yes" : "no");
}

// On the store thread, which makes all HDF5 calls.
void Learner::Append(const std::vector<GameRecord>& games, std::vector<Lessons> lessons) {
  store_.Append(games);
  if (merge_wanted_.exchange(false) || store_.small_segment_count() >= kManySegments) {
    store_.Merge();
    TrimStore();
  }
  for (Lessons& game : lessons) loop_.Add(std::move(game));
}

void Learner::TrimStore() {
  const auto bytes = static_cast<std::uint64_t>(config_.training.replay_mb) << 20;
  if (bytes == 0) return;
  const std::uint64_t oldest = oldest_ticket_needed_;
  const std::size_t segments =
      store_.Trim(bytes, [oldest](std::uint64_t ticket) { return ticket >= oldest; });
  if (segments > 0) log::Info("removed games of long ago", "segments", segments);
}

// By any thread.
RunView Learner::View() const {
  RunView view{.run = name_, .started_unix_s = started_};
  view.intake = server_->statistics();
  view.status = StatusOf(loop_.progress(), view.intake, config_.training.iterations);
  view.last_iteration = history_.last();
  return view;
}

void Learner::ServeHttp(const HttpServerSettings& settings) {
  http_.emplace(
      DashboardRoutes({.view = [this] { return View(); },
                       .iterations = [this](int after) { return history_.CsvAfter(after); },
                       .exams = [this](int after) { return exams_.CsvAfter(after); },
                       .ratings = [this] { return league_.RatingsCsv(); }}),
      settings);
  const HttpAddress& address = http_->address();
  const int asked = settings.address.port;
  const bool taken = asked != 0 && address.port != asked;
  log::Info("serving the dashboard", "url", address.url());
  display_.ShowLine(
      StrCat("dashboard: ", address.url(), taken ? StrCat(" (port ", asked, " is taken)") : ""));
}

}  // namespace powderkeg
