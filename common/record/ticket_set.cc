#include "common/record/ticket_set.h"

#include <algorithm>

#include "common/base/check.h"

namespace powderkeg {

std::string TicketsText(std::vector<std::uint64_t> tickets) {
  std::ranges::sort(tickets);
  std::string text;
  for (std::size_t first = 0; first < tickets.size();) {
    std::size_t end = first + 1;
    while (end < tickets.size() && tickets[end] - tickets[first] == end - first) ++end;
    text += StrCat(text.empty() ? "" : " ", tickets[first]);
    if (end > first + 1) text += StrCat("-", tickets[end - 1]);
    first = end;
  }
  return text.empty() ? "none" : text;
}

}  // namespace powderkeg
