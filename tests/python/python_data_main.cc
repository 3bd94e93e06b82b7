// Writes what the tests of the Python package read: python_data FOLDER makes run/replay/ with two
// segments, and small.weights and paper.weights with canaries, into it.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/durable_file.h"
#include "common/model/weights_snapshot.h"
#include "common/segment/segment_file.h"
#include "tests/learner/played_games.h"
#include "tests/model/positions.h"
#include "tests/model/reference_evaluator.h"

namespace powderkeg {
namespace {

constexpr int kCanaryPositions = 6;
constexpr int kGames = 20;

// Initial weights with random batch norm and heads that answer to nothing too, and what they
// answer, a dead viewer among them.
void WriteWeights(const std::string& network, std::uint32_t version, const std::string& path) {
  WeightsSnapshot snapshot = *RandomWeights(NetworkByName(network), /*seed=*/version);
  snapshot.version = version;
  for (NamedArray& array : snapshot.arrays) {
    if (array.name == "own.fc.bias") std::ranges::fill(array.values, 0.5F);
  }
  std::vector<AgentId> viewers;
  for (int i = 0; i < kCanaryPositions; ++i) viewers.push_back(i % kAgentCount);
  std::vector<State> states = PlayedStates(kCanaryPositions, /*seed=*/1);
  states.back().agents[viewers.back()].alive = false;
  ReferenceEvaluator evaluator(std::make_shared<const WeightsSnapshot>(snapshot));
  snapshot.canary = MakeCanary(states, viewers, evaluator);
  SaveSnapshot(snapshot, path);
}

void WriteData(const std::filesystem::path& folder) {
  const std::filesystem::path replay = folder / "run" / "replay";
  CreateFolder(replay);
  WriteFileDurably(replay / "segment-00000001.h5", EncodeSegment(PlayGames(0, kGames)));
  WriteFileDurably(replay / "segment-00000002.h5", EncodeSegment(PlayGames(kGames, kGames)));
  WriteWeights("small", 3, folder / "small.weights");
  WriteWeights("paper", 4, folder / "paper.weights");
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: python_data FOLDER\n");
    return 2;
  }
  powderkeg::WriteData(argv[1]);
  return 0;
}
