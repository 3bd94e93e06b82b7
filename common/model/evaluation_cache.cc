#include "common/model/evaluation_cache.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "common/base/check.h"

namespace powderkeg {
namespace {

// Two chains of multiplications folded to 64 bits (as wyhash and its kin do), with different keys.
class KeyBuilder {
 public:
  void Add(std::uint64_t word) {
    key_.low = Fold(key_.low ^ word ^ 0xA0761D6478BD642Fu, 0xE7037ED1A0B428DBu);
    key_.high = Fold(key_.high ^ std::rotl(word, 32) ^ 0x8EBC6AF09C88C6E3u, 0x589965CC75374CC3u);
  }
  void Add(BitBoard board) {
    Add(board.low());
    Add(board.high());
  }
  [[nodiscard]] PositionKey key() const { return key_; }

 private:
  static std::uint64_t Fold(std::uint64_t a, std::uint64_t b) {
    __extension__ using Wide = unsigned __int128;
    const Wide product = Wide{a} * b;
    return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
  }

  PositionKey key_{0x1D8E4E27C47D124Fu, 0xEB44ACCAB455D165u};
};

std::uint32_t WordOf(const Bomb& bomb) {
  static_assert(sizeof(Bomb) == sizeof(std::uint32_t));
  return std::bit_cast<std::uint32_t>(bomb);
}

std::uint64_t WordOf(const AgentState& agent) {
  return std::uint64_t{agent.cell} | std::uint64_t{agent.ammo} << 8 |
         std::uint64_t{agent.blast_strength} << 16 | std::uint64_t{agent.alive} << 24 |
         std::uint64_t{agent.can_kick} << 25;
}

}  // namespace

PositionKey KeyOf(const Position& position) {
  const State& state = *position.state;
  KeyBuilder builder;
  for (const BitBoard board :
       {state.rigid, state.wood, state.item_low, state.item_high, state.flames[0], state.flames[1],
        state.flames[2], position.visible}) {
    builder.Add(board);
  }
  for (const Bomb& bomb : state.Bombs()) builder.Add(WordOf(bomb));
  for (const AgentState& agent : state.agents) builder.Add(WordOf(agent));
  builder.Add(std::bit_cast<std::uint64_t>(state.messages));
  builder.Add(std::uint64_t{state.step} | std::uint64_t{state.bomb_count} << 16 |
              static_cast<std::uint64_t>(position.viewer) << 24);
  return builder.key();
}

EvaluationCache::EvaluationCache(std::unique_ptr<Evaluator> evaluator, std::size_t bytes)
    : evaluator_(std::move(evaluator)) {
  static_assert(sizeof(Entry) == 72);
  const std::size_t buckets = std::max<std::size_t>(1, bytes / (kWays * sizeof(Entry)));
  entries_.resize(buckets * kWays);
}

std::string EvaluationCache::name() const { return "cached " + evaluator_->name(); }

void EvaluationCache::Clear() { cleared_at_ = clock_; }

void EvaluationCache::Evaluate(const GameSettings& settings, std::span<const Position> positions,
                               std::span<Evaluation> evaluations) {
  CHECK(positions.size() == evaluations.size());
  if (settings != settings_) {
    settings_ = settings;
    Clear();
  }
  LookUp(positions, evaluations);
  const std::size_t misses = missing_positions_.size();
  hits_.fetch_add(positions.size() - misses, std::memory_order_relaxed);
  misses_.fetch_add(misses, std::memory_order_relaxed);
  if (misses == 0) return;
  missing_evaluations_.resize(misses);
  evaluator_->Evaluate(settings, missing_positions_, missing_evaluations_);
  for (const Question& question : questions_) {
    evaluations[question.position] = missing_evaluations_[question.missing];
  }
  for (std::size_t i = 0; i < misses; ++i) Store(missing_keys_[i], missing_evaluations_[i]);
}

void EvaluationCache::LookUp(std::span<const Position> positions,
                             std::span<Evaluation> evaluations) {
  questions_.clear();
  missing_keys_.clear();
  missing_positions_.clear();
  missing_by_key_.assign(std::bit_ceil(2 * positions.size() + 1), 0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const PositionKey key = KeyOf(positions[i]);
    if (const Evaluation* const known = Find(key); known != nullptr) {
      evaluations[i] = *known;
      continue;
    }
    const std::size_t missing = FindMissing(key);
    questions_.push_back({i, missing});
    if (missing < missing_keys_.size()) continue;
    missing_keys_.push_back(key);
    missing_positions_.push_back(positions[i]);
  }
}

std::size_t EvaluationCache::FindMissing(const PositionKey& key) {
  const std::size_t mask = missing_by_key_.size() - 1;
  std::size_t place = key.high & mask;
  while (missing_by_key_[place] != 0) {
    const std::size_t index = missing_by_key_[place] - 1;
    if (missing_keys_[index] == key) return index;
    place = (place + 1) & mask;
  }
  missing_by_key_[place] = static_cast<std::uint32_t>(missing_keys_.size() + 1);
  return missing_keys_.size();
}

std::span<EvaluationCache::Entry, EvaluationCache::kWays> EvaluationCache::BucketOf(
    const PositionKey& key) {
  const std::uint64_t buckets = entries_.size() / kWays;
  const std::uint64_t bucket = (key.low >> 32) * buckets >> 32;  // Lemire 2016
  return std::span<Entry, kWays>(&entries_[bucket * kWays], kWays);
}

const Evaluation* EvaluationCache::Find(const PositionKey& key) {
  for (const Entry& entry : BucketOf(key)) {
    if (entry.stored_at > cleared_at_ && entry.key == key) return &entry.evaluation;
  }
  return nullptr;
}

void EvaluationCache::Store(const PositionKey& key, const Evaluation& evaluation) {
  if (++clock_ == 0) {
    std::ranges::fill(entries_, Entry{});
    cleared_at_ = 0;
    clock_ = 1;
  }
  *std::ranges::min_element(BucketOf(key), {}, &Entry::stored_at) = {key, evaluation, clock_};
}

}  // namespace powderkeg
