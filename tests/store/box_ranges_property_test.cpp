// Known because the minimum and maximum of a few voxels are computed by a plain loop.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "store/ranges/box_ranges.h"

namespace kiln {
namespace {

template <class T>
class BoxRanges : public testing::Test {};
using BoxRangesTypes =
    testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, float, double>;
TYPED_TEST_SUITE(BoxRanges, BoxRangesTypes);

template <class T>
VoxelType voxelTypeOf() {
  VoxelType out = VoxelType::u8;
  for (const VoxelType type : {VoxelType::u8, VoxelType::i8, VoxelType::u16, VoxelType::i16, VoxelType::u32,
                               VoxelType::i32, VoxelType::f32, VoxelType::f64})
    withVoxelType(type, [&]<class U>(std::type_identity<U>) { out = std::is_same_v<T, U> ? type : out; });
  return out;
}

// Volumes narrower and wider than a vector step; spans that overlap, cover the whole edge or are empty; and regions of
// NaN only.
TYPED_TEST(BoxRanges, AreThoseOfTheVoxels) {
  std::mt19937 random(7);
  const auto below = [&](std::int64_t n) { return static_cast<std::int64_t>(random() % static_cast<unsigned>(n)); };
  for (int round = 0; round < 40; ++round) {
    const VoxelCoord lo{below(9) - 4, below(9) - 4, below(9) - 4};
    const VoxelBox box{lo, {lo.x + 1 + below(90), lo.y + 1 + below(12), lo.z + 1 + below(12)}};
    std::vector<TypeParam> values(static_cast<std::size_t>(box.extent().count()));
    for (TypeParam& value : values) value = static_cast<TypeParam>(static_cast<int>(random() % 200) - 100);
    if constexpr (std::is_floating_point_v<TypeParam>) {
      const auto more = random() % 4;
      for (TypeParam& value : values) value = random() % 4 < more ? std::nan("") : value;
      for (const int sign : {-1, 1})
        values[random() % values.size()] = static_cast<TypeParam>(sign) * std::numeric_limits<TypeParam>::infinity();
    }
    std::array<std::vector<VoxelSpan>, 3> spans;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t edge = box.hi[axis] - box.lo[axis];
      std::vector<VoxelSpan>& along = spans[static_cast<std::size_t>(axis)];
      along = {{box.lo[axis], box.hi[axis]}, {box.hi[axis] - 1, box.hi[axis]}, {box.lo[axis], box.lo[axis]}};
      for (int i = 0; i < 3; ++i) {
        const std::int64_t first = box.lo[axis] + below(edge);
        along.push_back({first, first + 1 + below(box.hi[axis] - first)});
      }
    }
    std::vector<std::byte> bytes(values.size() * sizeof values[0]);
    std::memcpy(bytes.data(), values.data(), bytes.size());
    const std::vector<ValueRange> ranges = boxRanges(bytes, voxelTypeOf<TypeParam>(), box, spans);
    ASSERT_EQ(ranges.size(), spans[0].size() * spans[1].size() * spans[2].size());
    auto range = ranges.begin();
    for (const VoxelSpan& z : spans[2]) {
      for (const VoxelSpan& y : spans[1]) {
        for (const VoxelSpan& x : spans[0]) {
          ValueRange expected;
          for (std::int64_t k = z.lo; k < z.hi; ++k) {
            for (std::int64_t j = y.lo; j < y.hi; ++j) {
              for (std::int64_t i = x.lo; i < x.hi; ++i) {
                const Extent3 n = box.extent();
                const auto at = ((k - box.lo.z) * n.y + j - box.lo.y) * n.x + i - box.lo.x;
                const auto value = static_cast<double>(values[static_cast<std::size_t>(at)]);
                if (!std::isnan(value)) expected.include({value, value});
              }
            }
          }
          ASSERT_EQ(range->empty(), expected.empty());
          if (!expected.empty()) {
            ASSERT_EQ(range->lo, expected.lo);
            ASSERT_EQ(range->hi, expected.hi);
          }
          ++range;
        }
      }
    }
  }
}

}  // namespace
}  // namespace kiln
