#include "actors/selfplay/ticket_host.h"

#include <utility>

#include "actors/play/search_agent.h"
#include "common/record/game_setup.h"
#include "common/wire/codec.h"

namespace powderkeg {

TicketHost::TicketHost(const Welcome& welcome, TicketBook& tickets, Outbox& outbox,
                       std::function<void()> game_added)
    : config_(welcome.self_play),
      settings_digest_(welcome.settings_digest),
      tickets_(tickets),
      outbox_(outbox),
      game_added_(std::move(game_added)),
      slots_(static_cast<std::size_t>(config_.games_in_flight)) {
  const Players who = ResolvePlayers(config_);
  const auto learner = static_cast<std::size_t>(who.lineups.front().seats[0]);
  for (Slot& slot : slots_) {
    slot.agent = std::make_unique<SearchAgent>(who.players[learner].agent.search);
  }
}

TicketHost::~TicketHost() {
  for (const Slot& slot : slots_) {
    if (slot.ticket) tickets_.PutBack(*slot.ticket);
  }
}

std::optional<GamePlan> TicketHost::NextGame(int slot_number) {
  if (outbox_.full()) return std::nullopt;
  const std::optional<std::uint64_t> ticket = tickets_.Take();
  if (!ticket) return std::nullopt;
  Slot& slot = slots_[static_cast<std::size_t>(slot_number)];
  slot.ticket = ticket;
  slot.start = std::chrono::steady_clock::now();
  return PlanFor(*ticket, slot);
}

GamePlan TicketHost::PlanFor(std::uint64_t ticket, Slot& slot) const {
  GamePlan plan;
  plan.ticket = ticket;
  plan.setup = SetupFor(config_, ticket);
  plan.end =
      config_.record_after_death ? GamePlan::End::kOfficial : GamePlan::End::kLastSearchDeath;
  for (std::size_t seat = 0; seat < plan.players.size(); ++seat) {
    if (plan.setup.seats[seat].searches) plan.players[seat] = {slot.agent.get(), model_};
  }
  return plan;
}

void TicketHost::GameFinished(int slot, Game& game) {
  outbox_.Add(Seal(game.record(), settings_digest_));
  slots_[static_cast<std::size_t>(slot)].ticket.reset();
  game_added_();
}

void TicketHost::FillOldest(LoopProgress& progress) const {
  const Slot* oldest = nullptr;
  for (const Slot& slot : slots_) {
    if (slot.ticket && (oldest == nullptr || *slot.ticket < *oldest->ticket)) oldest = &slot;
  }
  if (oldest == nullptr) return;
  progress.oldest_ticket = *oldest->ticket;
  progress.oldest_start = oldest->start;
}

}  // namespace powderkeg
