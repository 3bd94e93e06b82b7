#include "common/torch/torch_evaluator.h"

#include <algorithm>
#include <vector>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/torch/inference_network.h"
#include "common/torch/torch_runtime.h"
#ifdef POWDERKEG_TORCH_CUDA
#include "common/torch/cuda_evaluator.h"
#endif

namespace powderkeg {
namespace {

// Larger batches are evaluated in slices: the activations then stay in the cache.
constexpr std::size_t kSlice = 32;

void Validate(const TorchEvaluatorSettings& settings) {
  if (settings.precision == Precision::kInt8) {
    throw Error("torch evaluator: precision int8, expected fp32, bf16 or fp16");
  }
  if (settings.device == TorchDevice::kCpu && settings.precision == Precision::kFp16) {
    throw Error("torch evaluator: precision fp16 on the cpu, expected fp32 or bf16");
  }
  if (settings.device == TorchDevice::kCpu) return;
  const auto devices = IsCudaAvailable() ? static_cast<int>(torch::cuda::device_count()) : 0;
  if (settings.cuda_index < 0 || settings.cuda_index >= devices) {
    throw Error(
        StrCat("torch evaluator: CUDA device ", settings.cuda_index, " of ", devices, " devices"));
  }
}

class CpuEvaluator final : public Evaluator {
 public:
  CpuEvaluator(const WeightsSnapshot& snapshot, Precision precision)
      : precision_(precision),
        network_(Fold(snapshot), torch::TensorOptions().dtype(ScalarTypeOf(precision))),
        planes_(torch::empty({kSlice, kPlaneCount, kBoardSize, kBoardSize})) {}

  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    CHECK(positions.size() == evaluations.size());
    const c10::InferenceMode inference;
    at::set_num_threads(1);
    for (std::size_t first = 0; first < positions.size(); first += kSlice) {
      const std::size_t count = std::min(kSlice, positions.size() - first);
      EvaluateSlice(settings, positions.subspan(first, count), evaluations.subspan(first, count));
    }
  }

  [[nodiscard]] std::string name() const override {
    return StrCat("torch cpu ", NameOf(precision_));
  }

 private:
  void EvaluateSlice(const GameSettings& settings, std::span<const Position> positions,
                     std::span<Evaluation> evaluations) {
    float* next = planes_.data_ptr<float>();
    for (const Position& position : positions) {
      EncodePlanes(settings, position, std::span<float, kPlanesSize>(next, kPlanesSize));
      next += kPlanesSize;
    }
    const auto count = static_cast<std::int64_t>(positions.size());
    TakeAnswers(network_.Forward(planes_.narrow(0, 0, count)), evaluations);
  }

  Precision precision_;
  InferenceNetwork network_;
  torch::Tensor planes_;  // kSlice positions
};

}  // namespace

bool IsCudaAvailable() {
#ifdef POWDERKEG_TORCH_CUDA
  return torch::cuda::is_available();
#else
  return false;
#endif
}

std::unique_ptr<Evaluator> MakeTorchEvaluator(const Snapshot& snapshot,
                                              const TorchEvaluatorSettings& settings) {
  Validate(settings);
  Validate(*snapshot);
  InitialiseTorch(/*threads=*/1);
#ifdef POWDERKEG_TORCH_CUDA
  if (settings.device == TorchDevice::kCuda) return MakeCudaEvaluator(*snapshot, settings);
#endif
  return std::make_unique<CpuEvaluator>(*snapshot, settings.precision);
}

}  // namespace powderkeg
