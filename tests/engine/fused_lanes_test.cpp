// The kernels' vector fused() equals std::fma in each lane, to the bit, also on processors without an FMA instruction.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "support/volumes/procedural.h"

// All instruction sets of the kernels, except the scalar set, which uses fusedInDoubles.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/fused_lanes_test.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// shape: sixteen of each.
void fuseSixteen(const float* a, const float* b, const float* c, float* out) {
  const D d;
  for (std::size_t i = 0; i < 16; i += hn::Lanes(d))
    hn::Store(fused(hn::LoadU(d, a + i), hn::LoadU(d, b + i), hn::LoadU(d, c + i)), d, out + i);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(fuseSixteen);

namespace test {
namespace {

using Sixteen = std::array<float, 16>;

void expectFused(const Sixteen& a, const Sixteen& b, const Sixteen& c) {
  alignas(64) Sixteen found;
  HWY_DYNAMIC_DISPATCH(fuseSixteen)(a.data(), b.data(), c.data(), found.data());
  for (std::size_t i = 0; i < 16; ++i) {
    const float truth = std::fma(a[i], b[i], c[i]);
    if (std::isnan(truth)) {
      EXPECT_TRUE(std::isnan(found[i])) << a[i] << " " << b[i] << " " << c[i];
    } else {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(found[i]), std::bit_cast<std::uint32_t>(truth))
          << a[i] << " " << b[i] << " " << c[i];
    }
  }
}

// Mixes lanes of several kinds: random bits, sums that nearly cancel, and sums close to halfway between two floats.
void expectFusedLanes() {
  constexpr float kInf = std::numeric_limits<float>::infinity(), kMost = std::numeric_limits<float>::max();
  constexpr float kOdd[] = {0.0f, -0.0f, 1.0f, -1.0f, kMost, kInf, -kInf, 0x1p-149f};
  for (std::uint64_t i = 0; i < 10000; ++i) {
    Sixteen a, b, c;
    for (std::size_t lane = 0; lane < 16; ++lane) {
      const auto bits = [&](std::uint64_t n) { return static_cast<std::uint32_t>(hashBits(n, 16 * i + lane)); };
      const auto near = [&](std::uint64_t n, int spread) {
        const int exponent = static_cast<int>(bits(n + 1) % static_cast<unsigned>(2 * spread)) - spread;
        return std::ldexp(1 + static_cast<float>(bits(n) >> 9) * 0x1p-23f, exponent);
      };
      // Most vectors hold a single kind, as in pictures.
      switch (i % 3 == 0 ? bits(9) % 5 : static_cast<unsigned>(i % 5)) {
        case 0:
          a[lane] = std::bit_cast<float>(bits(0)), b[lane] = std::bit_cast<float>(bits(1)),
          c[lane] = std::bit_cast<float>(bits(2));
          break;
        case 1:
          a[lane] = near(0, 4), b[lane] = near(2, 4), c[lane] = bits(4) & 1 ? -a[lane] * b[lane] : near(5, 40);
          break;
        case 2:
          a[lane] = 1 + static_cast<float>(bits(0) & 0xfff) * 0x1p-12f;
          b[lane] = 1 + static_cast<float>(bits(1) & 0xfff) * 0x1p-12f;
          c[lane] = (bits(2) & 1 ? 1.0f : -1.0f) * std::ldexp(1.0f, -30 - static_cast<int>(bits(3) % 60));
          break;
        case 3:  // of fewer bits than 24, and halfway but for a little
          a[lane] = std::ldexp(1 + 0x1p-23f, -75), b[lane] = std::ldexp(1 - 0x1p-23f, -75);
          c[lane] = static_cast<float>(2 * (bits(0) & 0x3ffff) + 1) * 0x1p-149f;
          break;
        default:
          a[lane] = kOdd[bits(0) % 8], b[lane] = kOdd[bits(1) % 8], c[lane] = kOdd[bits(2) % 8];
      }
    }
    expectFused(a, b, c);
  }
}

TEST(Fused, LanesAreRoundedOnce) {
  for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
    hwy::SetSupportedTargetsForTest(rest & -rest);
    SCOPED_TRACE(hwy::TargetName(rest & -rest));
    expectFusedLanes();
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace
}  // namespace test
}  // namespace kiln
#endif
