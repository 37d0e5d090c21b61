// Kernels of the voxel lattice on every instruction set against plain loops (support/reference/scalar_voxels.h), bit
// for bit. Operations are fused where both sources fuse and never approximate; a footprint's weights are added in a
// fixed order. Compared: the picture, the closed pixels, the AOVs, and that pixels beside the tile stay untouched.
#include "support/reference/scalar_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>
#include <vector>

#include "support/reference/scalar_kernels.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {

constexpr int kEdge = 40;                    // edge of the picture
constexpr PixelRect kTile = {9, 6, 33, 31};  // no multiple of a vector
constexpr std::int32_t kVoxels = 6 * 6 * 6;

struct Closing final : Visibility {
  std::vector<std::pair<int, int>> pixels;
  bool hidden(const PixelRect&) const override { return false; }
  void close(int x, int y) override { pixels.emplace_back(x, y); }
};

struct Drawn {
  std::vector<float> rgba = std::vector<float>(4 * kEdge * kEdge);
  std::vector<float> planes[5];  // first hit, mean depth, normal
  std::vector<std::pair<int, int>> closed;
  bool operator==(const Drawn&) const = default;
};

float unit(std::uint64_t n) { return static_cast<float>(hashUnit(23, n)); }

// Returns a view of cubic voxels, whose orthographic footprint is a table, or of longer voxels with an oblique ellipse.
VoxelView viewAt(bool perspective, double px_per_voxel, bool phong, double edge_z = 1) {
  VolumeGeometry volume;
  volume.dims = {6, 6, 6};
  volume.world_from_index[2][2] = edge_z;
  Camera camera;
  camera.projection = perspective ? Projection::kPerspective : Projection::kOrthographic;
  camera.target = {2.5, 2.5, 2.5};
  camera.eye = camera.target + 24.0 * glm::normalize(glm::dvec3(0.6, 0.3, 0.8));
  camera.height = kEdge / px_per_voxel;
  camera.fov_deg = 2 * std::atan(camera.height / 48) * 180 / 3.14159265358979;
  const Projector projector(volume, resolve(camera, {kEdge, kEdge}));
  PlainLight light = plainLight({}, {1e-3f}, projector);
  light.phong = phong;
  return VoxelView(projector, light);
}

void layIntoTile(const VoxelView& view, const ProjectedVoxels& voxels, const ShadedVoxels& shaded, std::uint32_t drawn,
                 const TilePixels& tile, float opacity_threshold, Visibility& visibility) {
  TilePlanes planes;
  planes.reserve(tile.rect);
  planes.take(tile);
  rasterizeFootprints(view, voxels, shaded, drawn, planes, opacity_threshold, visibility);
  planes.putBack();
}

// Draws all voxels of a cell, some of them invisible, by either implementation.
template <class Project, class Lay>
Drawn drawnBy(const VoxelView& view, bool aovs, const Project& project, const Lay& lay) {
  Drawn out;
  TilePixels tile;
  tile.rect = kTile;
  tile.stride = 4 * kEdge;
  const std::ptrdiff_t first = kTile.y0 * kEdge + kTile.x0;
  tile.rgba = out.rgba.data() + 4 * first;
  if (aovs) {
    for (auto& plane : out.planes) plane.resize(kEdge * kEdge);
    const auto at = [&](int i) { return out.planes[i].data() + first; };
    tile.aovs = {at(0), at(1), {at(2), at(3), at(4)}};
  }
  Closing closing;
  for (std::int32_t from = 0; from < kVoxels; from += kVoxelBatch) {
    const std::int32_t count = std::min<std::int32_t>(kVoxelBatch - from / kVoxelBatch % 3, kVoxels - from);
    std::int32_t codes[kVoxelBatch] = {};
    for (std::int32_t i = 0; i < count; ++i) codes[i] = voxelCode((from + i) % 6, (from + i) / 6 % 6, (from + i) / 36);
    ProjectedVoxels projected{};
    project(view, VoxelCoord{0, 0, 0}, codes, count, tile.rect, projected);
    ShadedVoxels shaded{};
    for (std::size_t n = 0; n < kVoxelBatch; ++n) {
      const std::uint64_t seed = 16 * (static_cast<std::uint64_t>(from) + n);
      for (std::size_t c = 0; c < 3; ++c) shaded.material[4 * n + c] = unit(seed + c);
      const float thick = unit(seed + 3);
      shaded.material[4 * n + 3] = thick < 0.5f ? 0.01f * thick : thick < 0.95f ? 2 * thick : 1e4f;
      for (std::size_t a = 0; a < 3; ++a) shaded.slope[a][n] = unit(seed + 4 + a) - 0.5f;
      if (unit(seed + 7) < 0.1f) shaded.slope[1][n] = std::nanf("");
      if (unit(seed + 8) < 0.1f) shaded.slope[0][n] = shaded.slope[1][n] = shaded.slope[2][n] = 0;
      shaded.aov[n] = {unit(seed + 9), {unit(seed + 10), unit(seed + 11), unit(seed + 12)}};
    }
    lay(view, projected, shaded, projected.touching & 0xf7dbu, tile, 0.9f, closing);
  }
  // The order in which pixels close is not specified.
  std::sort(closing.pixels.begin(), closing.pixels.end());
  out.closed = closing.pixels;
  return out;
}

