#include "common/onednn/onednn_evaluator.h"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/onednn/onednn_program.h"

namespace powderkeg {
namespace {

using onednn::JoinedNetwork;
using onednn::Program;

// Positions per program run: the activations of more would leave the cache.
constexpr std::size_t kSlice = 8;

// oneDNN takes the number of OpenMP threads of the calling thread when a primitive is made and when
// it runs.
class OneThread {
 public:
  OneThread() : threads_before_(omp_get_max_threads()) { omp_set_num_threads(1); }
  ~OneThread() { omp_set_num_threads(threads_before_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int threads_before_;
};

void Softmax(std::span<const float, kActionCount> logits,
             std::array<float, kActionCount>& probabilities) {
  const float largest = *std::ranges::max_element(logits);
  float sum = 0.0F;
  for (std::size_t i = 0; i < kActionCount; ++i) {
    probabilities[i] = std::exp(logits[i] - largest);
    sum += probabilities[i];
  }
  for (float& probability : probabilities) probability /= sum;
}

class OnednnEvaluator final : public Evaluator {
 public:
  OnednnEvaluator(const FoldedNetwork& network, Precision precision)
      : precision_(precision),
        network_(onednn::JoinHeads(network)),
        value_output_(network.value_output),
        engine_(dnnl::engine::kind::cpu, 0) {}

  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    CHECK(positions.size() == evaluations.size());
    const OneThread one_thread;
    for (std::size_t first = 0; first < positions.size(); first += kSlice) {
      const std::size_t count = std::min(kSlice, positions.size() - first);
      EvaluateSlice(settings, positions.subspan(first, count), evaluations.subspan(first, count));
    }
  }

  [[nodiscard]] std::string name() const override { return StrCat("onednn ", NameOf(precision_)); }

 private:
  void EvaluateSlice(const GameSettings& settings, std::span<const Position> positions,
                     std::span<Evaluation> evaluations) {
    Program& program = ProgramFor(positions.size());
    float* planes = program.input().data();
    for (const Position& position : positions) {
      EncodePlanes(settings, position, std::span<float, kPlanesSize>(planes, kPlanesSize));
      planes += kPlanesSize;
    }
    program.Run();
    std::span<const float> output = program.output();
    const auto width = static_cast<std::size_t>(network_.head.outputs);
    for (Evaluation& evaluation : evaluations) {
      Finish(output.first(width), evaluation);
      output = output.subspan(width);
    }
  }

  // The last layers of one position, from its part of the program's output.
  void Finish(std::span<const float> output, Evaluation& evaluation) const {
    Softmax(output.last<kActionCount>(), evaluation.policy);
    float sum = value_output_.bias[0];
    for (std::size_t i = 0; i < value_output_.weights.size(); ++i) {
      const float hidden = output[i] > 0.0F ? output[i] : output[i] * network_.leaky_slope;
      sum += hidden * value_output_.weights[i];
    }
    evaluation.value = std::tanh(sum);
  }

  Program& ProgramFor(std::size_t count) {
    std::unique_ptr<Program>& program = programs_[count - 1];
    if (!program) {
      const auto type = precision_ == Precision::kBf16 ? dnnl::memory::data_type::bf16
                                                       : dnnl::memory::data_type::f32;
      program = std::make_unique<Program>(network_, static_cast<int>(count), type, engine_);
    }
    return *program;
  }

  Precision precision_;
  JoinedNetwork network_;
  LinearLayer value_output_;
  dnnl::engine engine_;
  std::array<std::unique_ptr<Program>, kSlice> programs_;  // [positions - 1], made when needed
};

}  // namespace

bool HasBf16() {
  const auto needed = static_cast<unsigned>(dnnl::cpu_isa::avx512_core_bf16);
  return (static_cast<unsigned>(dnnl::get_effective_cpu_isa()) & needed) == needed;
}

std::unique_ptr<Evaluator> MakeOnednnEvaluator(const Snapshot& snapshot, Precision precision) {
  if (precision == Precision::kFp16) {
    throw Error("onednn evaluator: precision fp16, expected fp32 or bf16");
  }
  Validate(*snapshot);
  const bool bf16 = precision == Precision::kBf16 && HasBf16();
  return std::make_unique<OnednnEvaluator>(Fold(*snapshot),
                                           bf16 ? Precision::kBf16 : Precision::kFp32);
}

}  // namespace powderkeg
