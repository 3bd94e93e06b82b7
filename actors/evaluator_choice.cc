#include "actors/evaluator_choice.h"

#include "common/base/check.h"
#include "common/model/precision.h"
#ifdef POWDERKEG_HAS_ONEDNN
#include "common/onednn/onednn_evaluator.h"
#endif
#ifdef POWDERKEG_HAS_TORCH
#include "common/torch/torch_evaluator.h"
#include "common/torch/torch_runtime.h"
#endif

namespace powderkeg {
namespace {

Precision PrecisionOf(const EvaluatorChoice& choice, Precision automatic) {
  return choice.precision == "auto" ? automatic : PrecisionByName(choice.precision);
}

#ifdef POWDERKEG_HAS_ONEDNN
constexpr bool kHasOnednn = true;

std::unique_ptr<Evaluator> MakeOnednn(const EvaluatorChoice& choice, const Snapshot& snapshot) {
  return MakeOnednnEvaluator(snapshot,
                             PrecisionOf(choice, HasBf16() ? Precision::kBf16 : Precision::kFp32));
}
#else
constexpr bool kHasOnednn = false;

std::unique_ptr<Evaluator> MakeOnednn(const EvaluatorChoice&, const Snapshot&) {
  throw Error("evaluator \"onednn\": not built in: expected a build that finds oneDNN");
}
#endif

#ifdef POWDERKEG_HAS_TORCH
bool HasCuda() { return IsCudaAvailable(); }

std::unique_ptr<Evaluator> MakeTorch(const EvaluatorChoice& choice, const Snapshot& snapshot) {
  TorchEvaluatorSettings settings;
  settings.device = HasCuda() ? TorchDevice::kCuda : TorchDevice::kCpu;
  settings.precision = PrecisionOf(choice, HasCuda() ? Precision::kFp16 : Precision::kFp32);
  return MakeTorchEvaluator(snapshot, settings);
}
#else
bool HasCuda() { return false; }

std::unique_ptr<Evaluator> MakeTorch(const EvaluatorChoice&, const Snapshot&) {
  throw Error("evaluator \"torch\": not built in: expected a build with POWDERKEG_ACTORS_TORCH");
}
#endif

}  // namespace

void InitialiseEvaluators() {
#ifdef POWDERKEG_HAS_TORCH
  InitialiseTorch(/*threads=*/1);
#endif
}

std::unique_ptr<Evaluator> MakeEvaluator(const EvaluatorChoice& choice, const Snapshot& snapshot) {
  if (choice.evaluator == "uniform") return std::make_unique<UniformEvaluator>();
  if (choice.evaluator == "onednn") return MakeOnednn(choice, snapshot);
  if (choice.evaluator == "torch") return MakeTorch(choice, snapshot);
  if (choice.evaluator == "auto") {
    return kHasOnednn && !HasCuda() ? MakeOnednn(choice, snapshot) : MakeTorch(choice, snapshot);
  }
  throw Error(
      StrCat("evaluator \"", choice.evaluator, "\": expected one of auto, uniform, onednn, torch"));
}

}  // namespace powderkeg
