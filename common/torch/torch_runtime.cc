#include "common/torch/torch_runtime.h"

#include <ATen/Parallel.h>
#include <malloc.h>

#include <mutex>

// Of the BLAS that some builds of LibTorch use. Its threads are not those of LibTorch: they would
// wait for each other in a loop where LibTorch has its own at work.
extern "C" __attribute__((weak)) void openblas_set_num_threads(int threads);

namespace powderkeg {
namespace {

constexpr int kLargestPooledBytes = 1 << 30;
constexpr int kHeapGrowthBytes = 64 << 20;

void KeepFreedMemory() {
  mallopt(M_MMAP_THRESHOLD, kLargestPooledBytes);
  mallopt(M_TRIM_THRESHOLD, kLargestPooledBytes);
  mallopt(M_TOP_PAD, kHeapGrowthBytes);
}

}  // namespace

void InitialiseTorch(int threads) {
  static std::once_flag initialised;
  std::call_once(initialised, [] {
    KeepFreedMemory();
    at::set_num_interop_threads(1);
  });
  at::set_num_threads(threads);
  if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
}

}  // namespace powderkeg
