#include "actors/play/factory.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "actors/play/plain_agents.h"
#include "actors/play/search_agent.h"
#include "common/base/check.h"

namespace powderkeg {
namespace {

using Options = std::vector<std::pair<std::string, std::string>>;

// "a=1,b=2" as pairs in order. Throws Error.
Options ParseOptions(std::string_view agent, std::string_view text) {
  Options options;
  while (!text.empty()) {
    const std::string_view option = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), option.size() + 1));
    const std::size_t equals = option.find('=');
    if (equals == std::string_view::npos || equals == 0) {
      throw Error(StrCat("agent ", agent, ": option \"", option, "\": expected OPTION=VALUE"));
    }
    options.emplace_back(option.substr(0, equals), option.substr(equals + 1));
  }
  return options;
}

// Takes the value of "model" out of the options; empty if there is none.
std::string TakeModel(Options& options) {
  std::string file;
  std::erase_if(options, [&file](const auto& option) {
    if (option.first != "model") return false;
    file = option.second;
    return true;
  });
  return file;
}

void ParseRawNetwork(Options options, AgentDescription& description) {
  description.kind = AgentDescription::Kind::kRawNetwork;
  description.model_file = TakeModel(options);
  if (!options.empty()) {
    throw Error(StrCat("agent raw: unknown option \"", options.front().first, "\": known: model"));
  }
  if (description.model_file.empty()) {
    throw Error("agent raw: no model: expected raw:model=FILE");
  }
}

void ParseSearch(Options options, AgentDescription& description) {
  description.kind = AgentDescription::Kind::kSearch;
  description.model_file = TakeModel(options);
  description.search = SearchSettingsFrom(options);
}

}  // namespace

AgentDescription ParseAgent(std::string_view text) {
  AgentDescription description;
  description.text = text;
  const std::string_view name = text.substr(0, text.find(':'));
  const bool has_options = name.size() < text.size();
  const std::string_view options = has_options ? text.substr(name.size() + 1) : std::string_view();
  if (name == "raw") {
    ParseRawNetwork(ParseOptions(name, options), description);
  } else if (name == "search") {
    ParseSearch(ParseOptions(name, options), description);
  } else if (const std::optional<PolicyKind> policy = PolicyKindFor(name); policy && !has_options) {
    description.policy = *policy;
  } else if (policy) {
    throw Error(StrCat("agent ", name, ": options \"", options, "\": it has none"));
  } else {
    throw Error(StrCat("unknown agent \"", name, "\": known: ", KnownAgents()));
  }
  return description;
}

std::string KnownAgents() {
  return "idle, random, harmless, simple_unbiased, official_simple, raw:model=FILE, "
         "search[:OPTION=VALUE,...][,model=FILE]";
}

std::unique_ptr<Agent> MakeAgent(const AgentDescription& description) {
  switch (description.kind) {
    case AgentDescription::Kind::kRuleBased:
      return std::make_unique<RuleBasedAgent>(description.policy);
    case AgentDescription::Kind::kRawNetwork: return std::make_unique<RawNetworkAgent>();
    case AgentDescription::Kind::kSearch: return std::make_unique<SearchAgent>(description.search);
  }
  CHECK(false, static_cast<int>(description.kind));
}

Model MakeModel(const std::string& model_file, const ModelLoader& loader) {
  if (model_file.empty()) return {std::make_shared<UniformEvaluator>(), /*weights_version=*/0};
  Model model = loader(model_file);
  CHECK(model.evaluator != nullptr, model_file);
  return model;
}

}  // namespace powderkeg
