// A store exported to NanoVDB and read back with NanoVDB's own reader and validator. Known because the test made the
// store voxel by voxel.
#include <gtest/gtest.h>

#include <cmath>
#define NANOVDB_USE_ZIP
#include <nanovdb/util/GridValidator.h>
#include <nanovdb/util/IO.h>

#include "base/error.h"
#include "export/export_store.h"
#include "store/brick_index.h"
#include "store/store_reader.h"
#include "support/files/nifti_files.h"
#include "support/system/expect_error.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

using Handles = std::vector<nanovdb::GridHandle<nanovdb::HostBuffer>>;

Handles readNano(const fs::path& path) {
  return nanovdb::io::readGrids<nanovdb::HostBuffer, std::vector>(path.string());
}

class ExportNanoVdb : public ::testing::Test {
 protected:
  ExportReport exported(const fs::path& store, const ExportRequest& request) {
    return exportStore(StoreReader(store), request, silent_);
  }
  fs::path out() const { return directory_ / "out.nvdb"; }
  ScratchDirectory directory_;
  Progress silent_;
};

// Values of a ball in 1.5, and beside it the values 0, so that many leaves and tiles are empty.
double valueOf(std::int64_t x, std::int64_t y, std::int64_t z, VoxelType type) {
  const double away = std::hypot(static_cast<double>(x) - 20, static_cast<double>(y) - 18, static_cast<double>(z) - 9);
  if (away > 16) return 0;
  const double value = static_cast<double>((x * 31 + y * 17 + z * 1009) % 120);
  return sizeOf(type) > 1 ? 97 * value : value;
}

