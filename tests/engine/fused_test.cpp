// The fallback without an FMA instruction equals std::fma to the bit. Known because std::fma is defined to round once.
#include "engine/shared/fused.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {

void expectFused(float a, float b, float c) {
  const float found = fusedInDoubles(a, b, c), truth = std::fma(a, b, c);
  if (std::isnan(truth)) {
    EXPECT_TRUE(std::isnan(found)) << a << " " << b << " " << c;
  } else {
    EXPECT_EQ(std::bit_cast<std::uint32_t>(found), std::bit_cast<std::uint32_t>(truth)) << a << " " << b << " " << c;
  }
}

// Random bits, sums that nearly cancel, and sums with an addend near the last bits of the product, where rounding twice
// errs.
TEST(Fused, InDoublesIsRoundedOnce) {
  int twice = 0;  // number of cases where rounding twice gives another result
  for (std::uint64_t i = 0; i < 300000; ++i) {
    const auto bits = [&](std::uint64_t n) { return static_cast<std::uint32_t>(hashBits(n, i)); };
    const auto any = [&](std::uint64_t n) { return std::bit_cast<float>(bits(n)); };
    const auto near = [&](std::uint64_t n) {
      return std::ldexp(1 + static_cast<float>(bits(n) >> 9) * 0x1p-23f, static_cast<int>(bits(n + 1) % 60) - 30);
    };
    expectFused(any(0), any(1), any(2));
    // Close to halfway between two floats: a and b have few bits, and c is far below the product's last bit.
    const float a = 1 + static_cast<float>(bits(3) & 0xfff) * 0x1p-12f,
                b = 1 + static_cast<float>(bits(4) & 0xfff) * 0x1p-12f;
    const float c = (bits(5) & 1 ? 1.0f : -1.0f) * std::ldexp(1.0f, -30 - static_cast<int>(bits(6) % 60));
    expectFused(a, b, c);
    twice += static_cast<float>(static_cast<double>(a) * static_cast<double>(b) + static_cast<double>(c)) !=
                     std::fma(a, b, c)
                 ? 1
                 : 0;
    // Close to halfway, with a subnormal result of fewer than 24 bits.
    expectFused(0x1.000002p-75f, 0x1.fffffcp-76f, static_cast<float>(2 * (bits(5) & 0x3ffff) + 1) * 0x1p-149f);
    expectFused(near(7), near(9), near(11));
    expectFused(near(7), near(9), -near(7) * near(9));
    expectFused(any(0), 0x1p-100f, 0x1p-149f);
  }
  EXPECT_GT(twice, 100);
  const float inf = std::numeric_limits<float>::infinity(), most = std::numeric_limits<float>::max();
  for (const float a : {0.0f, -0.0f, 1.0f, -1.0f, most, inf, -inf, std::nanf("")}) {
    for (const float b : {0.0f, -0.0f, 1.0f, -1.0f, most, inf, 0x1p-149f}) {
      for (const float c : {0.0f, -0.0f, 1.0f, -most, most, inf, -inf, -0x1p-149f}) expectFused(a, b, c);
    }
  }
}

}  // namespace
}  // namespace kiln::test
