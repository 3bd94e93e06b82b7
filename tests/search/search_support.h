#pragma once

// What the tests of the search share: running one to its end, and models to run it with.

#include <cstdint>
#include <span>
#include <vector>

#include "actors/search/search.h"
#include "common/model/evaluator.h"
#include "common/pommerman/generate.h"

namespace powderkeg {

// Answers the search's questions, one batch for itself, until it is finished.
inline SearchResult Finish(Search& search, Evaluator& evaluator, const GameSettings& game = {}) {
  EvaluationBatch batch;
  while (search.Gather(batch)) {
    evaluator.Evaluate(game, batch.positions(), batch.AllocateEvaluations());
    search.Scatter(batch);
    batch.Clear();
  }
  return search.Result();
}

// Runs all searches with a batch for all of them.
inline void FinishTogether(std::span<Search> searches) {
  UniformEvaluator evaluator;
  EvaluationBatch batch;
  for (;;) {
    std::vector<Search*> asking;
    for (Search& search : searches) {
      if (search.Gather(batch)) asking.push_back(&search);
    }
    if (asking.empty()) return;
    evaluator.Evaluate({}, batch.positions(), batch.AllocateEvaluations());
    for (Search* search : asking) search->Scatter(batch);
    batch.Clear();
  }
}

inline OpponentModels ModelsAtStart(const SearchSettings& settings, AgentId self,
                                    const GameSettings& game = {}, std::uint64_t seed = 7) {
  OpponentModels models;
  models.StartGame(settings, game, self, Rng(seed));
  return models;
}

// One whole search of agent 0 with the uniform evaluator.
inline SearchResult SearchOnce(const SearchSettings& settings, const State& root,
                               const GameSettings& game = {}, std::uint64_t seed = 1) {
  Search search(settings, game);
  UniformEvaluator evaluator;
  search.Start(root, ModelsAtStart(settings, 0, game), Rng(seed));
  return Finish(search, evaluator, game);
}

// A start position as an agent may know it.
inline State KnownStart(std::uint64_t seed) {
  State state = GenerateStart(GameSettings{}, StartSettings{}, Rng(seed));
  state.RemoveItems(state.HiddenItems());
  return state;
}

// One number for the behaviour of the search with the uniform evaluator: every visit count of some
// searches of both kinds, with tree reuse, without noise (whose logarithms are the library's).
inline std::uint64_t SearchSignature() {
  std::uint64_t signature = 0;
  for (const TreeKind tree : {TreeKind::kOnePlayer, TreeKind::kTwoPlayer}) {
    SearchSettings settings = WithoutAids({});
    settings.tree = tree;
    settings.noise_weight = 0;
    settings.exploratory_start = 0.05;
    Search search(settings, GameSettings{});
    UniformEvaluator evaluator;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      State state = KnownStart(seed);
      OpponentModels models = ModelsAtStart(settings, 0, {}, seed);
      for (std::uint64_t move = 0; move < 12 && state.agents[0].alive; ++move) {
        search.Start(state, models, Rng(seed).Split(move));
        const SearchResult result = Finish(search, evaluator);
        for (const std::uint32_t visits : result.visits) {
          signature = Rng(signature ^ visits).Next();
        }
        JointAction actions = result.expected_actions;
        actions[0] = result.best;
        const State before = state;
        Advance(GameSettings{}, actions, state);
        models.ObserveStep({before}, {state});
      }
    }
  }
  return signature;
}

}  // namespace powderkeg
