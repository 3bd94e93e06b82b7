#pragma once

// What somebody who mistyped a name may have meant.

#include <span>
#include <string>
#include <string_view>

namespace powderkeg {

// The known name that `name` begins, or that the fewest changes of a character make of it; empty if
// no name is near: more than a third of its characters would change.
[[nodiscard]] std::string_view NearestName(std::string_view name,
                                           std::span<const std::string_view> known);

// "; did you mean NEAREST?", or nothing.
[[nodiscard]] std::string DidYouMean(std::string_view name,
                                     std::span<const std::string_view> known);

}  // namespace powderkeg
