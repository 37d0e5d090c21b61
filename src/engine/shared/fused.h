// std::fma of floats where the processor has no instruction for it: the same bits, by doubles. The library's own
// sets the mode of rounding and back, which takes ten times as long.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace kiln {

/// Rounding a sum of doubles to a float as well errs only where the sum has been rounded to halfway between two floats:
/// of those with all 24 bits, where of the 29 bits that go (kGone) the first is set and no other. Those with fewer
/// bits, below 2⁻¹²⁶, have been rounded only where what is added to the product is less than kLeastAddend, and not 0:
/// of a larger one no bit is below a float's last.
struct RoundedTwice {
  static constexpr std::uint64_t kGone = (std::uint64_t{1} << 29) - 1, kHalf = std::uint64_t{1} << 28;
  static constexpr float kLeastAddend = 0x1p-96f;
};

/// a b + c, rounded once.
inline float fusedInDoubles(float a, float b, float c) {
  // Exact: twice 24 bits are fewer than 53.
  const double product = static_cast<double>(a) * static_cast<double>(b), addend = static_cast<double>(c);
  const double sum = product + addend;
  auto bits = std::bit_cast<std::uint64_t>(sum);
  if ((bits & RoundedTwice::kGone) != RoundedTwice::kHalf && (c == 0 || std::abs(c) >= RoundedTwice::kLeastAddend))
    return static_cast<float>(sum);
  // What rounding has taken from the sum (Knuth's two-sum). Where that is anything, the last bit of the sum becomes
  // odd, so that it is not halfway. Of what is infinite or NaN the rest is NaN, and is let be.
  const double of_addend = sum - product;
  const double rest = (product - (sum - of_addend)) + (addend - of_addend);
  if ((rest > 0 || rest < 0) && (bits & 1) == 0) bits += (rest > 0) == (sum > 0) ? 1 : -1;
  return static_cast<float>(std::bit_cast<double>(bits));
}

}  // namespace kiln
