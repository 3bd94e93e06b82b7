#include "actors/play/parallel_evaluator.h"

#include <gtest/gtest.h>

#include <atomic>
#include <barrier>
#include <chrono>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

namespace powderkeg {
namespace {

// What several evaluators were asked.
struct Questions {
  std::mutex mutex;
  std::multiset<std::size_t> sizes;   // of the batches
  std::set<std::thread::id> threads;  // that asked
  std::atomic<int> overlapping = 0;   // calls of an evaluator that was busy
};

// Answers with the step of the position.
class StepEvaluator final : public Evaluator {
 public:
  explicit StepEvaluator(Questions& questions) : questions_(questions) {}
  void Evaluate(const GameSettings& settings, std::span<const Position> positions,
                std::span<Evaluation> evaluations) override {
    if (busy_.exchange(true)) ++questions_.overlapping;
    {
      const std::lock_guard lock(questions_.mutex);
      questions_.sizes.insert(positions.size());
      questions_.threads.insert(std::this_thread::get_id());
    }
    for (std::size_t i = 0; i < positions.size(); ++i) {
      evaluations[i].policy.fill(static_cast<float>(settings.max_steps));
      evaluations[i].value = static_cast<float>(positions[i].state->step);
    }
    busy_ = false;
  }
  [[nodiscard]] std::string name() const override { return "step"; }

 private:
  Questions& questions_;
  std::atomic<bool> busy_ = false;
};

// Answers 1 only when another evaluator is at work too, everywhere but on the first thread late.
class MeetingEvaluator final : public Evaluator {
 public:
  explicit MeetingEvaluator(std::barrier<>& meeting) : meeting_(meeting) {}
  void Evaluate(const GameSettings& /*settings*/, std::span<const Position> /*positions*/,
                std::span<Evaluation> evaluations) override {
    meeting_.arrive_and_wait();
    constexpr int kLate = 1000;
    for (int i = 0; std::this_thread::get_id() != first_ && i < kLate; ++i) {
      std::this_thread::yield();
    }
    for (Evaluation& evaluation : evaluations) evaluation.value = 1;
  }
  [[nodiscard]] std::string name() const override { return "meeting"; }

 private:
  std::barrier<>& meeting_;
  const std::thread::id first_ = std::this_thread::get_id();
};

class ParallelEvaluatorTest : public testing::Test {
 protected:
  ParallelEvaluatorTest() {
    for (std::uint16_t step = 0; step < states_.size(); ++step) states_[step].step = step;
  }
  std::vector<std::unique_ptr<Evaluator>> Evaluators(int count) {
    std::vector<std::unique_ptr<Evaluator>> evaluators;
    for (int i = 0; i < count; ++i) {
      evaluators.push_back(std::make_unique<StepEvaluator>(questions_));
    }
    return evaluators;
  }
  // Asks about `size` states from `first` on and checks the answers.
  void Ask(Evaluator& evaluator, std::size_t first, std::size_t size) {
    batch_.Clear();
    for (std::size_t i = 0; i < size; ++i) {
      batch_.Add({.state = &states_[(first + i) % states_.size()], .viewer = 0});
    }
    evaluator.Evaluate({.max_steps = 77}, batch_.positions(), batch_.AllocateEvaluations());
    for (std::size_t i = 0; i < size; ++i) {
      ASSERT_EQ(batch_.evaluation(i).value, batch_.positions()[i].state->step);
      ASSERT_EQ(batch_.evaluation(i).policy[5], 77.0F);
    }
  }

