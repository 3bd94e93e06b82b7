#pragma once

// Names that people give to runs and actors, and that become files and folders.

#include <string_view>

namespace powderkeg {

// Whether it is 1 to 64 letters, digits, '.', '_' and '-', not '.' first: so it is neither hidden
// nor "..", and leads into no other folder.
[[nodiscard]] bool IsName(std::string_view text);

// Throws Error, with `what` it names, if it is none.
void RequireName(std::string_view what, std::string_view text);

}  // namespace powderkeg
