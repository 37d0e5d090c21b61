// Skipping cells of an empty range changes nothing, for every interpolation. A picture that draws each cell of a single
// brick equals the picture of every store to the bit. The volume is constant except for single voxels above and below.
// Only values between the constant and these voxels are visible, so many cells contain only what a cubic filter adds
// two voxels away.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <span>

#include "engine/pixel/ray_caster.h"
#include "engine/pixel/zone_contexts.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"
#include "traverse/frame_levels.h"

namespace kiln::test {
namespace {

constexpr std::int64_t kEveryBrick[] = {64, 32, 16};  // 64 gives a single brick
constexpr std::span kBricks(kEveryBrick, casesOf(3, 2));

// Makes values visible on one side of the constant.
TransferFunction beside(double lo, double hi) {
  const glm::dvec3 color(0.9, 0.8, 0.7);
  return {1, {{lo, color, 0}, {(lo + hi) / 2, color, 0.6}, {hi, color, 0}}};
}

std::vector<SlabCell> allCells(const SlabContext& frame, const BrickBlock& block) {
  std::vector<SlabCell> out;
  const VoxelBox& core = block.core;
  const VisitingOrder& order = frame.projector().order();
  const int n = static_cast<int>(core.hi.x + kCellSize - 1) / kCellSize;
  std::array<std::vector<std::uint8_t>, 3> along;
  for (int a = 0; a < 3; ++a) {
    std::vector<std::uint8_t>& places = along[static_cast<std::size_t>(a)];
    places.resize(static_cast<std::size_t>(n));
    order.axisOrder(a, 0, n, places.data(), kCellSize);
  }
  for (const std::int64_t z : along[2]) {
    for (const std::int64_t y : along[1]) {
      for (const std::int64_t x : along[0]) {
        const VoxelCoord lo = {x * kCellSize, y * kCellSize, z * kCellSize};
        const VoxelBox cell = intersection({lo, {lo.x + kCellSize, lo.y + kCellSize, lo.z + kCellSize}}, core);
        if (cell.empty()) continue;
        out.push_back({cell, frame.boundsOf(cell)});
        if (out.back().rect.empty()) out.pop_back();
      }
    }
  }
  return out;
}

// Draws the only brick with all its cells.
Image drawnWhole(const std::filesystem::path& path, const FrameRequest& request, std::size_t& skipped) {
  const StoreReader store(path);
  const Manifest& volume = store.manifest();
  const View view = drawnView(request.view, volume.geometry());
  const FrameLevels levels(volume, 0, view, ProjectedArea::kBox);
  const double unit = request.transfer_function.unit;
  const SampleTable table(request.transfer_function, unit, volume.type, volume.range);
  const auto noise = static_cast<float>(kGradientNoise * (volume.range.hi - volume.range.lo));
  const GradientSense gradients{noise, noise};
  const auto visibility = makeMaskVisibility(request.view.size.width, request.view.size.height);
  const BrickBlock block = store.read({0, {0, 0, 0}});
  Image image(request.view.size.width, request.view.size.height);
  const TilePixels tile{{0, 0, image.width, image.height}, image.pixel(0, 0), std::ptrdiff_t{4} * image.width, {}};
  DrawCounts counts;
  const Projector& projector = levels.projector(0);
  const std::vector<SlabZone> zones = slabZones(zonedVolume(volume, levels, request.sampling()), view, 0);
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const SlabZone& zone = zones[i];
    const Appearance look{request.shading, Shader(request.shading, view, gradients, projector), &levels.clipRegion(0),
                          gradients, request.interpolation};
    const SlabContext frame(zone, projector, levels.dims(0), table, look);
    const std::vector<SlabCell> cells = allCells(frame, block);
    skipped += cells.size() - visibleCells(frame, block).size();
    const RaySampling rays(zones, i, projector, levels.dims(0), levels.endVoxels(0));
    castRays(rays, frame, block, cells, tile, *visibility, static_cast<float>(request.opacity_threshold), counts);
  }
  return image;
}

class Skipping : public ::testing::TestWithParam<std::tuple<Interpolation, Projection>> {};

TEST_P(Skipping, ChangesNoBit) {
  const auto [interpolation, projection] = GetParam();
  const DenseVolume volume = specks();
  std::vector<std::filesystem::path> stores;
  for (const std::int64_t brick : kBricks)
    stores.push_back(makeStore(volume, "specks_of_" + std::to_string(brick), brick));
  for (const double px_per_voxel : {0.45, 1.6, 3.1}) {
    if (kSanitized && px_per_voxel == 1.6) continue;
    FrameRequest request;
    request.interpolation = interpolation;
    request.level = 0;
    request.filters_rays = false;
    Camera camera = cameraFrom(volume.geometry, {0.4, -1, 0.6}, projection);
    camera.height = 80 / px_per_voxel;
    camera.fov_deg *= camera.height / 70;
    request.view = resolve(camera, {64, 60});
    for (const auto& [lo, hi] : {std::array{126.0, 128.0}, std::array{128.0, 130.0}}) {
      SCOPED_TRACE(testing::Message() << px_per_voxel << " px/voxel, values of " << lo << " to " << hi);
      request.transfer_function = beside(lo, hi);
      std::size_t skipped = 0;
      const Image truth = drawnWhole(stores.front(), request, skipped);
      for (const auto& store : stores) EXPECT_TRUE(equalBits(truth, draw(store, request))) << store;
      EXPECT_TRUE(showsSomething(truth));
      EXPECT_GT(skipped, 5u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Interpolations, Skipping,
                         ::testing::Combine(::testing::Values(Interpolation::kLinear, Interpolation::kCubic,
                                                              Interpolation::kCatmullRom),
                                            ::testing::Values(Projection::kOrthographic, Projection::kPerspective)));

}  // namespace
}  // namespace kiln::test
