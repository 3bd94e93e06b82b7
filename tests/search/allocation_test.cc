// Counts every allocation of this program, so that it holds this test alone.

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "tests/search/search_support.h"
#include "tests/search/settings_from_text.h"

namespace {
std::size_t allocations = 0;
}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  void* memory = std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto step = static_cast<std::size_t>(alignment);
  void* memory = std::aligned_alloc(step, (size + step - 1) / step * step);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace powderkeg {
namespace {

// Runs the started search; returns how often it allocated.
std::size_t AllocationsOf(Search& search, EvaluationBatch& batch, Evaluator& evaluator) {
  const std::size_t before = allocations;
  while (search.Gather(batch)) {
    evaluator.Evaluate({}, batch.positions(), batch.AllocateEvaluations());
    search.Scatter(batch);
    batch.Clear();
  }
  return allocations - before;
}

TEST(SearchAllocation, SimulationsAllocateNothing) {
  for (const char* spec :
       {"", "tree=two_player", "memory=inferred", "leaves_per_batch=4", "root=gumbel",
        "root=gumbel,leaves_per_batch=4,tree=two_player", "root=gumbel,gumbel_first_halving=16",
        "forced_playouts=2", "full_search_share=0.5", "terminal_solver=true",
        "opponents=predicted,tree=two_player,widening=1", "opponents=chosen,predicted_drawn=true",
        "opponents=raw_network", "raw_network_depth=2", "exploratory_start=0.05"}) {
    const SearchSettings settings = ParseSearchSettings(spec);
    Search search(settings, {});
    UniformEvaluator evaluator;
    EvaluationBatch batch;
    search.Start(KnownStart(1), ModelsAtStart(settings, 0), Rng(1));
    AllocationsOf(search, batch, evaluator);  // the batch grows to its size
    const State state = KnownStart(2);
    search.Start(state, ModelsAtStart(settings, 0), Rng(2));
    EXPECT_EQ(AllocationsOf(search, batch, evaluator), 0U) << spec;
  }
}

TEST(SearchAllocation, NextMoveReusesTheMemory) {
  SearchSettings settings;
  settings.tree_reuse = false;
  Search search(settings, {});
  UniformEvaluator evaluator;
  EvaluationBatch batch;
  const OpponentModels models = ModelsAtStart(settings, 0);
  const State first = KnownStart(1);
  const State second = KnownStart(2);
  search.Start(first, models, Rng(1));
  AllocationsOf(search, batch, evaluator);
  const std::size_t before = allocations;
  search.Start(second, models, Rng(2));
  EXPECT_EQ(allocations, before);
}

}  // namespace
}  // namespace powderkeg
