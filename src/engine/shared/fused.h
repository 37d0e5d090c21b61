// std::fma of floats in double arithmetic, with equal bits, for processors without the instruction. The library's
// version switches the rounding mode and takes ten times as long.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace kiln {

/// Conditions under which rounding first to double and then to float can differ from a single rounding.
/// Normal floats (24 bits): only if the double lies halfway between two floats. Of its 29 discarded bits (kGone) then
/// only the first is set (kHalf).
/// Subnormal floats (below 2⁻¹²⁶): only if 0 < |addend| < kLeastAddend. With a larger addend the sum has no bit below
/// the last bit of a float, and with an addend of 0 the product is exact.
struct RoundedTwice {
  static constexpr std::uint64_t kGone = (std::uint64_t{1} << 29) - 1, kHalf = std::uint64_t{1} << 28;
  static constexpr float kLeastAddend = 0x1p-96f;
};

/// Returns a b + c, rounded once.
inline float fusedInDoubles(float a, float b, float c) {
  // Exact: a product of two 24-bit numbers has at most 48 bits, and a double has 53.
  const double product = static_cast<double>(a) * static_cast<double>(b), addend = static_cast<double>(c);
  const double sum = product + addend;
  auto bits = std::bit_cast<std::uint64_t>(sum);
  if ((bits & RoundedTwice::kGone) != RoundedTwice::kHalf && (c == 0 || std::abs(c) >= RoundedTwice::kLeastAddend))
    return static_cast<float>(sum);
  // Rounding error of the sum (Knuth's two-sum). If the error is not zero, the sum's last bit is made odd, so that the
  // sum is not halfway. An infinite or NaN sum has a NaN error and stays unchanged.
  const double of_addend = sum - product;
  const double rest = (product - (sum - of_addend)) + (addend - of_addend);
  if ((rest > 0 || rest < 0) && (bits & 1) == 0) bits += (rest > 0) == (sum > 0) ? 1 : -1;
  return static_cast<float>(std::bit_cast<double>(bits));
}

}  // namespace kiln
