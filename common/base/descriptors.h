#pragma once

// File descriptors are few: whoever connects takes one, and files must still be opened.

#include <cstddef>

namespace powderkeg {

// Raises the process's limit as far as it may, but for a reserve that is there within
// ReservedDescriptors alone. Throws Error if they are too few to work with.
void AllowManyDescriptors();

// How many the process may have.
[[nodiscard]] std::size_t DescriptorLimit();

// While one lives the calling thread may open files from the reserve (so may others: let it live no
// longer than that takes). Does nothing without AllowManyDescriptors. Thread-safe.
class ReservedDescriptors {
 public:
  ReservedDescriptors();
  ~ReservedDescriptors();
  ReservedDescriptors(const ReservedDescriptors&) = delete;
  ReservedDescriptors& operator=(const ReservedDescriptors&) = delete;
};

}  // namespace powderkeg
