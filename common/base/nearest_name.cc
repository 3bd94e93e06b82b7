#include "common/base/nearest_name.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "common/base/check.h"

namespace powderkeg {
namespace {

// Changes of one character that make one text the other.
std::size_t EditDistance(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t replaced = diagonal + (from[i] == to[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string_view NearestName(std::string_view name, std::span<const std::string_view> known) {
  constexpr std::size_t kLongest = 64;  // of a name that could be meant
  if (name.empty() || name.size() > kLongest) return {};
  std::string_view nearest;
  std::size_t least = kLongest;
  for (const std::string_view other : known) {
    const bool begun = name.size() > 1 && other.starts_with(name);
    const std::size_t distance = begun ? 1 : EditDistance(name, other);
    const bool near = distance <= (std::max(name.size(), other.size()) + 2) / 3;
    if (!near || distance >= least) continue;
    nearest = other;
    least = distance;
  }
  return nearest;
}

std::string DidYouMean(std::string_view name, std::span<const std::string_view> known) {
  const std::string_view nearest = NearestName(name, known);
  return nearest.empty() ? "" : StrCat("; did you mean ", nearest, "?");
}

}  // namespace powderkeg
