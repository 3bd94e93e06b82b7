#pragma once

// Evaluation on CPUs with oneDNN alone. No oneDNN type in this header.

#include <memory>

#include "common/model/evaluator.h"
#include "common/model/precision.h"
#include "common/model/weights_snapshot.h"

namespace powderkeg {

// Whether this processor computes in bf16 (AVX-512 BF16 or better).
[[nodiscard]] bool HasBf16();
// Whether it multiplies 8-bit integers as fast as it can (VNNI).
[[nodiscard]] bool HasInt8();

// An evaluator "onednn fp32", "onednn bf16" or "onednn int8" for the weights of the snapshot. Where
// the processor lacks int8 it becomes bf16, and bf16 becomes fp32: name() tells. Uses the calling
// thread alone; several evaluators in several threads run independently. Throws Error on invalid
// weights and on fp16.
[[nodiscard]] std::unique_ptr<Evaluator> MakeOnednnEvaluator(const Snapshot& snapshot,
                                                             Precision precision);

}  // namespace powderkeg
