#include "common/base/name.h"

#include <algorithm>

#include "common/base/check.h"

namespace powderkeg {
namespace {

constexpr std::size_t kLongestName = 64;

bool IsNameCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

}  // namespace

bool IsName(std::string_view text) {
  return !text.empty() && text.size() <= kLongestName && text.front() != '.' &&
         std::ranges::all_of(text, IsNameCharacter);
}

void RequireName(std::string_view what, std::string_view text) {
  if (IsName(text)) return;
  throw Error(StrCat(what, " is '", text, "', expected 1 to ", kLongestName,
                     " letters, digits, '.', '_' and '-', not '.' first"));
}

}  // namespace powderkeg
