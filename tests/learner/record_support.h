#pragma once

// Made-up games for tests of storage: every field has a value of its own.

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/base/rng.h"
#include "common/record/game_record.h"

namespace powderkeg {

// A record that no game would give but that the store must keep.
inline GameRecord RandomRecord(std::uint64_t ticket, int steps, int decisions) {
  Rng rng = Rng(1).Split(ticket);
  GameRecord record;
  record.ticket = ticket;
  record.setup.seed = rng.Next();
  record.setup.settings.mode = static_cast<Mode>(1 + rng.Below(4));
  record.setup.settings.board_size = rng.Below(2) == 0 ? 11 : 8;
  record.setup.settings.max_steps = static_cast<int>(rng.Below(800));
  record.setup.settings.blast_strength_cap = static_cast<int>(rng.Below(12));
  record.setup.settings.view_radius = static_cast<int>(rng.Below(5));
  for (int& steps_until : record.setup.settings.collapse_steps) {
    steps_until = static_cast<int>(rng.Below(800));
  }
  record.setup.start.generator = static_cast<BoardGenerator>(rng.Below(2));
  record.setup.start.corners = static_cast<StartCorners>(rng.Below(2));
  for (Seat& seat : record.setup.seats) {
    seat = {.searches = rng.Below(2) == 0,
            .policy = static_cast<PolicyKind>(rng.Below(5)),
            .teaches = static_cast<Teaches>(rng.Below(3)),
            .measured = rng.Below(2) == 0,
            .player = static_cast<std::uint8_t>(rng.Below(256))};
  }
  record.setup.lineup = static_cast<std::uint8_t>(rng.Below(256));
  record.setup.to_the_end = rng.Below(2) == 0;
  for (Track& track : record.tracks) {
    track.weights_version = static_cast<std::uint32_t>(rng.Next());
  }
  record.evaluator = rng.Below(2) == 0 ? "uniform" : "torch cpu fp32";
  for (int i = 0; i < steps; ++i) {
    JointAction& actions = record.actions.emplace_back();
    for (Action& action : actions) action = static_cast<Action>(rng.Below(kActionCount));
  }
  for (int i = 0; i < decisions; ++i) {
    Decision& decision = record.tracks[rng.Below(kAgentCount)].decisions.emplace_back();
    decision.step = static_cast<std::uint16_t>(rng.Below(800));
    for (std::uint16_t& visits : decision.visits) {
      visits = static_cast<std::uint16_t>(rng.Below(65'536));
    }
    decision.value = static_cast<float>(rng.Uniform() * 2 - 1);
    decision.weights_version = static_cast<std::uint32_t>(rng.Next());
  }
  record.outcome = {.done = rng.Below(2) == 0,
                    .result = static_cast<Result>(rng.Below(3)),
                    .winners = static_cast<std::uint8_t>(rng.Below(16)),
                    .rewards = {-1, 0, 1, -1}};
  return record;
}

inline std::vector<GameRecord> RandomRecords(std::uint64_t first_ticket, int count) {
  std::vector<GameRecord> records;
  for (int i = 0; i < count; ++i) {
    records.push_back(RandomRecord(first_ticket + static_cast<std::uint64_t>(i), 3 + i % 5, i % 4));
  }
  return records;
}

// A fresh folder that is removed with everything in it.
class TemporaryFolder {
 public:
  explicit TemporaryFolder(
      const std::filesystem::path& parent = std::filesystem::temp_directory_path()) {
    std::string name = (parent / "powderkeg-XXXXXX").string();
    CHECK(mkdtemp(name.data()) != nullptr, name);
    path_ = name;
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace powderkeg
