#include "common/onednn/onednn_evaluator.h"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/onednn/onednn_program.h"

namespace powderkeg {
namespace {

using onednn::JoinedNetwork;
using onednn::Program;

// Positions per program run: the activations of more would leave the cache.
constexpr std::size_t kSlice = 8;

// oneDNN 2.6 sets itself up when the first primitives are made, and where several threads do that
// at once it finds, in some starts of thousands, that it has no reorder.
std::mutex making_primitives;

// What make() makes of oneDNN's parts, by one thread at a time. Throws Error.
template <typename Make>
auto MakeAlone(const Make& make) {
  const std::lock_guard lock(making_primitives);
  try {
    return make();
  } catch (const dnnl::error& error) {
    throw Error(StrCat("oneDNN: ", error.what()));
  }
}

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

void Activate(std::span<float> values, float leaky_slope) {
  for (float& value : values) value = value > 0.0F ? value : value * leaky_slope;
}

float Dot(std::span<const float> a, std::span<const float> b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0F);
}

bool Has(dnnl::cpu_isa isa) {
  const auto needed = static_cast<unsigned>(isa);
  return (static_cast<unsigned>(dnnl::get_effective_cpu_isa()) & needed) == needed;
}

// What a head makes of one cell: too little for a primitive.
class CellLayer {
 public:
  CellLayer(LinearLayer layer, float leaky_slope)
      : layer_(std::move(layer)),
        leaky_slope_(leaky_slope),
        hidden_(static_cast<std::size_t>(layer_.outputs)) {}

  // The activated outputs, good until the next call. `tower`: [cell][channel].
  [[nodiscard]] std::span<const float> Run(std::span<const float> tower, Cell cell) {
    const auto channels = static_cast<std::size_t>(layer_.inputs);
    const auto input = tower.subspan(static_cast<std::size_t>(cell) * channels, channels);
    const std::span<const float> weights(layer_.weights);
    for (std::size_t i = 0; i < hidden_.size(); ++i) {
      hidden_[i] = layer_.bias[i] + Dot(weights.subspan(i * channels, channels), input);
    }
    Activate(hidden_, leaky_slope_);
    return hidden_;
  }

 private:
  LinearLayer layer_;
  float leaky_slope_;
  std::vector<float> hidden_;
};

class OwnHead {
 public:
  explicit OwnHead(const FoldedNetwork& network)
      : hidden_(network.own_hidden, network.leaky_slope),
        output_weights_(network.own_value.weights) {
    output_weights_.insert(output_weights_.end(), network.own_policy.weights.begin(),
                           network.own_policy.weights.end());
  }

  // Adds its part to `head` ([value_hidden + 6], before activations). `tower`: [cell][channel].
  void Add(std::span<const float> tower, const Position& position, std::span<float> head) {
    const Cell cell = MarkedCell(position, 0);
    if (cell == kNoCell) return;
    const std::span<const float> hidden = hidden_.Run(tower, cell);
    const std::span<const float> weights(output_weights_);
    for (std::size_t i = 0; i < head.size(); ++i) {
      head[i] += Dot(weights.subspan(i * hidden.size(), hidden.size()), hidden);
    }
  }

 private:
  CellLayer hidden_;
  std::vector<float> output_weights_;  // [value_hidden + 6][own_hidden]
};

class OthersHead {
 public:
  explicit OthersHead(const FoldedNetwork& network)
      : hidden_(network.others_hidden, network.leaky_slope), output_(network.others_policy) {}

  // `tower`: [cell][channel].
  void Run(std::span<const float> tower, const Position& position, Evaluation& evaluation) {
    for (int after = 1; after < kAgentCount; ++after) {
      auto& other = evaluation.others[static_cast<std::size_t>(after) - 1];
      other = {};
      const Cell cell = MarkedCell(position, after);
      if (cell == kNoCell) continue;
      const std::span<const float> hidden = hidden_.Run(tower, cell);
      const std::span<const float> weights(output_.weights);
      std::array<float, kActionCount> policy;
      for (std::size_t i = 0; i < policy.size(); ++i) {
        policy[i] =
            output_.bias[i] + Dot(weights.subspan(i * hidden.size(), hidden.size()), hidden);
      }
      Softmax(policy, policy);
      std::ranges::transform(policy, other.begin(), InWholes);
    }
  }