TEST(ScalarVoxels, AreProjectedAlike) {
  for (const bool perspective : {false, true}) {
    const VoxelView view = viewAt(perspective, 3, true);
    for (const int count : {1, 7, 15, 16}) {
      std::int32_t codes[kVoxelBatch] = {};
      for (std::int32_t i = 0; i < count; ++i) codes[i] = voxelCode(i * 5 % 16, i * 3 % 16, i * 7 % 16);
      ProjectedVoxels truth{};
      projectVoxelsScalar(view, {-8, 0, -3}, codes, count, kTile, truth);
      onEveryInstructionSet([&](std::int64_t target) {
        SCOPED_TRACE(target);
        ProjectedVoxels found{};
        projectVoxels(view, {-8, 0, -3}, codes, count, kTile, found);
        EXPECT_EQ(found.touching, truth.touching);
        EXPECT_EQ(found.inside, truth.inside);
        for (std::size_t n = 0; n < static_cast<std::size_t>(count); ++n) {
          if ((truth.touching >> n & 1) == 0) continue;
          EXPECT_EQ(found.rect(n), truth.rect(n));
          EXPECT_EQ(found.dx[n], truth.dx[n]);
          EXPECT_EQ(found.dy[n], truth.dy[n]);
          EXPECT_EQ(found.u[n], truth.u[n]);
          EXPECT_EQ(found.v[n], truth.v[n]);
          EXPECT_EQ(found.r[n], truth.r[n]);
          EXPECT_EQ(found.xx[n], truth.xx[n]);
          EXPECT_EQ(found.yy[n], truth.yy[n]);
        }
      });
    }
  }
}

// Footprints 2 to 60 pixels across, for all code paths: blended together, blended one by one, read from a table, with
// stored weights, with weights computed row by row, and without normalization.
TEST(ScalarVoxels, AreDrawnAlike) {
  int closed = 0;
  constexpr std::pair<double, double> kSizes[] = {{0.4, 1}, {0.9, 1}, {1.3, 1},   {2.1, 1},   {3.0, 1},
                                                  {4.2, 1}, {18., 1}, {0.4, 1.7}, {1.3, 1.7}, {2.1, 1.3}};
  for (const auto& [px_per_voxel, edge_z] : kSizes) {
    for (const bool perspective : {false, true}) {
      for (const bool aovs : {false, true}) {
        SCOPED_TRACE(::testing::Message() << px_per_voxel << " by " << edge_z << (perspective ? " perspective" : "")
                                          << (aovs ? " AOVs" : ""));
        const VoxelView view = viewAt(perspective, px_per_voxel, px_per_voxel != 2.1, edge_z);
        EXPECT_EQ(view.footprint != nullptr, !perspective && edge_z == 1 && px_per_voxel < 2.3);
        const Drawn truth = drawnBy(view, aovs, projectVoxelsScalar, layVoxelsScalar);
        closed += static_cast<int>(truth.closed.size());
        EXPECT_NE(truth.rgba, Drawn().rgba);
        for (int y = 0; y < kEdge; ++y) {
          for (int x = 0; x < kEdge; ++x) {
            if (!kTile.contains(x, y)) {
              EXPECT_EQ(truth.rgba[static_cast<std::size_t>(4 * (y * kEdge + x) + 3)], 0);
            }
          }
        }
        onEveryInstructionSet([&](std::int64_t target) {
          EXPECT_TRUE(drawnBy(view, aovs, projectVoxels, layIntoTile) == truth) << "instruction set " << target;
        });
      }
    }
  }
  EXPECT_GT(closed, 100);
}

}  // namespace
}  // namespace kiln::test
