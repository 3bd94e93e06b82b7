#pragma once

// LibTorch, as every file of this project includes it: some builds of it bring glog's CHECK macros,
// which must not replace (or be replaced by) those of common/base/check.h.

#pragma push_macro("CHECK")
#pragma push_macro("DCHECK")
#undef CHECK
#undef DCHECK
#include <torch/cuda.h>
#include <torch/torch.h>
#ifdef POWDERKEG_TORCH_CUDA
#include <ATen/cuda/CUDAGraph.h>
#include <c10/cuda/CUDAGuard.h>
#include <c10/cuda/CUDAStream.h>
#endif
#undef CHECK
#undef DCHECK
#pragma pop_macro("DCHECK")
#pragma pop_macro("CHECK")
