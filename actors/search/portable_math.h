#pragma once

// Functions whose last bit differs between mathematical libraries, from +, * and / alone: the same
// on every machine. Not fast; for what happens a few times per move.

namespace powderkeg {

// ln(1 + x), x >= 0.
[[nodiscard]] double LogOnePlus(double x);

// ln(x), x > 0.
[[nodiscard]] double Log(double x);

// e^x, x <= 0.
[[nodiscard]] double ExpOfNegative(double x);

}  // namespace powderkeg
