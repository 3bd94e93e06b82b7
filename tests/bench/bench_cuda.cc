#include "tests/bench/bench_cuda.h"

#include <chrono>
#include <vector>

#include "common/base/check.h"
#include "common/torch/torch_evaluator.h"
#include "tests/model/positions.h"

namespace powderkeg {
namespace {

constexpr int kPositions = 4096;
constexpr double kMeasuredSeconds = 1;

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The first call, which prepares the evaluator for this size, is not counted.
double EvaluationRate(Evaluator& evaluator, std::span<const Position> positions) {
  std::vector<Evaluation> evaluations(positions.size());
  evaluator.Evaluate(GameSettings{}, positions, evaluations);
  const double start = Seconds();
  double elapsed = 0;
  double calls = 0;
  for (; elapsed < kMeasuredSeconds; elapsed = Seconds() - start) {
    evaluator.Evaluate(GameSettings{}, positions, evaluations);
    ++calls;
  }
  return static_cast<double>(positions.size()) * calls / elapsed;
}

}  // namespace

std::vector<BenchFigure> BenchCuda() {
  std::vector<BenchFigure> figures;
  if (!IsCudaAvailable()) return figures;
  const std::vector<State> states = PlayedStates(kPositions, /*seed=*/1);
  const std::vector<Position> positions = PositionsOf(states);
  for (const char* const network : {"paper", "small"}) {
    const auto evaluator =
        MakeTorchEvaluator(RandomWeights(NetworkByName(network), /*seed=*/1),
                           {.device = TorchDevice::kCuda, .precision = Precision::kFp16});
    for (const std::size_t batch : {64U, 256U, 1024U, 4096U}) {
      figures.push_back({StrCat(network, ", ", evaluator->name(), ", batch ", batch),
                         EvaluationRate(*evaluator, std::span(positions).first(batch)),
                         "evaluations/s"});
    }
  }
  return figures;
}

}  // namespace powderkeg
