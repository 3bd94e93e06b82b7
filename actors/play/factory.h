#pragma once

// Agents and their models from specifications.

#include <functional>
#include <memory>
#include <string>

#include "actors/play/agent.h"
#include "actors/play/evaluation_batches.h"
#include "common/config/agent_spec.h"

namespace powderkeg {

// The agent; its questions are for the specification's model.
[[nodiscard]] std::unique_ptr<Agent> MakeAgent(const AgentSpec& spec);

// Loads a weights file for one thread. Only a main knows evaluators that compute; throws Error.
using ModelLoader = std::function<Model(const std::string& file)>;

// The uniform evaluator, or what the loader makes of the model file.
[[nodiscard]] Model MakeModel(const std::string& model_file, const ModelLoader& loader);

}  // namespace powderkeg
