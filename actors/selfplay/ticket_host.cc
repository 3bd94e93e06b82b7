#include "actors/selfplay/ticket_host.h"

#include <utility>

#include "common/wire/codec.h"

namespace powderkeg {
namespace {

// What the players are in games that teach, then what they are in exams: as strong as they can.
std::vector<AgentSpec> SpecsOf(const std::vector<Player>& players) {
  std::vector<AgentSpec> specs;
  for (const Player& player : players) specs.push_back(player.agent);
  for (const Player& player : players) {
    specs.push_back(player.agent);
    specs.back().search = WithoutExploration(player.agent.search);
  }
  return specs;
}

}  // namespace

TicketHost::TicketHost(const Welcome& welcome, TicketBook& tickets, Outbox& outbox,
                       std::function<void()> game_added)
    : games_(welcome.self_play),
      swaps_at_once_(welcome.self_play.weights_swap == WeightsSwap::kAtOnce),
      settings_digest_(welcome.settings_digest),
      tickets_(tickets),
      outbox_(outbox),
      game_added_(std::move(game_added)),
      slots_(static_cast<std::size_t>(welcome.self_play.games_in_flight)),
      agents_(SpecsOf(games_.players())) {}

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
  return PlanFor(*ticket, slot_number);
}

GamePlan TicketHost::PlanFor(std::uint64_t ticket, int slot) {
  GamePlan plan{.ticket = ticket, .setup = games_.SetupFor(ticket), .agents = {}};
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (plan.setup.seats[seat].searches) plan.agents[seat] = AgentFor(plan.setup, seat, slot);
  }
  return plan;
}

SeatedAgent TicketHost::AgentFor(const GameSetup& setup, AgentId seat, int slot) {
  const std::size_t index = setup.seats[seat].player;
  const Player& player = games_.players()[index];
  const bool exam = games_.lineups()[setup.lineup].exam;
  const bool newest = player.weights == PlayerSpec::Weights::kNewest;
  return {.agent = agents_.At(slot, seat, exam ? index + games_.players().size() : index),
          .model = newest ? newest_ : uniform_,
          .takes_new_weights = newest && swaps_at_once_};
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
