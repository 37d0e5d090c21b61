// A picture is equal to the bit on every instruction set. Kernels evaluate each number by a fixed expression, fused
// only where written and never approximate. Sums are added in an order independent of the vector length. Whole pictures
// are compared here; `scalar_kernels_test.cpp` and `scalar_voxels_test.cpp` compare single kernels.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "support/reference/companions.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/scalar_kernels.h"
#include "support/system/sanitized.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kSetsSize{70, 61};

// `stores`: a path, or paths of several volumes.
template <class Stores>
void expectTheSameOnAllSets(const Stores& stores, const FrameRequest& request) {
  const Image best = draw(stores, request);
  EXPECT_TRUE(showsSomething(best));
  onEveryInstructionSet([&](std::int64_t target) {
    EXPECT_TRUE(equalBits(best, draw(stores, request))) << "instruction set " << target;
  });
}

class InstructionSetsFor : public testing::TestWithParam<Lattice> {};

TEST_P(InstructionSetsFor, DrawTheSame) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::i16, VoxelType::f32}) {
    const DenseVolume volume = smallHead(type);
    const auto store = makeStore(volume, "head", 32);
    const ValueRange range = volume.range();
    const auto at = [&](double part) { return range.lo + part * (range.hi - range.lo); };
    FrameRequest request;
    setLattice(request, GetParam());
    request.transfer_function.unit = volume.geometry.meanSpacing();
    request.transfer_function.points = {
        {at(0.1), {1, 0.7, 0.5}, 0}, {at(0.3), {1, 0.7, 0.5}, 0.2}, {at(0.6), {1, 1, 0.8}, 0.7}};
    request.shading.specular = 0.3;
    // Also covers filtered rays, two a pixel.
    request.samples = GetParam() == Lattice::kPixel && type == VoxelType::i16 ? 2 : 1;
    for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
      // Along an axis, where footprints of voxels are axis-aligned, and obliquely.
      for (const glm::dvec3& from : {glm::dvec3(0, -1, 0), glm::dvec3(0.7, -1, 0.4)}) {
        request.view = resolve(cameraFrom(volume.geometry, from, projection), kSetsSize);
        // A coarser level stores intervals of values.
        for (const int level : {0, 1}) {
          if (kSanitized && (level == 1) == (projection == Projection::kPerspective)) continue;
          SCOPED_TRACE(testing::Message()
                       << nameOf(type) << (projection == Projection::kPerspective ? " perspective" : "") << " from "
                       << from.x << ", level " << level);
          request.level = level;
          request.aovs.depth = request.aovs.normal = level == 1;
          expectTheSameOnAllSets(store, request);
        }
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Lattices, InstructionSetsFor, testing::ValuesIn(kLattices));

TEST(InstructionSets, InterpolateTheSame) {
  const DenseVolume volume = smallHead(VoxelType::i16);
  const auto store = makeStore(volume, "head", 32);
  FrameRequest request;
  request.transfer_function.unit = volume.geometry.meanSpacing();
  const ValueRange range = volume.range();
  request.transfer_function.points = {{range.lo, {1, 0.7, 0.5}, 0}, {range.hi, {1, 1, 0.8}, 0.7}};
  request.view = resolve(cameraFrom(volume.geometry, {0.7, -1, 0.4}, Projection::kPerspective), kSetsSize);
  for (const Interpolation interpolation : {Interpolation::kCubic, Interpolation::kCatmullRom}) {
    request.interpolation = interpolation;
    expectTheSameOnAllSets(store, request);
  }
}

TEST(InstructionSets, DrawRegionsAndCloudsTheSame) {
  const DenseVolume volume = smallHead(VoxelType::i16);
  const auto store = makeStore(volume, "head", 32);
  const ValueRange range = volume.range();
  const double width = range.hi - range.lo;
  FrameRequest request;
  TransferFunction& function = request.transfer_function;
  function = {volume.geometry.meanSpacing(), {{range.lo, {1, 0.7, 0.5}, 0}, {range.hi, {1, 1, 0.8}, 0.7}}};
  request.view = resolve(cameraFrom(volume.geometry, {0.7, -1, 0.4}, Projection::kPerspective), kSetsSize);
  GradientRegion colored, own;
  colored.values = {range.lo + 0.3 * width, range.hi}, colored.gradients = {0.02 * width, width};
  colored.color = glm::dvec3(0.2, 0.9, 0.4);
  own.values = {range.lo + 0.2 * width, range.lo + 0.6 * width}, own.gradients = {0, 0.2 * width};
  function.regions = {colored, own};
  expectTheSameOnAllSets(store, request);
  function.regions.clear();
  function.gradient_opacity = {{0, 0.1}, {0.1 * width, 0.4}, {0.3 * width, 1}};
  expectTheSameOnAllSets(store, request);
  function.scattering = {0.9, 0.4};
  request.shading.lights = {Light{}, Light{LightKind::kDirectional, {1, 0.4, 0.6}}};
  request.shading.shadows = true;
  expectTheSameOnAllSets(store, request);
}

TEST(InstructionSets, DrawLabelsTheSame) {
  const DenseVolume volume = fill({{40, 33, 37}, VoxelType::u8}, [](auto x, auto y, auto z) {
    const glm::dvec3 p(x - 20, y - 16, z - 18);
    const double r = glm::length(p);
    return r < 9 ? (p.x < 0.3 * p.z ? 3 : 7) : std::abs(r - 12) < 1.5 && p.y > -4 ? 50 : r < 15 ? 9 : 0;
  });
  const auto store = makeStore(volume, "labels", 16, true);
  FrameRequest request;
  request.transfer_function.labels = {{3, "", {0.8, 0.3, 0.2}, 0.9},
                                      {7, "", {0.2, 0.6, 0.3}, 0.9},
                                      {9, "", {0.9, 0.8, 0.6}, 0.02},
                                      {50, "", {0.3, 0.4, 0.9}, 0.4}};
  request.shading.specular = 0.3;
  request.aovs.depth = request.aovs.normal = true;
  request.view = resolve(cameraFrom(volume.geometry, {0.7, -1, 0.4}, Projection::kPerspective), kSetsSize);
  for (const Lattice lattice : kLattices) {
    request.lattice = lattice;
    for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCubic}) {
      if (lattice == Lattice::kVoxel && interpolation != Interpolation::kLinear) continue;
      SCOPED_TRACE(testing::Message() << nameOf(lattice) << ' ' << static_cast<int>(interpolation));
      request.interpolation = interpolation;
      expectTheSameOnAllSets(store, request);
    }
  }
}