 private:
  CellLayer hidden_;
  LinearLayer output_;
};

class OnednnEvaluator final : public Evaluator {
 public:
  OnednnEvaluator(const FoldedNetwork& network, Precision precision)
      : precision_(precision),
        network_(onednn::JoinHeads(network)),
        value_output_(network.value_output),
        engine_(dnnl::engine::kind::cpu, 0) {
    if (network.own_hidden.outputs > 0) own_head_.emplace(network);
    if (network.others_hidden.outputs > 0) others_head_.emplace(network);
    if (precision == Precision::kInt8) {
      const OneThread one_thread;
      quantized_ = onednn::Quantize(network_, onednn::LargestActivations(network_, engine_));
    }
  }

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
    const auto width = static_cast<std::size_t>(network_.head.outputs);
    const std::size_t tower_size = program.tower().size() / positions.size();
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const std::span<float> head = program.output().subspan(i * width, width);
      const std::span<const float> tower = program.tower().subspan(i * tower_size, tower_size);
      if (own_head_) own_head_->Add(tower, positions[i], head);
      if (others_head_) others_head_->Run(tower, positions[i], evaluations[i]);
      Finish(head, evaluations[i]);
    }
  }

  // The last layers of one position, from its part of the program's output.
  void Finish(std::span<float> head, Evaluation& evaluation) const {
    Softmax(head.last<kActionCount>(), evaluation.policy);
    const std::span<float> hidden = head.first(head.size() - kActionCount);
    Activate(hidden, network_.leaky_slope);
    evaluation.value = std::tanh(value_output_.bias[0] + Dot(value_output_.weights, hidden));
  }

  Program& ProgramFor(std::size_t count) {
    std::unique_ptr<Program>& program = programs_[count - 1];
    const auto positions = static_cast<int>(count);
    const bool bf16 = precision_ != Precision::kFp32 && HasBf16();
    const auto type = bf16 ? dnnl::memory::data_type::bf16 : dnnl::memory::data_type::f32;
    if (!program) {
      program = MakeAlone([&] {
        return quantized_ ? std::make_unique<Program>(*quantized_, positions, type, engine_)
                          : std::make_unique<Program>(network_, positions, type, engine_);
      });
    }
    return *program;
  }

  Precision precision_;
  JoinedNetwork network_;
  LinearLayer value_output_;
  std::optional<OwnHead> own_head_;
  std::optional<OthersHead> others_head_;
  dnnl::engine engine_;
  std::optional<onednn::QuantizedNetwork> quantized_;      // for int8
  std::array<std::unique_ptr<Program>, kSlice> programs_;  // [positions - 1], made when needed
};

}  // namespace

bool HasBf16() { return Has(dnnl::cpu_isa::avx512_core_bf16); }

bool HasInt8() { return Has(dnnl::cpu_isa::avx512_core_vnni) || Has(dnnl::cpu_isa::avx2_vnni); }

std::unique_ptr<Evaluator> MakeOnednnEvaluator(const Snapshot& snapshot, Precision precision) {
  if (precision == Precision::kFp16) {
    throw Error("onednn evaluator: precision fp16, expected fp32 or bf16");
  }
  Validate(*snapshot);
  if (precision == Precision::kInt8 && !HasInt8()) precision = Precision::kBf16;
  if (precision == Precision::kBf16 && !HasBf16()) precision = Precision::kFp32;
  return MakeAlone([&] { return std::make_unique<OnednnEvaluator>(Fold(*snapshot), precision); });
}

}  // namespace powderkeg
