#include "common/torch/cuda_evaluator.h"

#include <algorithm>
#include <array>
#include <list>
#include <mutex>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/torch/device_planes.h"
#include "common/torch/inference_network.h"
#include "common/torch/torch_headers.h"

namespace powderkeg {
namespace {

// Sizes that batches are padded to: at most a third of a batch is padding, but for small ones.
constexpr std::array<std::size_t, 15> kSizes = {8,   16,  32,  64,   96,   128,  192, 256,
                                                384, 512, 768, 1024, 1536, 2048, 4096};
// Runs before a capture, in which libraries choose their kernels.
constexpr int kWarmUps = 3;

// While one thread captures, no other may allocate on the device.
std::mutex& CaptureMutex() {
  static std::mutex mutex;
  return mutex;
}

void BeginCapture(at::cuda::CUDAGraph& graph) {
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 1)
  graph.capture_begin({0, 0}, cudaStreamCaptureModeThreadLocal);
#else
  graph.capture_begin();
#endif
}

// One batch size: its buffers on both sides, and what is to be done with them.
struct CapturedBatch {
  std::size_t size;
  torch::Tensor host_counts;   // int8 [size, 24, 11, 11], pinned
  torch::Tensor host_answers;  // fp32 [size, 7], pinned
  torch::Tensor counts;        // on the device
  at::cuda::CUDAGraph graph;
};

class CudaEvaluator final : public Evaluator {
 public:
  CudaEvaluator(const WeightsSnapshot& snapshot, const TorchEvaluatorSettings& settings)
      : precision_(settings.precision),
        device_(torch::kCUDA, static_cast<torch::DeviceIndex>(settings.cuda_index)),
        stream_(c10::cuda::getStreamFromPool(/*isHighPriority=*/false, device_.index())),
        network_(Fold(snapshot),
                 torch::TensorOptions().dtype(ScalarTypeOf(precision_)).device(device_)),
        scales_(torch::zeros({kPlaneCount + 1}, torch::TensorOptions().device(device_))) {
    c10::cuda::getDefaultCUDAStream(device_.index()).synchronize();
  }

  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    CHECK(positions.size() == evaluations.size());
    const c10::InferenceMode inference;
    const c10::cuda::CUDAStreamGuard on_own_stream(stream_);
    SetScales(settings);
    for (std::size_t first = 0; first < positions.size(); first += kSizes.back()) {
      const std::size_t count = std::min(kSizes.back(), positions.size() - first);
      EvaluateSlice(positions.subspan(first, count), evaluations.subspan(first, count));
    }
  }

  [[nodiscard]] std::string name() const override {
    return StrCat("torch cuda ", NameOf(precision_));
  }

 private:
  // The graphs read the tensor: only its content changes.
  void SetScales(const GameSettings& settings) {
    if (settings.max_steps == max_steps_) return;
    const auto scales = PlaneScales(settings);
    scales_.copy_(torch::tensor(std::vector<float>(scales.begin(), scales.end())));
    max_steps_ = settings.max_steps;
  }

  void EvaluateSlice(std::span<const Position> positions, std::span<Evaluation> evaluations) {
    CapturedBatch& batch = BatchFor(positions.size());
    auto* counts = batch.host_counts.data_ptr<std::int8_t>();
    for (const Position& position : positions) {
      EncodePlaneCounts(position,
                        std::span<std::int8_t, kPlaneCountsSize>(counts, kPlaneCountsSize));
      counts += kPlaneCountsSize;
    }
    batch.graph.replay();
    stream_.synchronize();
    TakeAnswers(batch.host_answers, evaluations);
  }

  // The smallest captured batch that has room; captures it the first time.
  CapturedBatch& BatchFor(std::size_t count) {
    const std::size_t size = *std::ranges::lower_bound(kSizes, count);
    const auto found = std::ranges::find(batches_, size, &CapturedBatch::size);
    return found != batches_.end() ? *found : Capture(size);
  }

  CapturedBatch& Capture(std::size_t size) {
    const std::lock_guard lock(CaptureMutex());
    CapturedBatch& batch = batches_.emplace_back();
    batch.size = size;
    const auto rows = static_cast<std::int64_t>(size);
    const auto pinned = torch::TensorOptions().pinned_memory(true);
    batch.host_counts =
        torch::zeros({rows, kPlaneCount + 1, kBoardSize, kBoardSize}, pinned.dtype(torch::kInt8));
    batch.host_answers = torch::zeros({rows, kAnswerSize}, pinned);
    batch.counts = torch::zeros_like(batch.host_counts, torch::TensorOptions().device(device_));
    for (int i = 0; i < kWarmUps; ++i) Run(batch);
    stream_.synchronize();
    BeginCapture(batch.graph);
    Run(batch);
    batch.graph.capture_end();
    return batch;
  }

  void Run(CapturedBatch& batch) {
    batch.counts.copy_(batch.host_counts, /*non_blocking=*/true);
    const torch::Tensor answers = network_.Forward(ExpandPlanes(batch.counts, scales_));
    batch.host_answers.copy_(answers, /*non_blocking=*/true);
  }

  Precision precision_;
  torch::Device device_;
  c10::cuda::CUDAStream stream_;
  InferenceNetwork network_;
  torch::Tensor scales_;              // fp32, on the device
  int max_steps_ = -1;                // that scales_ holds for
  std::list<CapturedBatch> batches_;  // graphs cannot move
};

}  // namespace

std::unique_ptr<Evaluator> MakeCudaEvaluator(const WeightsSnapshot& snapshot,
                                             const TorchEvaluatorSettings& settings) {
  return std::make_unique<CudaEvaluator>(snapshot, settings);
}

}  // namespace powderkeg
