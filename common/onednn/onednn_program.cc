#include "common/onednn/onednn_program.h"

#include <algorithm>
#include <utility>

#include "common/model/planes.h"
#include "common/onednn/depthwise.h"

namespace powderkeg::onednn {
namespace {

using dnnl::memory;
using Desc = memory::desc;
using Tag = memory::format_tag;
constexpr auto kF32 = memory::data_type::f32;
constexpr auto kInt8 = memory::data_type::s8;
// oneDNN's mask for scales that differ along the second dimension, the channels.
constexpr int kEachChannel = 1 << 1;

// The caller's memory for intermediate results: oneDNN's own would be shared between threads.
dnnl::primitive_attr MakeAttributes() {
  dnnl::primitive_attr attributes;
  attributes.set_scratchpad_mode(dnnl::scratchpad_mode::user);
  return attributes;
}

// `tag`: any or oihw; that of a depthwise convolution follows from it.
Desc WeightsDesc(const FoldedConvolution& layer, memory::data_type type, Tag tag) {
  const memory::dim groups = layer.groups;
  const memory::dim outputs = layer.outputs / layer.groups;
  const memory::dim inputs = layer.inputs / layer.groups;
  const memory::dim kernel = layer.kernel;
  if (groups == 1) return {{outputs, inputs, kernel, kernel}, type, tag};
  return {{groups, outputs, inputs, kernel, kernel}, type, tag == Tag::oihw ? Tag::goihw : tag};
}

memory::dims OutputDims(const FoldedConvolution& layer, const memory::dims& source) {
  const auto side = (source[2] - 1) / layer.stride + 1;
  return {source[0], layer.outputs, side, side};
}

}  // namespace

memory Arena::Acquire(const Desc& desc, const dnnl::engine& engine) {
  auto free = std::ranges::find(buffers_, false, &Buffer::in_use);
  if (free == buffers_.end()) free = buffers_.emplace(buffers_.end());
  free->in_use = true;
  free->size = std::max(free->size, desc.get_size());
  return free->users.emplace_back(memory(desc, engine, DNNL_MEMORY_NONE));
}

void Arena::Release(const memory& released) {
  for (Buffer& buffer : buffers_) {
    if (std::ranges::find(buffer.users, released) != buffer.users.end()) buffer.in_use = false;
  }
}

void Arena::Commit() {
  for (Buffer& buffer : buffers_) {
    constexpr std::size_t kAlignment = 64;
    buffer.bytes = std::make_unique<std::byte[]>(buffer.size + kAlignment);
    void* first = buffer.bytes.get();
    std::size_t space = buffer.size + kAlignment;
    first = std::align(kAlignment, buffer.size, first, space);
    for (memory& user : buffer.users) user.set_data_handle(first);
  }
}

Program::Program(const JoinedNetwork& network, int positions, memory::data_type type,
                 const dnnl::engine& engine)
    : Program(network, nullptr, positions, type, engine) {}

Program::Program(const QuantizedNetwork& network, int positions, memory::data_type type,
                 const dnnl::engine& engine)
    : Program(network.network, &network, positions, type, engine) {}

Program::Program(const JoinedNetwork& network, const QuantizedNetwork* quantized, int positions,
                 memory::data_type type, const dnnl::engine& engine)
    : positions_(positions),
      type_(type),
      convolution_type_(quantized == nullptr ? type : kInt8),
      quantized_(quantized),
      leaky_slope_(network.leaky_slope),
      engine_(engine),
      stream_(engine),
      input_(static_cast<std::size_t>(positions) * kPlanesSize),
      output_(static_cast<std::size_t>(positions * network.head.outputs)) {
  const Desc plain({positions, kPlaneCount, kBoardSize, kBoardSize}, kF32, Tag::nchw);
  memory x =
      AddConvolution(network.stem, memory(plain, engine_, input_.data()), Activation::kLeaky);
  for (const FoldedBlock& block : network.blocks) x = AddBlock(block, x);
  if (network.needs_tower) AddTowerCopy(x);
  x = AddConvolution(network.head_convolution, x, Activation::kLeaky);
  AddLinear(network.head, x);
  quantized_ = nullptr;
  arena_.Commit();
}

memory Program::AddBlock(const FoldedBlock& block, const memory& input) {
  memory x = input;
  for (std::size_t i = 0; i < block.convolutions.size(); ++i) {
    const bool last = i + 1 == block.convolutions.size();
    const memory next =
        AddConvolution(block.convolutions[i], x,
                       !last || block.final_activation ? Activation::kLeaky : Activation::kNone,
                       last && block.skip ? &input : nullptr);
    if (i > 0 || !block.skip) arena_.Release(x);
    x = next;
  }
  return x;
}

memory Program::AddConvolution(const FoldedConvolution& layer, const memory& source,
                               Activation activation, const memory* residual) {
  const bool plain = convolution_type_ == memory::data_type::bf16 && residual == nullptr;
  if (plain && DepthwiseKernel::CanRun(layer)) return AddDepthwise(layer, source, activation);
  const memory::dims source_dims = source.get_desc().dims();
  const memory::dims strides = {layer.stride, layer.stride};
  const memory::dims padding = {layer.kernel / 2, layer.kernel / 2};
  dnnl::post_ops post_ops;
  if (residual != nullptr) post_ops.append_sum();
  if (activation == Activation::kLeaky) {
    post_ops.append_eltwise(1.0F, dnnl::algorithm::eltwise_relu, leaky_slope_, 0.0F);
  }
  dnnl::primitive_attr attributes = MakeAttributes();
  attributes.set_post_ops(post_ops);
  auto output_type = convolution_type_;
  if (quantized_ != nullptr) {
    attributes.set_output_scales(kEachChannel, quantized_->scales[convolutions_]);
    if (convolutions_ + 1 == quantized_->scales.size()) output_type = type_;
  }
  ++convolutions_;
  const Desc bias({layer.outputs}, kF32, Tag::x);
  const dnnl::convolution_forward::primitive_desc description(
      {dnnl::prop_kind::forward_inference, dnnl::algorithm::convolution_direct,
       Desc(source_dims, convolution_type_, Tag::any),
       WeightsDesc(layer, convolution_type_, Tag::any), bias,
       Desc(OutputDims(layer, source_dims), output_type, Tag::any), strides, padding, padding},
      attributes, engine_);
  const memory input = Converted(source, description.src_desc());
  const memory output = residual != nullptr ? Converted(*residual, description.dst_desc())
                                            : arena_.Acquire(description.dst_desc(), engine_);
  AddStep(description, dnnl::convolution_forward(description),
          {{DNNL_ARG_SRC, input},
           {DNNL_ARG_WEIGHTS, Constant(layer.weights, WeightsDesc(layer, kF32, Tag::oihw),
                                       description.weights_desc())},
           {DNNL_ARG_BIAS, Constant(layer.bias, bias, bias)},
           {DNNL_ARG_DST, output}});
  steps_.back().convolved = output;
  ReleaseCopy(input, source);
  if (residual != nullptr) ReleaseCopy(*residual, output);
  return output;
}

memory Program::AddDepthwise(const FoldedConvolution& layer, const memory& source,
                             Activation activation) {
  const memory::dims source_dims = source.get_desc().dims();
  const memory input = Converted(source, Desc(source_dims, convolution_type_, Tag::nhwc));
  const memory output =
      arena_.Acquire(Desc(OutputDims(layer, source_dims), convolution_type_, Tag::nhwc), engine_);
  const float negative_slope = activation == Activation::kLeaky ? leaky_slope_ : 1;
  steps_.push_back({.run =
                        [this, kernel = DepthwiseKernel(layer, negative_slope), input, output,
                         side = static_cast<int>(source_dims[2])] {
                          kernel.Run(positions_, side,
                                     static_cast<const std::uint16_t*>(input.get_data_handle()),
                                     static_cast<std::uint16_t*>(output.get_data_handle()));
                        },
                    .convolved = output});
  ++convolutions_;
  ReleaseCopy(input, source);
  return output;
}

void Program::AddLinear(const LinearLayer& layer, const memory& source) {
  const memory::dims source_dims = source.get_desc().dims();
  const memory::dims weight_dims = {layer.outputs, source_dims[1], source_dims[2], source_dims[3]};
  const Desc bias({layer.outputs}, kF32, Tag::x);
  const Desc output({positions_, layer.outputs}, kF32, Tag::nc);
  const dnnl::inner_product_forward::primitive_desc description(
      {dnnl::prop_kind::forward_inference, Desc(source_dims, type_, Tag::any),
       Desc(weight_dims, type_, Tag::any), bias, output},
      MakeAttributes(), engine_);
  const memory input = Converted(source, description.src_desc());
  AddStep(description, dnnl::inner_product_forward(description),
          {{DNNL_ARG_SRC, input},
           {DNNL_ARG_WEIGHTS, Constant(layer.weights, Desc(weight_dims, kF32, Tag::oihw),
                                       description.weights_desc())},
           {DNNL_ARG_BIAS, Constant(layer.bias, bias, bias)},
           {DNNL_ARG_DST, memory(output, engine_, output_.data())}});
}

memory Program::Converted(const memory& source, const Desc& desc) {
  if (source.get_desc() == desc) return source;
  const memory copy = arena_.Acquire(desc, engine_);
  const bool quantizes = source.get_desc().data_type() == kF32 && desc.data_type() == kInt8;
  AddReorder(source, copy, quantizes ? std::vector{kStepsPerPlane} : std::vector<float>{});
  return copy;
}

void Program::AddReorder(const memory& from, const memory& to, const std::vector<float>& scales) {
  dnnl::primitive_attr attributes = MakeAttributes();
  if (!scales.empty()) attributes.set_output_scales(scales.size() == 1 ? 0 : kEachChannel, scales);
  const dnnl::reorder::primitive_desc description(from, to, attributes);
  AddStep(description, dnnl::reorder(description), {{DNNL_ARG_FROM, from}, {DNNL_ARG_TO, to}});
}

void Program::AddTowerCopy(const memory& source) {
  const memory::dims dims = source.get_desc().dims();
  tower_.resize(static_cast<std::size_t>(dims[0] * dims[1] * dims[2] * dims[3]));
  AddReorder(source, memory({dims, kF32, Tag::nhwc}, engine_, tower_.data()),
             quantized_ == nullptr ? std::vector<float>{} : quantized_->tower_steps);
}

void Program::ReleaseCopy(const memory& copy, const memory& source) {
  if (!(copy == source)) arena_.Release(copy);
}

memory Program::Constant(const std::vector<float>& values, const Desc& plain, const Desc& desc) {
  memory source(plain, engine_, const_cast<float*>(values.data()));
  memory constant(desc, engine_);
  dnnl::reorder(source, constant).execute(stream_, source, constant);
  stream_.wait();
  return constant;
}

void Program::AddStep(const dnnl::primitive_desc_base& description, dnnl::primitive primitive,
                      std::unordered_map<int, memory> arguments) {
  const Desc scratchpad = description.scratchpad_desc();
  if (scratchpad.get_size() > 0) {
    const memory scratch = arena_.Acquire(scratchpad, engine_);
    arguments.emplace(DNNL_ARG_SCRATCHPAD, scratch);
    arena_.Release(scratch);
  }
  steps_.push_back(
      {.run = [this, primitive = std::move(primitive),
               arguments = std::move(arguments)] { primitive.execute(stream_, arguments); },
       .convolved = {}});
}

// A CPU stream of oneDNN is in order, and done with a step when its call returns.
void Program::Run() {
  for (const Step& step : steps_) step.run();
  stream_.wait();
}

void Program::Run(const Observer& observe) {
  std::size_t convolution = 0;
  for (const Step& step : steps_) {
    step.run();
    stream_.wait();
    if (step.convolved) observe(convolution++, step.convolved);
  }
}

}  // namespace powderkeg::onednn
