#include "learner/replay/prefix.h"

#include "common/base/check.h"

namespace powderkeg {

bool TicketPrefix::Add(std::uint64_t ticket, std::uint32_t decisions) {
  if (ticket < next_ticket_ || !unused_.emplace(ticket, decisions).second) return false;
  decisions_ += decisions;
  if (ticket == first_missing_) ExtendPrefix();
  return true;
}

void TicketPrefix::ExtendPrefix() {
  for (auto game = unused_.find(first_missing_);
       game != unused_.end() && game->first == first_missing_; ++game) {
    decisions_in_prefix_ += game->second;
    ++first_missing_;
  }
}

std::optional<TicketRange> TicketPrefix::NextDataSet(std::uint64_t decisions) {
  CHECK(decisions > 0);
  if (decisions_in_prefix_ < decisions) return std::nullopt;
  TicketRange range{next_ticket_, next_ticket_};
  auto game = unused_.begin();
  std::uint64_t taken = game->second;
  while (taken < decisions) taken += (++game)->second;
  range.last = game->first;
  unused_.erase(unused_.begin(), std::next(game));
  decisions_in_prefix_ -= taken;
  decisions_ -= taken;
  next_ticket_ = range.last + 1;
  return range;
}

void TicketPrefix::PassOver() {
  for (auto& [ticket, decisions] : unused_) decisions = 0;
  decisions_in_prefix_ = decisions_ = 0;
}

TicketPrefix::Progress TicketPrefix::progress() const {
  Progress progress{.decisions_in_prefix = decisions_in_prefix_,
                    .decisions = decisions_,
                    .games = unused_.size(),
                    .straggler = std::nullopt};
  if (!unused_.empty() && unused_.rbegin()->first >= first_missing_) {
    progress.straggler = first_missing_;
  }
  return progress;
}

}  // namespace powderkeg
