#include "learner/intake/plausible.h"

#include <algorithm>
#include <cstddef>
#include <numeric>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using Refusal = std::optional<std::string>;

// Version 0, no weights, is played by until there are some, or by whoever evaluates without.
Refusal CheckVersion(std::uint32_t version, const Player& player, std::size_t number,
                     std::uint32_t newest) {
  using Weights = PlayerSpec::Weights;
  const bool of_run = player.weights == Weights::kNewest || player.weights == Weights::kPast;
  const bool of_file = player.weights == Weights::kFile && version == FileVersion(number);
  if (version == 0 || of_file || (of_run && version <= newest)) return std::nullopt;
  const std::string expected = of_run ? StrCat("0 to ", newest) : "those of its settings";
  return StrCat("weights ", version, " of player ", player.name, ", expected ", expected);
}

// A search may keep what it knew from earlier moves. An improved policy (root=gumbel) is no count.
Refusal CheckVisits(const Decision& decision, const SearchSettings& search) {
  const auto visits = std::accumulate(decision.visits.begin(), decision.visits.end(), 0LL);
  const bool learns_each = search.full_search_share == 1;
  if (visits == 0 && learns_each) return "no visits, expected some in every decision";
  const long long simulations = std::max(search.simulations, search.fast_simulations);
  const long long most = simulations * (decision.step + 1);
  if (search.root == RootSearch::kGumbel || visits <= most) return std::nullopt;
  return StrCat(visits, " visits, expected at most ", most);
}

Refusal CheckTrack(const Track& track, const Player& player, std::size_t number,
                   std::uint32_t newest) {
  if (auto refusal = CheckVersion(track.weights_version, player, number, newest)) return refusal;
  for (const Decision& decision : track.decisions) {
    auto refusal = CheckVersion(decision.weights_version, player, number, newest);
    if (!refusal) refusal = CheckVisits(decision, player.agent.search);
    if (refusal) return StrCat("step ", decision.step, ": ", *refusal);
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> WhyImplausible(const GameRecord& record, const RunGames& games,
                                          std::uint32_t newest) {
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    const Seat& seat = record.setup.seats[agent];
    const Track& track = record.tracks[agent];
    Refusal refusal;
    if (seat.searches) {
      refusal = CheckTrack(track, games.players()[seat.player], seat.player, newest);
    } else if (track.weights_version != 0) {
      refusal = StrCat("weights ", track.weights_version, " of a script, expected 0");
    }
    if (refusal) return StrCat("agent ", agent, ": ", *refusal);
  }
  return std::nullopt;
}

}  // namespace powderkeg
