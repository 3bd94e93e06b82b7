#include "actors/search/portable_math.h"

namespace powderkeg {

// As 2 artanh(x / (2 + x)), after halving 1 + x until it is at most 2.
double LogOnePlus(double x) {
  int halvings = 0;
  double argument = 1 + x;
  while (argument > 2) {
    argument /= 2;
    ++halvings;
  }
  const double z = (argument - 1) / (argument + 1);
  double power = z;
  double sum = 0;
  for (int n = 1; n < 40; n += 2) {
    sum += power / n;
    power *= z * z;
  }
  constexpr double kLogOfTwo = 0.69314718055994530942;
  return 2 * sum + halvings * kLogOfTwo;
}

double Log(double x) { return x >= 1 ? LogOnePlus(x - 1) : -LogOnePlus(1 / x - 1); }

// As (e^(x / 2^k))^(2^k), the inner one by its series.
double ExpOfNegative(double x) {
  constexpr double kUnderflow = -700;
  if (x < kUnderflow) return 0;
  int squarings = 0;
  for (; x < -0.5; x /= 2) ++squarings;
  double term = 1;
  double sum = 1;
  for (int n = 1; n < 18; ++n) {
    term *= x / n;
    sum += term;
  }
  for (; squarings > 0; --squarings) sum *= sum;
  return sum;
}

}  // namespace powderkeg
