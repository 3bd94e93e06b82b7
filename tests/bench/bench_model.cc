#include "tests/bench/bench_model.h"

#include <array>
#include <functional>
#include <memory>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/onednn/onednn_evaluator.h"
#include "tests/bench/cpu_time.h"
#include "tests/model/positions.h"

namespace powderkeg {
namespace {

constexpr int kPositions = 256;
constexpr double kMeasuredSeconds = 0.2;

// Items per second of CPU time of work(), which handles `items` a call; the first call is not
// counted.
double Rate(double items, const std::function<void()>& work) {
  work();
  const double start = ThreadCpuSeconds();
  double calls = 0;
  double elapsed = 0;
  for (; elapsed < kMeasuredSeconds; elapsed = ThreadCpuSeconds() - start) {
    work();
    ++calls;
  }
  return items * calls / elapsed;
}

double EvaluationRate(Evaluator& evaluator, std::span<const Position> positions,
                      std::size_t batch) {
  std::vector<Evaluation> evaluations(batch);
  std::size_t first = 0;
  return Rate(static_cast<double>(batch), [&] {
    evaluator.Evaluate(GameSettings{}, positions.subspan(first, batch), evaluations);
    first = (first + batch) % (positions.size() - batch + 1);
  });
}

double PlanesRate(std::span<const Position> positions) {
  auto planes = std::make_unique<std::array<float, kPlanesSize>>();
  return Rate(static_cast<double>(positions.size()), [&] {
    for (const Position& position : positions) EncodePlanes(GameSettings{}, position, *planes);
  });
}

}  // namespace

std::vector<BenchFigure> BenchModel() {
  const std::vector<State> states = PlayedStates(kPositions, /*seed=*/1);
  const std::vector<Position> positions = PositionsOf(states);
  std::vector<BenchFigure> figures;
  figures.push_back({"planes", PlanesRate(positions), "positions/s"});
  for (const char* const network : {"paper", "small"}) {
    const Snapshot snapshot = RandomWeights(NetworkByName(network), /*seed=*/1);
    for (const Precision precision : {Precision::kFp32, Precision::kBf16, Precision::kInt8}) {
      const auto evaluator = MakeOnednnEvaluator(snapshot, precision);
      for (const std::size_t batch : {1U, 8U, 32U, 128U}) {
        figures.push_back({StrCat(network, ", ", evaluator->name(), ", batch ", batch),
                           EvaluationRate(*evaluator, positions, batch), "evaluations/s"});
      }
    }
  }
  return figures;
}

}  // namespace powderkeg
