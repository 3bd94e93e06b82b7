#include "actors/evaluator_choice.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "actors/play/parallel_evaluator.h"
#include "common/base/check.h"
#include "common/config/agent_spec.h"
#include "common/model/evaluation_cache.h"
#include "common/model/model_name.h"
#include "common/model/precision.h"
#include "common/pommerman/generate.h"
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

// "auto" resolved for this machine.
std::string NameOf(const EvaluatorChoice& choice) {
  if (choice.evaluator != "auto") return choice.evaluator;
  return kHasOnednn && !HasCuda() ? "onednn" : "torch";
}

// Lets the evaluator answer batches of every size up to the largest.
void Prepare(int largest_batch, Evaluator& evaluator) {
  const State start = GenerateStart({}, {}, Rng(1));
  EvaluationBatch batch;
  for (int size = 1; size <= largest_batch; ++size) {
    batch.Add({.state = &start, .viewer = 0});
    evaluator.Evaluate({}, batch.positions(), batch.AllocateEvaluations());
  }
}

std::unique_ptr<Evaluator> MakeOne(const std::string& name, const EvaluatorChoice& choice,
                                   const Snapshot& snapshot) {
  if (name == "uniform") return std::make_unique<UniformEvaluator>();
  if (name == "onednn") return MakeOnednn(choice, snapshot);
  if (name == "torch") return MakeTorch(choice, snapshot);
  throw Error(StrCat("evaluator \"", name, "\": expected one of ", Joined(kEvaluatorNames, ", ")));
}

}  // namespace

AgentSpec AgentFor(const std::string& text, const std::string& default_model) {
  AgentSpec agent = ParseAgent(text);
  if (!agent.HasNetwork()) return agent;
  const std::string named = agent.model_file.empty() ? default_model : agent.model_file;
  if (!named.empty()) agent.model_file = ResolvedModel(named);
  constexpr std::string_view kModel = "model=";
  const std::size_t latest = agent.text.find("model=latest");
  if (latest != std::string::npos) {  // of today: reports say which that is
    agent.text.replace(latest + kModel.size(), named.size(), agent.model_file);
  }
  if (agent.kind != AgentSpec::Kind::kSearch || !Predicts(agent.search)) return agent;
  if (agent.model_file.empty() || LoadModel(agent.model_file)->description.others_hidden == 0) {
    throw Error(StrCat("agent ", text, ": opponents predicted or chosen with ",
                       named.empty() ? "no model" : named,
                       "; expected weights that foretell the others"));
  }
  return agent;
}

void InitialiseEvaluators() {
#ifdef POWDERKEG_HAS_TORCH
  InitialiseTorch(/*threads=*/1);
#endif
}

std::unique_ptr<Evaluator> MakeEvaluator(const EvaluatorChoice& choice, const Snapshot& snapshot) {
  const std::string name = NameOf(choice);
  const int threads = name == "onednn" ? std::max(choice.threads, 1) : 1;
  std::vector<std::unique_ptr<Evaluator>> evaluators;
  for (int i = 0; i < threads; ++i) {
    evaluators.push_back(MakeOne(name, choice, snapshot));
    Prepare(choice.largest_batch, *evaluators.back());
  }
  std::unique_ptr<Evaluator> evaluator =
      threads == 1 ? std::move(evaluators.front())
                   : std::make_unique<ParallelEvaluator>(std::move(evaluators));
  if (choice.cache_mb == 0 || name == "uniform") return evaluator;
  const auto bytes = static_cast<std::size_t>(choice.cache_mb) << 20;
  return std::make_unique<EvaluationCache>(std::move(evaluator), bytes);
}

}  // namespace powderkeg
