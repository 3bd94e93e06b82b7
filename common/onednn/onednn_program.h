#pragma once

// A network compiled by oneDNN for a fixed number of positions. Internal to common/onednn.

#include <cstddef>
#include <functional>
#include <memory>
#include <oneapi/dnnl/dnnl.hpp>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/onednn/joined_network.h"
#include "common/onednn/quantization.h"

namespace powderkeg::onednn {

// Memory for the activations of a program. A buffer is reused as soon as it was released, which
// keeps the working set in the cache.
class Arena {
 public:
  // A memory object without memory until Commit.
  [[nodiscard]] dnnl::memory Acquire(const dnnl::memory::desc& desc, const dnnl::engine& engine);
  // The memory object stays valid; its content may be overwritten by later steps.
  void Release(const dnnl::memory& memory);
  // Gives every acquired object its memory. Call once, at the end.
  void Commit();

 private:
  struct Buffer {
    std::size_t size = 0;
    bool in_use = false;
    std::vector<dnnl::memory> users;
    std::unique_ptr<std::byte[]> bytes;
  };

  std::vector<Buffer> buffers_;
};

// One thread.
class Program {
 public:
  // `type` is that of weights and activations: f32 or bf16.
  Program(const JoinedNetwork& network, int positions, dnnl::memory::data_type type,
          const dnnl::engine& engine);
  // In 8-bit integers, the heads' linear layer in `type`.
  Program(const QuantizedNetwork& network, int positions, dnnl::memory::data_type type,
          const dnnl::engine& engine);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  // [positions][plane][cell], to be written before Run.
  [[nodiscard]] std::span<float> input() { return input_; }
  void Run();
  // The same; shows what each convolution leaves, in their order, to observe(number, activations).
  using Observer = std::function<void(std::size_t, const dnnl::memory&)>;
  void Run(const Observer& observe);
  // [positions][value_hidden + 6] after Run; the caller may work in it.
  [[nodiscard]] std::span<float> output() { return output_; }

  // [positions][cell][channel], what comes out of the last block, after Run; empty unless
  // needs_tower.
  [[nodiscard]] std::span<const float> tower() const { return tower_; }

 private:
  struct Step {
    std::function<void()> run;
    dnnl::memory convolved;  // what a convolution leaves; empty for other steps
  };

  // `quantized`: null where weights and activations are floats.
  Program(const JoinedNetwork& network, const QuantizedNetwork* quantized, int positions,
          dnnl::memory::data_type type, const dnnl::engine& engine);
  [[nodiscard]] dnnl::memory AddBlock(const FoldedBlock& block, const dnnl::memory& input);
  // A convolution, then the sum with `residual` (if not null), then the activation. The result
  // takes the residual's place.
  enum class Activation { kNone, kLeaky };
  [[nodiscard]] dnnl::memory AddConvolution(const FoldedConvolution& layer,
                                            const dnnl::memory& source, Activation activation,
                                            const dnnl::memory* residual = nullptr);
  // The same by our own kernel.
  [[nodiscard]] dnnl::memory AddDepthwise(const FoldedConvolution& layer,
                                          const dnnl::memory& source, Activation activation);
  // Into output(). `source` has as many values per position as the layer has inputs.
  void AddLinear(const LinearLayer& layer, const dnnl::memory& source);
  // Copies the tower's result to tower().
  void AddTowerCopy(const dnnl::memory& source);
  // `scales`: what the values are multiplied by, all of them by one or each channel by its own.
  void AddReorder(const dnnl::memory& from, const dnnl::memory& to,
                  const std::vector<float>& scales = {});
  // `source` in the form `desc`: itself, or a copy made by a reorder step.
  [[nodiscard]] dnnl::memory Converted(const dnnl::memory& source, const dnnl::memory::desc& desc);
  // Releases `copy` if Converted made it from `source`.
  void ReleaseCopy(const dnnl::memory& copy, const dnnl::memory& source);
  // Constant values in the form `desc`, converted once from the form `plain`.
  [[nodiscard]] dnnl::memory Constant(const std::vector<float>& values,
                                      const dnnl::memory::desc& plain,
                                      const dnnl::memory::desc& desc);
  void AddStep(const dnnl::primitive_desc_base& description, dnnl::primitive primitive,
               std::unordered_map<int, dnnl::memory> arguments);

  int positions_;
  dnnl::memory::data_type type_;              // of the linear layer
  dnnl::memory::data_type convolution_type_;  // of weights and activations
  const QuantizedNetwork* quantized_;         // while the program is made
  std::size_t convolutions_ = 0;              // made so far
  float leaky_slope_;
  dnnl::engine engine_;
  dnnl::stream stream_;
  Arena arena_;
  std::vector<Step> steps_;
  std::vector<float> input_;
  std::vector<float> output_;
  std::vector<float> tower_;
};

}  // namespace powderkeg::onednn