TEST(InstructionSets, DrawMasksAndTheirColorsTheSame) {
  const DenseVolume volume = smallHead(VoxelType::i16);
  const ValueRange range = volume.range();
  const DenseVolume labels = fill({volume.geometry.dims, VoxelType::u8, volume.geometry.world_from_index},
                                  [](auto x, auto y, auto z) { return (x + 2 * y + z) / 12 % 3; });
  const auto store = makeStore(volume, "head", 32), of_labels = makeStore(labels, "labels", 16, true);
  const auto companions = maskedWithValues(store, of_labels, {0, 1}, of_labels);
  FrameRequest request;
  request.view = resolve(cameraFrom(volume.geometry, {0.7, -1, 0.4}, Projection::kPerspective), kSetsSize);
  TransferFunction by_label;
  by_label.labels = {{1, "", {0.2, 0.4, 1}, 1}};
  request.colors = std::make_shared<const CompanionColors>(CompanionColors{by_label, labels.type, labels.range()});
  request.transfer_function.unit = volume.geometry.meanSpacing();
  request.transfer_function.points = {{range.lo, {1, 0.7, 0.5}, 0}, {range.hi, {1, 1, 0.8}, 0.7}};
  expectTheSameOnAllSets(*companions, request);
  request.transfer_function.points.clear();
  for (const double at : {0.2, 0.5})
    request.transfer_function.surfaces.push_back({std::lerp(range.lo, range.hi, at), {1, 0.7, 0.5}, 0.6});
  expectTheSameOnAllSets(*companions, request);
}

TEST(InstructionSets, CompositeSeveralVolumesTheSame) {
  const DenseVolume volume = smallHead(VoxelType::i16);
  const std::vector<std::filesystem::path> stores = {makeStore(volume, "head", 32), makeStore(volume, "other", 16)};
  const ValueRange range = volume.range();
  TransferFunction soft{volume.geometry.meanSpacing(), {{range.lo, {1, 0.7, 0.5}, 0}, {range.hi, {1, 1, 0.8}, 0.2}}};
  TransferFunction hard{volume.geometry.meanSpacing(), {{range.lo, {0.2, 0.7, 1}, 0}, {range.hi, {0.4, 1, 0.8}, 0.9}}};
  FrameRequest request;
  request.view = resolve(cameraFrom(volume.geometry, {0.7, -1, 0.4}, Projection::kPerspective), kSetsSize);
  request.volumes = {{soft, {}, {}}, {hard, {}, {}}};
  request.aovs.depth = request.aovs.normal = true;
  expectTheSameOnAllSets(stores, request);
}

}  // namespace
}  // namespace kiln::test
