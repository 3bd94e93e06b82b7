#include "actors/selfplay/weights_fetcher.h"

#include <gtest/gtest.h>

#include <string>

namespace powderkeg {
namespace {

using Clock = WeightsFetcher::Clock;

// How many requests the fetcher makes of a learner that answers each as `answer` does.
template <typename Answer>
int RequestsOf(WeightsFetcher& fetcher, const Answer& answer) {
  int requests = 0;
  while (requests < 100) {
    const auto request = fetcher.NextRequest(Clock::now());
    if (!request) break;
    ++requests;
    fetcher.Handle(answer(*request));
    fetcher.Handle(WeightsReceipt{.receipt = 1});
  }
  return requests;
}

// They used to be downloaded for ever.
TEST(WeightsFetcher, GivesUpWeightsThatAreNeverAsTheyWereOffered) {
  const Waker waker;
  WeightsFetcher fetcher(2, waker);
  fetcher.Handle(WeightsOffer{.version = 3, .size_bytes = 4, .sha256 = {}});
  const auto others = [](const WeightsRequest& request) {
    return WeightsChunk{.offer = {.version = request.version, .size_bytes = 9, .sha256 = {}},
                        .offset_bytes = request.offset_bytes,
                        .data = "ab"};
  };
  EXPECT_EQ(RequestsOf(fetcher, others), 3);
  EXPECT_EQ(fetcher.newest(), nullptr);
  EXPECT_FALSE(fetcher.Want(3).fault.empty());
}

TEST(WeightsFetcher, GivesUpDamagedOnes) {
  const Waker waker;
  WeightsFetcher fetcher(2, waker);
  (void)fetcher.Want(2);
  int answers = 0;
  const auto damaged = [&](const WeightsRequest& request) {
    return WeightsChunk{.offer = {.version = request.version, .size_bytes = 2, .sha256 = {}},
                        .offset_bytes = request.offset_bytes,
                        .data = std::string(2, static_cast<char>(++answers))};
  };
  EXPECT_EQ(RequestsOf(fetcher, damaged), 3);
  EXPECT_FALSE(fetcher.Want(2).fault.empty());
}

}  // namespace
}  // namespace powderkeg
