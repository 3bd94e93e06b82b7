#include "tests/bench/bench_selfplay.h"

#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "actors/evaluator_choice.h"
#include "actors/play/game_loop.h"
#include "actors/selfplay/outbox.h"
#include "actors/selfplay/ticket_book.h"
#include "actors/selfplay/ticket_host.h"
#include "common/base/check.h"
#include "common/model/evaluation_cache.h"
#include "common/model/model_name.h"
#include "common/model/weights_snapshot.h"
#include "tests/bench/cpu_time.h"
#include "tests/learner/record_support.h"

namespace powderkeg {
namespace {

constexpr std::uint64_t kTickets = 10'000;     // more than are played
constexpr std::uint64_t kFinishedBefore = 40;  // games, so that those in play are in all stages
constexpr double kSettlingSeconds = 1;
constexpr double kMeasuredSeconds = 3;

Welcome WelcomeTo250Simulations() {
  Welcome welcome;
  welcome.self_play.search.simulations = 250;
  return welcome;
}

// An actor without a learner: one loop and what it needs.
class Loop {
 public:
  Loop()
      : outbox_(spool_.path(), /*limit_bytes=*/std::size_t{1} << 30),
        host_(
            welcome_, tickets_, outbox_, [] {}, [](std::uint32_t) { return std::nullopt; }),
        games_(host_, host_.settings(), welcome_.self_play.games_in_flight) {
    std::vector<std::uint64_t> tickets(kTickets);
    std::iota(tickets.begin(), tickets.end(), std::uint64_t{0});
    tickets_.Grant(tickets);
  }

  // Answers all games from now on.
  void SetModel(std::shared_ptr<Evaluator> evaluator) {
    const Model model{.evaluator = std::move(evaluator)};
    host_.SetNewest(model);
    games_.SetModel(model);
  }

  void PlayUntilFinished(std::uint64_t games) {
    while (games_.metrics().games < games) CHECK(games_.RunRound());
  }

  // The CPU time that it took.
  double PlayFor(double seconds) {
    const double start = ThreadCpuSeconds();
    double elapsed = 0;
    for (; elapsed < seconds; elapsed = ThreadCpuSeconds() - start) CHECK(games_.RunRound());
    return elapsed;
  }

  // Of all moves made so far.
  [[nodiscard]] std::uint64_t Simulations() const {
    std::uint64_t simulations = games_.metrics().simulations;
    for (int slot = 0; slot < welcome_.self_play.games_in_flight; ++slot) {
      const Game* const game = games_.running_game(slot);
      for (AgentId seat = 0; game != nullptr && seat < kAgentCount; ++seat) {
        simulations += game->statistics(seat).simulations;
      }
    }
    return simulations;
  }

 private:
  const Welcome welcome_ = WelcomeTo250Simulations();
  const TemporaryFolder spool_;
  TicketBook tickets_;
  Outbox outbox_;
  TicketHost host_;
  GameLoop games_;
};

// Watches another evaluator at work.
class Watched final : public Evaluator {
 public:
  explicit Watched(std::unique_ptr<Evaluator> evaluator) : evaluator_(std::move(evaluator)) {}

  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    const double start = ThreadCpuSeconds();
    evaluator_->Evaluate(settings, positions, evaluations);
    seconds += ThreadCpuSeconds() - start;
    ++batches;
  }
  [[nodiscard]] std::string name() const override { return evaluator_->name(); }

  double seconds = 0;
  double batches = 0;

 private:
  std::unique_ptr<Evaluator> evaluator_;
};

std::vector<BenchFigure> MeasureUniform(Loop& loop) {
  const std::uint64_t before = loop.Simulations();
  const double seconds = loop.PlayFor(kSettlingSeconds);
  const auto simulations = static_cast<double>(loop.Simulations() - before);
  return {{"uniform.simulations", simulations / seconds, "simulations/s"}};
}

std::vector<BenchFigure> MeasureNetwork(const std::string& network, Loop& loop) {
  const EvaluatorChoice choice;
  auto watched = std::make_unique<Watched>(
      MakeEvaluator({.evaluator = "onednn", .cache_mb = 0}, LoadModel("untrained:" + network)));
  const Watched& evaluator = *watched;
  const auto cache = std::make_shared<EvaluationCache>(
      std::move(watched), static_cast<std::size_t>(choice.cache_mb) << 20);
  loop.SetModel(cache);
  loop.PlayFor(kSettlingSeconds);

  const auto simulations_before = loop.Simulations();
  const auto hits_before = cache->hits();
  const auto misses_before = cache->misses();
  const double batches_before = evaluator.batches;
  const double network_before = evaluator.seconds;
  const double seconds = loop.PlayFor(kMeasuredSeconds);
  const auto simulations = static_cast<double>(loop.Simulations() - simulations_before);
  const auto hits = static_cast<double>(cache->hits() - hits_before);
  const auto misses = static_cast<double>(cache->misses() - misses_before);
  const double in_network = evaluator.seconds - network_before;
  const std::string name = network + ".";
  return {{name + "simulations", simulations / seconds, "simulations/s"},
          {name + "evaluations", misses / seconds, "evaluations/s"},
          {name + "from_memory", 100 * hits / (hits + misses), "% of questions"},
          {name + "batch", misses / (evaluator.batches - batches_before), "positions"},
          {name + "in_network", 100 * in_network / seconds, "% of the time"},
          {name + "rest", 1e9 * (seconds - in_network) / simulations, "ns a simulation"}};
}

}  // namespace

std::vector<BenchFigure> BenchSelfPlay() {
  Loop loop;
  loop.SetModel(std::make_shared<UniformEvaluator>());
  loop.PlayUntilFinished(kFinishedBefore);
  std::vector<BenchFigure> figures = MeasureUniform(loop);
  for (const char* const network : {"small", "paper"}) {
    const auto measured = MeasureNetwork(network, loop);
    figures.insert(figures.end(), measured.begin(), measured.end());
  }
  return figures;
}

}  // namespace powderkeg
