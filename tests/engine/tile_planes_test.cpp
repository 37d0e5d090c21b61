// A tile's pixels stored as planes equal the tile's pixels. A footprint is open if any of its pixels in the tile is
// open.
#include "engine/voxel/tile_planes.h"

#include <gtest/gtest.h>

#include <bit>
#include <vector>

#include "support/reference/scalar_kernels.h"
#include "support/volumes/procedural.h"

namespace kiln::test {
namespace {

constexpr int kPlanesEdge = 70;

struct PlanesPicture {
  explicit PlanesPicture(const PixelRect& rect) {
    for (std::size_t i = 0; i < rgba.size(); ++i) rgba[i] = static_cast<float>(hashUnit(5, i));
    tile.rect = rect;
    tile.stride = 4 * kPlanesEdge;
    tile.rgba = pixel(rect.x0, rect.y0);
  }
  float* pixel(int x, int y) { return &rgba[static_cast<std::size_t>(4 * (y * kPlanesEdge + x))]; }

  std::vector<float> rgba = std::vector<float>(4 * kPlanesEdge * kPlanesEdge);
  TilePixels tile;
};

TEST(TilePlanes, HoldTheTilesPixels) {
  onEveryInstructionSet([&](std::int64_t target) {
    TilePlanes planes;
    // The last tile is smaller than the tile before, whose remains must not show.
    for (const PixelRect& rect : {PixelRect{3, 5, 4, 6}, PixelRect{0, 0, 64, 64}, PixelRect{9, 6, 33, 31}}) {
      SCOPED_TRACE(::testing::Message() << "instruction set " << target << ", " << rect.width() << " columns");
      PlanesPicture picture(rect);
      const std::vector<float> before = picture.rgba;
      planes.reserve(rect);
      planes.take(picture.tile);
      for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
          for (int c = 0; c < 4; ++c) EXPECT_EQ(planes.at(x, y)[c * planes.plane()], picture.pixel(x, y)[c]);
          for (int c = 0; c < 4; ++c) planes.at(x, y)[c * planes.plane()] += 1;
        }
        for (int i = 1; i <= TilePlanes::kBeside; ++i) {
          EXPECT_EQ(planes.at(rect.x0 - i, y)[3 * planes.plane()], 1);
          EXPECT_EQ(planes.at(rect.x1 - 1 + i, y)[3 * planes.plane()], 1);
        }
      }
      planes.putBack();
      for (int y = 0; y < kPlanesEdge; ++y) {
        for (int x = 0; x < kPlanesEdge; ++x) {
          for (std::size_t c = 0; c < 4; ++c) {
            const auto i = static_cast<std::size_t>(4 * (y * kPlanesEdge + x)) + c;
            EXPECT_EQ(picture.rgba[i], before[i] + (rect.contains(x, y) ? 1 : 0));
          }
        }
      }
    }
  });
}

// Pixels are closed in runs, so that footprints of all sizes are closed; most footprints reach over the tile's edge.
TEST(TilePlanes, KnowWhatIsOpen) {
  constexpr PixelRect kPlanesTile = {9, 6, 33, 31};
  PlanesPicture picture(kPlanesTile);
  for (int y = 0; y < kPlanesEdge; ++y) {
    for (int x = 0; x < kPlanesEdge; ++x)
      picture.pixel(x, y)[3] = hashUnit(7, static_cast<std::uint64_t>(x / 9 + 8 * (y / 7))) < 0.7 ? 1.0f : 0.999f;
  }
  int hidden = 0;
  for (std::uint64_t from = 0; from < 4000; from += kVoxelBatch) {
    ProjectedVoxels voxels{};
    for (std::size_t n = 0; n < kVoxelBatch; ++n) {
      const auto unit = [&](std::uint64_t i) { return hashUnit(11, 8 * (from + n) + i); };
      voxels.x0[n] = static_cast<int>(40 * unit(0)) - 2,
      voxels.x1[n] = voxels.x0[n] + 1 + static_cast<int>(20 * unit(1));
      voxels.y0[n] = static_cast<int>(40 * unit(2)) - 4,
      voxels.y1[n] = voxels.y0[n] + 1 + static_cast<int>(12 * unit(3));
      if (!intersection(voxels.rect(n), kPlanesTile).empty() && unit(4) < 0.9) voxels.touching |= 1u << n;
    }
    std::uint32_t truth = 0;
    for (std::size_t n = 0; n < kVoxelBatch; ++n) {
      const PixelRect rect = intersection(voxels.rect(n), kPlanesTile);
      for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) truth |= picture.pixel(x, y)[3] < 1 ? 1u << n : 0u;
      }
    }
    truth &= voxels.touching;
    hidden += std::popcount(voxels.touching & ~truth);
    onEveryInstructionSet([&](std::int64_t target) {
      TilePlanes planes;
      planes.reserve(kPlanesTile);
      planes.take(picture.tile);
      EXPECT_EQ(planes.open(voxels, voxels.touching), truth) << "instruction set " << target;
    });
  }
  EXPECT_GT(hidden, 200);
}

}  // namespace
}  // namespace kiln::test
