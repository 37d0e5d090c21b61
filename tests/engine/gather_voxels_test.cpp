// Gathering of a cell's visible voxels against loops over the cell, for all types and instruction sets. Cases: whole
// cells and cells cut by a brick's end; parallel views and an eye among the voxels; transfer functions visible in a
// single interval, in several, and nowhere.
#include "engine/voxel/gather_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "support/reference/scalar_kernels.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {

constexpr VoxelCoord kExtent = {6, 5, 7};  // extent of the core; no multiple of a cell

BrickBlock gatheredBlock(VoxelType type) {
  BrickBlock block;
  block.type = type;
  block.core = {{10, 20, 30}, {10 + kExtent.x, 20 + kExtent.y, 30 + kExtent.z}};
  block.extent = dilated(block.core, 1);
  block.voxels.resize(static_cast<std::size_t>(block.extent.count()) * sizeOf(type));
  withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    T* const voxels = reinterpret_cast<T*>(block.voxels.data());
    for (std::int64_t i = 0; i < block.extent.count(); ++i)
      voxels[i] = static_cast<T>(120 * hashUnit(11, static_cast<std::uint64_t>(i)));
    if constexpr (std::is_floating_point_v<T>) voxels[block.offsetOf({12, 21, 32})] = NAN;
  });
  return block;
}

TransferFunction withOpacities(const std::vector<std::pair<double, double>>& opacities) {
  TransferFunction out;
  for (const auto& [value, opacity] : opacities)
    out.points.push_back({value, {value / 120, 0.25, 1 - value / 120}, opacity});
  return out;
}

TransferFunction ofSomeLabels() {
  TransferFunction out;
  for (const double label : {3.0, 40.0, 41.0, 90.0}) out.labels.push_back({label, "", {0.1, 0.2, 0.3}, label / 100});
  return out;
}

// Returns the cell's visible voxels, front to back.
template <class T>
std::vector<VoxelCoord> shownIn(const BrickBlock& block, const Classifier& classifier, const VisitingOrder& visiting,
                                const VoxelBox& cell) {
  std::uint8_t order[3][kSplatCellSize];
  for (int axis = 0; axis < 3; ++axis)
    visiting.axisOrder(axis, cell.lo[axis], static_cast<int>(cell.hi[axis] - cell.lo[axis]), order[axis]);
  std::vector<VoxelCoord> out;
  const Extent3 extent = cell.extent();
  for (int k = 0; k < extent.z; ++k) {
    for (int j = 0; j < extent.y; ++j) {
      for (int i = 0; i < extent.x; ++i) {
        const VoxelCoord v = {cell.lo.x + order[0][i], cell.lo.y + order[1][j], cell.lo.z + order[2][k]};
        const T value = block.data<T>()[block.offsetOf(v)];
        if (!std::isnan(static_cast<double>(value)) && classifier.at(value).tau > 0) out.push_back(v);
      }
    }
  }
  return out;
}

template <class T>
float slopeAt(const BrickBlock& block, const Classifier& classifier, const VoxelCoord& v, int axis) {
  VoxelCoord before = v, after = v;
  --before[axis], ++after[axis];
  const auto value = [&](const VoxelCoord& at) {
    const auto found = static_cast<double>(block.data<T>()[block.offsetOf(at)]);
    return classifier.ofLabels() ? static_cast<double>(classifier.opacityOf(found)) : found;
  };
  return static_cast<float>(0.5 * (value(after) - value(before)));
}

