#include "actors/play/factory.h"

#include "actors/play/foreign_agent.h"
#include "actors/play/plain_agents.h"
#include "actors/play/search_agent.h"
#include "common/base/check.h"

namespace powderkeg {
std::unique_ptr<Agent> MakeAgent(const AgentSpec& spec) {
  switch (spec.kind) {
    case AgentSpec::Kind::kPessimist: return std::make_unique<PessimistAgent>(spec.pessimist);
    case AgentSpec::Kind::kRuleBased: return std::make_unique<RuleBasedAgent>(spec.policy);
    case AgentSpec::Kind::kRawNetwork: return std::make_unique<RawNetworkAgent>();
    case AgentSpec::Kind::kForeign: return std::make_unique<ForeignAgent>(spec.foreign);
    case AgentSpec::Kind::kSearch: return std::make_unique<SearchAgent>(spec.search);
  }
  CHECK(false, static_cast<int>(spec.kind));
}

Model MakeModel(const std::string& model_file, const ModelLoader& loader) {
  if (model_file.empty()) return {std::make_shared<UniformEvaluator>(), /*weights_version=*/0};
  Model model = loader(model_file);
  CHECK(model.evaluator != nullptr, model_file);
  return model;
}

}  // namespace powderkeg
