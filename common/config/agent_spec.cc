#include "common/config/agent_spec.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "common/base/nearest_name.h"

namespace powderkeg {
namespace {

constexpr std::string_view kPessimist = "pessimist";
constexpr std::string_view kForeign = "http";

// "a=1,b=2" as fields in order. Throws Error.
std::vector<TextField> ParseOptions(std::string_view agent, std::string_view text) {
  std::vector<TextField> options;
  while (!text.empty()) {
    const std::string_view option = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), option.size() + 1));
    const std::size_t equals = option.find('=');
    if (equals == std::string_view::npos || equals == 0) {
      throw Error(StrCat("agent ", agent, ": option ", Quoted(option), ": expected OPTION=VALUE"));
    }
    TextField& field = options.emplace_back();
    field.name = option.substr(0, equals);
    field.value = option.substr(equals + 1);
  }
  return options;
}

// Takes the value of "model" out of the options; empty if there is none.
std::string TakeModel(std::vector<TextField>& options) {
  std::string file;
  std::erase_if(options, [&file](const TextField& option) {
    if (option.name != "model") return false;
    file = option.value;
    return true;
  });
  return file;
}

void ReadRawNetwork(std::vector<TextField> options, AgentSpec& agent) {
  agent.kind = AgentSpec::Kind::kRawNetwork;
  agent.model_file = TakeModel(options);
  if (!options.empty()) {
    throw Error(StrCat("agent raw: unknown option ", Quoted(options.front().name),
                       ": expected raw:model=MODEL"));
  }
}

void ReadPessimist(const std::vector<TextField>& options, AgentSpec& agent) {
  agent.kind = AgentSpec::Kind::kPessimist;
  ReadOptions(options, "pessimist:", PessimistOptions(), agent.pessimist);
}

void ReadSearch(std::vector<TextField> options, const SearchSettings& base, AgentSpec& agent) {
  agent.kind = AgentSpec::Kind::kSearch;
  agent.model_file = TakeModel(options);
  agent.search = base;
  ReadOptions(options, "search:", SearchOptions(), agent.search);
}

void ReadForeign(std::string_view text, AgentSpec& agent) {
  const std::string_view address = text.substr(0, text.find(','));
  const std::optional<HttpAddress> server = ParseHttpAddress(address);
  if (!server || server->port == 0) {
    throw Error(StrCat("agent http: address ", Quoted(address),
                       ": expected http:HOST:PORT with a port from 1 to 65535"));
  }
  text.remove_prefix(std::min(text.size(), address.size() + 1));
  agent.kind = AgentSpec::Kind::kForeign;
  agent.foreign.server = *server;
  ReadOptions(ParseOptions(kForeign, text), "http:", ForeignOptions(), agent.foreign);
}

AgentSpec Parse(std::string_view text, const SearchSettings& base) {
  AgentSpec agent;
  agent.text = text;
  const std::string_view name = text.substr(0, text.find(':'));
  const bool has_options = name.size() < text.size();
  const std::string_view options = has_options ? text.substr(name.size() + 1) : std::string_view();
  if (name == "raw") {
    ReadRawNetwork(ParseOptions(name, options), agent);
  } else if (name == kPessimist) {
    ReadPessimist(ParseOptions(name, options), agent);
  } else if (name == "search") {
    ReadSearch(ParseOptions(name, options), base, agent);
  } else if (name == kForeign) {
    ReadForeign(options, agent);
  } else if (const std::optional<PolicyKind> policy = PolicyKindFor(name); policy && !has_options) {
    agent.policy = *policy;
  } else if (policy) {
    throw Error(StrCat("agent ", name, ": options ", Quoted(options), ": it has none"));
  } else {
    std::vector<std::string_view> known = {"raw", "search", kForeign};
    known.insert(known.end(), kScriptNames.begin(), kScriptNames.end());
    throw Error(StrCat("unknown agent ", Quoted(name), ": known: ", KnownAgents(),
                       DidYouMean(name, known)));
  }
  return agent;
}

}  // namespace

AgentSpec ParseAgent(std::string_view text) {
  AgentSpec agent = Parse(text, {});
  if (agent.kind == AgentSpec::Kind::kRawNetwork && agent.model_file.empty()) {
    throw Error("agent raw: no model: expected raw:model=MODEL");
  }
  return agent;
}

AgentSpec ParsePlayersAgent(std::string_view text, const SearchSettings& base) {
  AgentSpec agent = Parse(text, base);
  if (agent.kind == AgentSpec::Kind::kForeign) {
    throw Error(StrCat("agent ", Quoted(text),
                       " of a player: expected one that an actor can play without a server"));
  }
  if (!agent.model_file.empty()) {
    throw Error(StrCat("agent ", Quoted(text),
                       " of a player: expected no model in it, but weights: \"file:",
                       agent.model_file, "\" beside it"));
  }
  return agent;
}

bool IsScript(std::string_view name) {
  return std::ranges::find(kScriptNames, name) != kScriptNames.end();
}

void CheckServers(std::span<const AgentSpec> seats) {
  for (const AgentSpec& seat : seats) {
    if (seat.kind != AgentSpec::Kind::kForeign) continue;
    if (std::ranges::count(seats, seat.foreign.server,
                           [](const AgentSpec& other) { return other.foreign.server; }) < 2)
      continue;
    throw Error(StrCat("agent ", seat.text, " has two seats; expected a server for each"));
  }
}

std::string KnownAgents() {
  return Joined(kScriptNames, ", ") +
         "[:OPTION=VALUE,...], raw:model=MODEL, search[:OPTION=VALUE,...][,model=MODEL], "
         "http:HOST:PORT[,OPTION=VALUE,...]";
}

std::string AgentOptionsHelp() {
  return StrCat(
      "Options of a search, as in search:simulations=64,root=gumbel\n\n",
      DescribeOptions(SearchOptions(), ""), "\nOptions of a pessimist, as in pessimist:depth=3\n\n",
      DescribeOptions(PessimistOptions(), ""),
      "\nOptions of a server of the official protocol, as in http:127.0.0.1:10080,move_ms=100\n\n",
      DescribeOptions(ForeignOptions(), ""));
}

}  // namespace powderkeg