template <class T>
void expectGathered(const BrickBlock& block, const Classifier& classifier, const VisitingOrder& visiting,
                    const VoxelBox& cell) {
  const std::vector<VoxelCoord> truth = shownIn<T>(block, classifier, visiting, cell);
  FoundVoxels found;
  findVoxels(classifier, visiting, block, cell, found);
  ASSERT_EQ(static_cast<std::size_t>(found.count), truth.size());
  for (int n = 0; n < found.count; ++n) EXPECT_EQ(voxelAt(cell.lo, found.codes[n]), truth[static_cast<std::size_t>(n)]);
  for (int first = 0; first < found.count; first += kVoxelBatch) {
    const int count = std::min(found.count - first, kVoxelBatch);
    for (const std::uint32_t of_batch : {0xffffu, 0x8421u, 0x0010u}) {
      const std::uint32_t drawn = of_batch & ((1u << count) - 1);
      ShadedVoxels taken;
      takeVoxels(classifier, block, found, first, drawn, true, taken);
      for (int n = 0; n < count; ++n) {
        if ((drawn >> n & 1) == 0) continue;
        const VoxelCoord& v = truth[static_cast<std::size_t>(first + n)];
        const Material material = classifier.at(block.data<T>()[block.offsetOf(v)]);
        const float* const m = taken.material + 4 * n;
        EXPECT_EQ(std::vector<float>(m, m + 4), (std::vector<float>{material.r, material.g, material.b, material.tau}));
        for (int axis = 0; axis < 3; ++axis) {
          const float slope = slopeAt<T>(block, classifier, v, axis);
          if (std::isnan(slope))
            EXPECT_TRUE(std::isnan(taken.slope[axis][n]));
          else
            EXPECT_FLOAT_EQ(taken.slope[axis][n], slope);
        }
      }
    }
  }
}

TEST(GatherVoxels, AreThoseThatShowSomethingFrontToBack) {
  const TransferFunction functions[] = {
      withOpacities({{30, 0.0}, {50, 0.5}, {200, 0.5}}),                        // visible from a value on
      withOpacities({{30, 0.0}, {50, 0.5}, {70, 0.0}}),                         // visible between two values
      withOpacities({{30, 0.0}, {40, 0.5}, {50, 0.0}, {80, 0.0}, {90, 0.25}}),  // visible in two intervals
      withOpacities({{0, 0.0}, {120, 0.0}}),
      withOpacities({{0, 0.5}, {120, 1.0}}),  // nowhere, everywhere
      ofSomeLabels()};
  const VisitingOrder orders[] = {VisitingOrder::parallel({1, 1, 1}), VisitingOrder::parallel({-0.5, 0.2, -1}),
                                  VisitingOrder::fromEye({12.2, 21.7, 33.1}), VisitingOrder::fromEye({-50, 60, 31})};
  constexpr VoxelType kTypes[] = {VoxelType::u8,  VoxelType::i8,  VoxelType::u16, VoxelType::i16,
                                  VoxelType::u32, VoxelType::i32, VoxelType::f32, VoxelType::f64};
  onEveryInstructionSet([&](std::int64_t target) {
    for (const VoxelType type : kTypes) {
      const BrickBlock block = gatheredBlock(type);
      for (std::size_t f = 0; f < std::size(functions); ++f) {
        const Classifier classifier(functions[f], 1, type, {0, 120});
        for (std::size_t o = 0; o < std::size(orders); ++o) {
          SCOPED_TRACE(::testing::Message()
                       << nameOf(type) << ", function " << f << ", order " << o << ", instruction set " << target);
          for (const VoxelCoord& lo : {VoxelCoord{10, 20, 30}, VoxelCoord{12, 21, 33}, VoxelCoord{14, 24, 34}}) {
            const VoxelBox cell =
                intersection({lo, {lo.x + kSplatCellSize, lo.y + kSplatCellSize, lo.z + kSplatCellSize}}, block.core);
            withVoxelType(
                type, [&]<class T>(std::type_identity<T>) { expectGathered<T>(block, classifier, orders[o], cell); });
          }
        }
      }
    }
  });
}

TEST(GatherVoxels, OneIntervalShowsOrNone) {
  const auto intervalOf = [](const TransferFunction& function) {
    return Classifier(function, 1, VoxelType::i16, {-10, 120}).shownInterval();
  };
  const auto between = intervalOf(withOpacities({{30, 0.0}, {50, 0.5}, {70, 0.0}}));
  ASSERT_TRUE(between);
  EXPECT_EQ(between->lo, 31);
  EXPECT_EQ(between->hi, 69);
  const auto all = intervalOf(withOpacities({{0, 0.5}}));
  ASSERT_TRUE(all);
  EXPECT_EQ(all->lo, -10);
  EXPECT_EQ(all->hi, 120);
  EXPECT_FALSE(intervalOf(withOpacities({{0, 0.0}})));
  EXPECT_FALSE(intervalOf(withOpacities({{0, 0.5}, {10, 0.0}, {20, 0.0}, {30, 0.5}})));
}

}  // namespace
}  // namespace kiln::test
