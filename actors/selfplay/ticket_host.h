#pragma once

// Gives a game loop the games of tickets and takes the finished ones.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "actors/play/agent_pool.h"
#include "actors/play/game_loop.h"
#include "actors/selfplay/outbox.h"
#include "actors/selfplay/progress.h"
#include "actors/selfplay/ticket_book.h"
#include "common/record/game_setup.h"
#include "common/wire/messages.h"

namespace powderkeg {

// One loop's host. One thread.
class TicketHost final : public GameHost {
 public:
  // Everything must outlive it. `game_added` is called after a game was put into the outbox.
  // `model_of`: the model of other weights than the newest, or nullopt while they are on their way.
  TicketHost(const Welcome& welcome, TicketBook& tickets, Outbox& outbox,
             std::function<void()> game_added,
             std::function<std::optional<Model>(std::uint32_t version)> model_of);
  // Tickets in play wait again.
  ~TicketHost() override;
  TicketHost(const TicketHost&) = delete;
  TicketHost& operator=(const TicketHost&) = delete;

  // Answers players of the newest weights in games that start from now on. Required before the
  // first game.
  void SetNewest(const Model& model) { newest_ = model; }
  [[nodiscard]] const Model& newest() const { return newest_; }

  // No game while no ticket waits, the outbox is full or weights that it needs have not arrived.
  [[nodiscard]] std::optional<GamePlan> NextGame(int slot) override;
  void GameFinished(int slot, Game& game) override;

  // Of every game.
  [[nodiscard]] const GameSettings& settings() const { return games_.settings(); }

  // The lowest ticket in play and the start of its game into `progress`.
  void FillOldest(LoopProgress& progress) const;

 private:
  struct Slot {
    std::optional<std::uint64_t> ticket;  // in play
    std::chrono::steady_clock::time_point start;
  };

  [[nodiscard]] std::optional<GamePlan> PlanFor(const Grant& grant, int slot);
  // The player's model in the game of this grant; nullopt while it is on its way.
  [[nodiscard]] std::optional<Model> ModelOf(std::size_t player, const Grant& grant) const;

  const RunGames games_;
  const bool swaps_at_once_;
  const Sha256Digest& settings_digest_;
  TicketBook& tickets_;
  Outbox& outbox_;
  const std::function<void()> game_added_;
  const std::function<std::optional<Model>(std::uint32_t version)> model_of_;
  std::vector<Slot> slots_;
  AgentPool agents_;
  Model newest_;
  const Model uniform_{.evaluator = std::make_shared<UniformEvaluator>()};
};

}  // namespace powderkeg
