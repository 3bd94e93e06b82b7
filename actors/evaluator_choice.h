#pragma once

// Which evaluator this machine has for a network: shared by the mains, the only code of the actors
// that names those that compute one.

#include <memory>
#include <string>

#include "common/config/agent_spec.h"
#include "common/model/evaluator.h"
#include "common/model/weights_snapshot.h"

namespace powderkeg {

struct EvaluatorChoice {
  // Of kEvaluatorNames and kPrecisionNames (agent_spec.h). auto: torch if it has a CUDA device,
  // else onednn, else torch; fp16 on CUDA, bf16 where the processor has it, else fp32.
  std::string evaluator = "auto";
  std::string precision = "auto";
  int threads = 1;   // that share each batch; more than one only with onednn
  int cache_mb = 8;  // of memory for answers given before (EvaluationCache); 0: none. A search of
                     // 250 simulations asks a third of its questions twice, of 1000 half of them;
                     // what it asks fits into 1 MB.
  int largest_batch = 0;  // up to this size no batch is the first of its size: the evaluator has
                          // prepared itself, which takes tens of milliseconds for each size
};

// An agent in words (ParseAgent) whose model is there (ResolvedModel) and can tell what its search
// asks; `default_model` is that of agents with a network that name none. Throws Error if it cannot
// (opponents predicted or chosen, of weights that foretell nobody), or the words are wrong.
[[nodiscard]] AgentSpec AgentFor(const std::string& text, const std::string& default_model = "");

// Prepares the process for the evaluators built in. Call once, before threads start.
void InitialiseEvaluators();

// One for each calling thread. Throws Error if the choice is unknown or not built in.
[[nodiscard]] std::unique_ptr<Evaluator> MakeEvaluator(const EvaluatorChoice& choice,
                                                       const Snapshot& snapshot);

}  // namespace powderkeg