template <class Value>
void expectGrid(const nanovdb::NanoGrid<Value>* grid, const DenseVolume& volume, const VolumeGeometry& geometry) {
  ASSERT_NE(grid, nullptr);
  EXPECT_TRUE(nanovdb::isValid(*grid, /*detailed=*/true, /*verbose=*/true));
  EXPECT_STREQ(grid->gridName(), "density");
  std::uint64_t active = 0;
  const auto accessor = grid->getAccessor();
  for (std::int64_t i = 0; i < geometry.dims.count(); ++i) {
    const std::int64_t x = i % geometry.dims.x, y = i / geometry.dims.x % geometry.dims.y,
                       z = i / geometry.dims.x / geometry.dims.y;
    const nanovdb::Coord at(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
    const double expected = volume.valueAt(x, y, z);
    ASSERT_EQ(static_cast<double>(accessor.getValue(at)), expected) << x << " " << y << " " << z;
    active += expected != 0 ? 1 : 0;
  }
  EXPECT_EQ(grid->activeVoxelCount(), active);
  const nanovdb::Vec3d place = grid->indexToWorld(nanovdb::Vec3d(3, 5, 7));
  const glm::dvec3 expected = geometry.worldOf({3, 5, 7});
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(place[a], expected[a], 1e-9);
}

TEST_F(ExportNanoVdb, EveryTypeKeepsEveryVoxelAndThePlace) {
  for (const VoxelType type :
       {VoxelType::u8, VoxelType::i16, VoxelType::u32, VoxelType::i32, VoxelType::f32, VoxelType::f64}) {
    SCOPED_TRACE(static_cast<int>(type));
    const DenseVolume volume =
        fill({{43, 37, 21}, type, anisotropicAffine()}, [&](auto x, auto y, auto z) { return valueOf(x, y, z, type); });
    const fs::path store = makeStore(volume, "nano", 16);
    const VolumeGeometry geometry = StoreReader(store).level(0).geometry;
    std::uint64_t plain = 0;
    for (const bool compress : {false, true}) {
      const ExportReport report = exported(store, {.out = out(), .overwrite = true, .compress = compress});
      EXPECT_EQ(report.bytes, fs::file_size(out()));
      if (compress) EXPECT_LT(report.bytes, plain);
      plain = report.bytes;
      const Handles grids = readNano(out());
      ASSERT_EQ(grids.size(), 1u);
      if (type == VoxelType::u32)
        expectGrid(grids[0].grid<std::int64_t>(), volume, geometry);
      else if (type == VoxelType::i32)
        expectGrid(grids[0].grid<std::int32_t>(), volume, geometry);
      else if (type == VoxelType::f64)
        expectGrid(grids[0].grid<double>(), volume, geometry);
      else
        expectGrid(grids[0].grid<float>(), volume, geometry);
    }
  }
}

// Opacity 1/2 in one world unit from the value 50 on: an extinction of ln 2.
TEST_F(ExportNanoVdb, ATransferFunctionIsBakedIntoDensityAndColour) {
  const DenseVolume volume = fill({{30, 20, 20}, VoxelType::u8}, [](auto x, auto, auto) { return x < 11 ? 0 : 90; });
  ExportRequest request{.out = out()};
  request.baked =
      TransferFunction{1, {{0, glm::dvec3(0), 0}, {49, glm::dvec3(0), 0}, {50, glm::dvec3(1, 0.5, 0), 0.5}}};
  exported(makeStore(volume, "nano", 16), request);
  const Handles grids = readNano(out());
  ASSERT_EQ(grids.size(), 2u);
  const bool density_first = grids[0].gridMetaData()->shortGridName() == std::string("density");
  const auto* density = grids[density_first ? 0 : 1].grid<float>();
  const auto* color = grids[density_first ? 1 : 0].grid<nanovdb::Vec3f>();
  ASSERT_TRUE(density != nullptr && color != nullptr);
  EXPECT_EQ(density->tree().getValue({5, 9, 9}), 0);
  EXPECT_NEAR(density->tree().getValue({20, 9, 9}), std::log(2.0), 1e-6);
  EXPECT_NEAR(color->tree().getValue({20, 9, 9})[1], 0.5f, 1e-6f);
  // The neighbours of visible voxels have a colour, between which renderers interpolate.
  EXPECT_EQ(density->tree().getValue({10, 9, 9}), 0);
  EXPECT_NEAR(color->tree().getValue({10, 9, 9})[1], 0.5f, 1e-6f);
  EXPECT_TRUE(color->tree().isActive({10, 9, 9}));
  EXPECT_EQ(color->tree().getValue({9, 9, 9})[1], 0);
}

TEST_F(ExportNanoVdb, WhatItDoesNotHoldIsRefused) {
  const fs::path store = makeStore(fill({{9, 9, 9}, VoxelType::u8}, [](auto...) { return 5; }), "nano", 16);
  ExportRequest request{.out = out()};
  request.values.type = VdbType::kHalf;
  expectError([&] { exported(store, request); }, ErrorCode::kUsage, "--type: half is for .vdb only (found .nvdb)");
  request.values = {};
  request.memory_bytes = StoreReader(store).index().bytes() + 4096;
  expectError([&] { exported(store, request); }, ErrorCode::kBudget, "--memory");
  EXPECT_FALSE(fs::exists(out()));
}

// Stopped while the third tile is made. Tiles with and without zlib would make a set of both.
TEST_F(ExportNanoVdb, TilesOfAnotherCompression_resumed_areRefused) {
  struct StopAfterTile2 : Progress {
    bool cancelled() const override { return fs::exists(tile_2); }
    fs::path tile_2;
  } stop;
  const fs::path path = makeStore(fill({{40, 40, 20}, VoxelType::u8}, [](auto...) { return 5; }), "nano", 16);
  const StoreReader store(path);
  ExportRequest request{.out = directory_ / "t_#.nvdb", .compress = true, .tiles = 4};
  stop.tile_2 = fs::path(request.out.string() + ".partial") / "t_2.nvdb.txt";
  EXPECT_THROW(exportStore(store, request, stop), Error);
  ASSERT_TRUE(fs::exists(stop.tile_2));
  request.resume = true;
  request.compress = false;
  expectError([&] { exportStore(store, request, silent_); }, ErrorCode::kExists, "is an unfinished export of");
  request.compress = true;
  EXPECT_NO_THROW(exportStore(store, request, silent_));
}

}  // namespace
}  // namespace kiln::test
