#pragma once

// Games from the sessions into the pipeline, and what became of them back.

#include <cstddef>
#include <cstdint>
#include <map>

#include "common/base/log_budget.h"
#include "common/wire/messages.h"
#include "learner/intake/game_pipeline.h"
#include "learner/intake/peer_table.h"
#include "learner/intake/ticket_desk.h"
#include "learner/intake/ticket_office.h"

namespace powderkeg {

// Of games, since the start.
struct GameCounters {
  std::uint64_t games = 0;       // made durable
  std::uint64_t decisions = 0;   // in those
  std::uint64_t duplicates = 0;  // games that were durable already
  std::uint64_t rejected = 0;
  std::uint64_t other_settings = 0;  // durable games played under other settings of the search
  std::size_t pending_games = 0;     // received, not yet durable
  std::size_t pending_bytes = 0;     // their records
};

// Answers with messages, sends nothing. One thread.
class GameDesk {
 public:
  // All must outlive it.
  GameDesk(TicketOffice& office, TicketDesk& tickets, PeerTable& peers, GamePipeline& pipeline)
      : office_(office), tickets_(tickets), peers_(peers), pipeline_(pipeline) {}

  // Puts a game into the pipeline, or its answer into the ack. False: the pipeline is full, or the
  // session has no right to send so many.
  [[nodiscard]] bool Admit(Session& session, SealedGame game, Ack& ack);

  // Settles what the pipeline is done with; the answers by session.
  [[nodiscard]] std::map<SessionId, Ack> Settle();

  [[nodiscard]] const GameCounters& counters() const { return counters_; }

 private:
  void Settle(const Verdict& verdict);
  void Answer(Session& session, const Verdict& verdict, Ack& ack);

  TicketOffice& office_;
  TicketDesk& tickets_;
  PeerTable& peers_;
  GamePipeline& pipeline_;
  GameCounters counters_;
  log::Budget log_budget_;
};

}  // namespace powderkeg