  std::vector<State> states_ = std::vector<State>(100);
  EvaluationBatch batch_;
  Questions questions_;
};

TEST_F(ParallelEvaluatorTest, AnswersBatchesOfEverySize) {
  for (const int threads : {1, 2, 3, 5}) {
    ParallelEvaluator evaluator(Evaluators(threads));
    for (std::size_t size = 0; size < 40; ++size) Ask(evaluator, size, size);
  }
  EXPECT_EQ(questions_.overlapping, 0);
}

TEST_F(ParallelEvaluatorTest, PartsAreOfOneSizeButForOne) {
  ParallelEvaluator evaluator(Evaluators(3));
  Ask(evaluator, 0, 11);
  EXPECT_EQ(questions_.sizes, (std::multiset<std::size_t>{3, 4, 4}));
}

TEST_F(ParallelEvaluatorTest, PartsAreAnsweredAtTheSameTimeAndAllAwaited) {
  std::barrier meeting(2);
  std::vector<std::unique_ptr<Evaluator>> evaluators;
  for (int i = 0; i < 2; ++i) evaluators.push_back(std::make_unique<MeetingEvaluator>(meeting));
  ParallelEvaluator evaluator(std::move(evaluators));
  const std::vector<Position> positions(7, Position{.state = &states_[0], .viewer = 0});
  for (int batch = 0; batch < 20; ++batch) {
    std::vector<Evaluation> evaluations(positions.size(), Evaluation{});
    evaluator.Evaluate({}, positions, evaluations);
    for (const Evaluation& evaluation : evaluations) ASSERT_EQ(evaluation.value, 1);
  }
}

TEST_F(ParallelEvaluatorTest, OnePositionIsForTheCaller) {
  ParallelEvaluator evaluator(Evaluators(2));
  Ask(evaluator, 0, 1);
  EXPECT_EQ(questions_.threads, std::set{std::this_thread::get_id()});
}

TEST_F(ParallelEvaluatorTest, ManyBatchesInARowAreAnsweredRight) {
  ParallelEvaluator evaluator(Evaluators(3));
  for (std::size_t batch = 0; batch < 3000; ++batch) Ask(evaluator, batch, batch % 8);
  EXPECT_EQ(questions_.overlapping, 0);
  EXPECT_LE(questions_.threads.size(), 3U);
}

TEST_F(ParallelEvaluatorTest, BatchesMayComeFromAnyThreadInTurn) {
  ParallelEvaluator evaluator(Evaluators(2));
  for (std::size_t turn = 0; turn < 20; ++turn) {
    std::jthread([&] { Ask(evaluator, turn, 6); }).join();
  }
}

TEST_F(ParallelEvaluatorTest, EndsWithoutAnyWork) {
  for (int i = 0; i < 20; ++i) ParallelEvaluator evaluator(Evaluators(4));
  EXPECT_TRUE(questions_.sizes.empty());
}

class FailingEvaluator final : public Evaluator {
 public:
  void Evaluate(const GameSettings&, std::span<const Position>, std::span<Evaluation>) override {
    throw Error("out of order");
  }
  [[nodiscard]] std::string name() const override { return "failing"; }
};

// Whoever fails, nobody waits for ever, and the next batch is answered.
TEST_F(ParallelEvaluatorTest, AFailureReachesTheCaller) {
  for (const std::size_t failing : {0U, 1U, 2U}) {
    std::vector<std::unique_ptr<Evaluator>> evaluators = Evaluators(3);
    evaluators[failing] = std::make_unique<FailingEvaluator>();
    ParallelEvaluator evaluator(std::move(evaluators));
    const std::vector<Position> positions(9, Position{.state = &states_[0], .viewer = 0});
    std::vector<Evaluation> evaluations(positions.size());
    int failures = 0;  // a thread that is slow to wake leaves its parts to the others for a while
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (failures < 3 && std::chrono::steady_clock::now() < patience) {
      try {
        evaluator.Evaluate({}, positions, evaluations);
      } catch (const Error& error) {
        EXPECT_STREQ(error.what(), "out of order");
        ++failures;
      }
    }
    EXPECT_EQ(failures, 3) << "evaluator " << failing;
  }
}

TEST_F(ParallelEvaluatorTest, NameTellsTheThreads) {
  EXPECT_EQ(ParallelEvaluator(Evaluators(2)).name(), "2 x step");
}

}  // namespace
}  // namespace powderkeg
