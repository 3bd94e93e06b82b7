#include "actors/selfplay/ticket_host.h"

#include <utility>

#include "common/base/check.h"
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
                       std::function<void()> game_added,
                       std::function<std::optional<Model>(std::uint32_t version)> model_of)
    : games_(welcome.self_play),
      swaps_at_once_(welcome.self_play.weights_swap == WeightsSwap::kAtOnce),
      settings_digest_(welcome.settings_digest),
      tickets_(tickets),
      outbox_(outbox),
      game_added_(std::move(game_added)),
      model_of_(std::move(model_of)),
      slots_(static_cast<std::size_t>(welcome.self_play.games_in_flight)),
      agents_(SpecsOf(games_.players())) {}

TicketHost::~TicketHost() {
  for (const Slot& slot : slots_) {
    if (slot.ticket) tickets_.PutBack(*slot.ticket);
  }
}

std::optional<GamePlan> TicketHost::NextGame(int slot_number) {
  if (outbox_.full()) return std::nullopt;
  const std::optional<Grant> grant = tickets_.Take();
  if (!grant) return std::nullopt;
  std::optional<GamePlan> plan = PlanFor(*grant, slot_number);
  if (!plan) {
    tickets_.PutBack(grant->ticket);
    return std::nullopt;
  }
  Slot& slot = slots_[static_cast<std::size_t>(slot_number)];
  slot.ticket = grant->ticket;
  slot.start = std::chrono::steady_clock::now();
  return plan;
}

std::optional<GamePlan> TicketHost::PlanFor(const Grant& grant, int slot) {
  GamePlan plan{.ticket = grant.ticket, .setup = games_.SetupFor(grant.ticket), .agents = {}};
  const bool exam = games_.lineups()[plan.setup.lineup].exam;
  for (AgentId seat = 0; seat < kAgentCount; ++seat) {
    if (!plan.setup.seats[seat].searches) continue;
    const std::size_t player = plan.setup.seats[seat].player;
    const std::optional<Model> model = ModelOf(player, grant);
    if (!model) return std::nullopt;
    const bool newest = games_.players()[player].weights == PlayerSpec::Weights::kNewest;
    plan.agents[seat] = {
        .agent = agents_.At(slot, seat, exam ? player + games_.players().size() : player),
        .model = *model,
        .takes_new_weights = newest && swaps_at_once_};
  }
  return plan;
}

std::optional<Model> TicketHost::ModelOf(std::size_t player, const Grant& grant) const {
  switch (games_.players()[player].weights) {
    case PlayerSpec::Weights::kNone: return uniform_;
    case PlayerSpec::Weights::kNewest: return newest_;
    case PlayerSpec::Weights::kPast:
      return grant.past_version == 0 ? newest_ : model_of_(grant.past_version);
    case PlayerSpec::Weights::kFile: return model_of_(FileVersion(player));
  }
  CHECK(false, player);
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
