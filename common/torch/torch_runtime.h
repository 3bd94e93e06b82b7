#pragma once

// Settings of LibTorch that hold for the whole process.

namespace powderkeg {

// Sets the number of threads that one operation uses, keeps operations from running beside each
// other, and keeps the memory of freed tensors (page faults otherwise take two thirds of the time
// on CPUs). Call before the first tensor operation; a later call changes the threads alone.
void InitialiseTorch(int threads);

}  // namespace powderkeg
