// A store exported to OpenVDB and read back with OpenVDB's own io::File and getValue. Known because the test made the
// store voxel by voxel: every voxel and the transform must be equal.
#include "export/vdb/export_vdb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "base/error.h"
#include "base/memory/memory.h"
#include "export/export_store.h"
#include "ingest/open_source.h"
#include "ingest/source/formats.h"
#include "store/store_writer.h"
#include "support/files/nifti_files.h"
#include "support/files/vdb_files.h"
#include "support/system/expect_error.h"
#include "support/system/faulty_file_system.h"

namespace kiln {
namespace {
namespace fs = std::filesystem;
using test::VdbKind;

constexpr std::int64_t kBrick = 16;

// Fills a store at `directory` brick by brick from a function that reads a box.
using BoxReader = std::function<void(const VoxelBox&, std::span<std::byte>)>;
void makeStore(const fs::path& directory, const SourceInfo& info, const BoxReader& read) {
  Manifest draft;
  draft.type = info.type;
  draft.background = info.background;
  draft.volume_class = info.volume_class;
  draft.brick_size = kBrick;
  draft.source.format = info.format;
  draft.source.vdb = info.vdb;
  draft.levels.resize(1);
  draft.levels[0].geometry = info.geometry;
  StoreWriter writer(directory, draft, FileSystem::real());
  const Extent3 lattice = brickLattice(info.geometry.dims, kBrick);
  for (std::int64_t i = 0; i < lattice.count(); ++i) {
    const BrickKey key{0, brickAt(lattice, i)};
    const VoxelBox box = writer.frame(key).stored();
    std::vector<std::byte> voxels(static_cast<std::size_t>(box.count()) * sizeOf(info.type));
    read(box, voxels);
    writer.write(writer.encode(key, voxels, rangesOf(writer.frame(key), voxels)));
  }
  writer.finish({}, 0);
}

// The store of values f(x, y, z).
template <class T, class F>
void makeStore(const fs::path& directory, const SourceInfo& info, F&& f) {
  makeStore(directory, info, [&](const VoxelBox& box, std::span<std::byte> out) {
    std::size_t at = 0;
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x, at += sizeof(T)) {
          const T value = static_cast<T>(f(x, y, z));
          std::memcpy(out.data() + at, &value, sizeof(T));
        }
      }
    }
  });
}

class ExportVdb : public ::testing::Test {
 protected:
  VdbReport exported(bool overwrite = false) { return written({.out = out(), .overwrite = overwrite}); }
  VdbReport written(const VdbRequest& request) {
    const StoreReader store(directory_ / "s.kiln");
    return exportVdb(store, exportedVolume(store, 0, {}), request, silent_);
  }
  // Stops while the third tile of t_# is made.
  void interruptTiles(const StoreReader& store, const ExportRequest& request) {
    struct StopLate : Progress {
      bool cancelled() const override { return fs::exists(second) && --left < 0; }
      fs::path second;
      mutable int left = 2;
    } stop;
    stop.second = fs::path(request.out.string() + ".partial") / ("t_2" + request.out.extension().string() + ".txt");
    EXPECT_THROW(exportStore(store, request, stop), Error);
  }
  fs::path out() const { return directory_ / "out.vdb"; }
  test::ScratchDirectory directory_;
  Progress silent_;
};

SourceInfo denseInfo(VoxelType type, const Extent3& dims) {
  SourceInfo info;
  info.format = "test";
  info.type = type;
  info.geometry.dims = dims;
  info.geometry.world_from_index = {{0.7, 0.1, 0, 0}, {-0.2, 1.3, 0.05, 0}, {0.3, 0, 2.5, 0}, {-90.5, 17.25, 1e3, 1}};
  return info;
}

// Zero beyond x = 20 makes constant bricks of background; 7 beyond y = 20 makes other constant bricks.
template <class T>
double denseValue(std::int64_t x, std::int64_t y, std::int64_t z) {
  if (y > 20) return 7;
  if (x > 20) return 0;
  const double raw = static_cast<double>((x * 31 + y * 17 + z * 1009) % 251) - (std::is_signed_v<T> ? 125 : 0);
  return sizeof(T) == 1 ? std::trunc(raw / 2) : raw * 97;
}

TEST_F(ExportVdb, DenseVolumesOfEveryTypeKeepEveryVoxelAndThePlace) {
  const Extent3 dims = {53, 49, 21};
  const char* const kGridTypes[] = {"float", "float", "float", "float", "int64", "int32", "float", "double"};
  for (int t = 0; t < 8; ++t) {
    const auto type = static_cast<VoxelType>(t);
    withVoxelType(type, [&]<class T>(std::type_identity<T>) {
      const SourceInfo info = denseInfo(type, dims);
      fs::remove_all(directory_ / "s.kiln");
      makeStore<T>(directory_ / "s.kiln", info, denseValue<T>);
      const VdbReport report = exported(/*overwrite=*/true);
      EXPECT_EQ(test::gridNames(out()), std::vector<std::string>{"density"});
      const test::DirectGrid grid(out(), "density");
      EXPECT_EQ(grid.type(), kGridTypes[t]);
      EXPECT_EQ(grid.savedAsHalf(), sizeof(T) == 1) << "values up to 97 * 250 do not survive half";
      EXPECT_EQ(report.bytes, fs::file_size(out()));
      std::uint64_t active = 0;
      for (std::int64_t i = 0; i < dims.count(); ++i) {
        const VoxelCoord v = {i % dims.x, i / dims.x % dims.y, i / dims.x / dims.y};
        const double expected = static_cast<double>(static_cast<T>(denseValue<T>(v.x, v.y, v.z)));
        ASSERT_EQ(grid.value(v), expected);
        ASSERT_EQ(grid.active(v), expected != 0);
        active += expected != 0;
      }
      EXPECT_EQ(report.voxels, active);
      EXPECT_EQ(grid.activeVoxels(), active);
      for (int c = 0; c < 4; ++c) {
        for (int r = 0; r < 4; ++r)
          EXPECT_NEAR(grid.worldFromGrid()[c][r], info.geometry.world_from_index[c][r], 1e-12);
      }
    });
  }
}

// u32 is exported as a grid of 64-bit integers and comes back as u32, up to the largest value.
TEST_F(ExportVdb, UnsignedVolume_exportedAndReadAgain_isEqual) {
  const Extent3 dims = {20, 9, 11};
  const auto value = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return 4294967295.0 - static_cast<double>(x + 20 * y + 180 * z);
  };
  makeStore<std::uint32_t>(directory_ / "s.kiln", denseInfo(VoxelType::u32, dims), value);
  exported();
  const std::unique_ptr<VolumeSource> back = openSource(out(), {});
  ASSERT_EQ(back->info().type, VoxelType::u32);
  ASSERT_EQ(back->info().geometry.dims, dims);
  std::vector<std::byte> voxels(static_cast<std::size_t>(dims.count()) * sizeof(std::uint32_t));
  back->read(boxOf(dims), voxels);
  for (std::int64_t i = 0; i < dims.count(); ++i) {
    std::uint32_t found;
    std::memcpy(&found, &voxels[static_cast<std::size_t>(i) * sizeof found], sizeof found);
    ASSERT_EQ(found, value(i % 20, i / 20 % 9, i / 180));
  }
}

// Labels come back as integers, which convert --labels accepts.
TEST_F(ExportVdb, LabelsAreWholeNumbersUnderTheirOwnName) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::i16, VoxelType::u16, VoxelType::u32, VoxelType::i32}) {
    SourceInfo info = denseInfo(type, {33, 20, 17});
    info.volume_class = VolumeClass::kLabels;
    const auto label = [](std::int64_t x, std::int64_t y, std::int64_t z) { return (x / 5 + y / 7 + z) % 4 * 30.0; };
    withVoxelType(type, [&]<class T>(std::type_identity<T>) {
      fs::remove_all(directory_ / "s.kiln");
      makeStore<T>(directory_ / "s.kiln", info, label);
    });
    exported(/*overwrite=*/true);
    EXPECT_EQ(test::gridNames(out()), std::vector<std::string>{"labels"});
    const std::unique_ptr<VolumeSource> back = openSource(out(), {});
    ASSERT_EQ(back->info().type, VoxelType::i32);
    // The box of the exported grid bounds all voxels that are not 0.
    const VoxelBox box = boxOf(back->info().geometry.dims);
    const VoxelCoord& origin = back->info().vdb->index_origin;
    std::vector<std::byte> voxels(static_cast<std::size_t>(box.count()) * sizeof(std::int32_t));
    back->read(box, voxels);
    const auto* value = reinterpret_cast<const std::int32_t*>(voxels.data());
    for (std::int64_t z = 0; z < box.hi.z; ++z) {
      for (std::int64_t y = 0; y < box.hi.y; ++y) {
        for (std::int64_t x = 0; x < box.hi.x; ++x)
          ASSERT_EQ(*value++, label(x + origin.x, y + origin.y, z + origin.z));
      }
    }
  }
}

// NaN differs from every background and -0 from 0: both are active and come back, NaN as some NaN.
TEST_F(ExportVdb, KeepsNanInfinityAndTheSignOfZero) {
  const SourceInfo info = denseInfo(VoxelType::f32, {20, 9, 9});
  const float inf = std::numeric_limits<float>::infinity();
  const auto f = [&](std::int64_t x, std::int64_t y, std::int64_t) {
    if (x > 12 && y < 8) return -0.0f;
    return x == 3 ? std::numeric_limits<float>::quiet_NaN() : x == 4 ? inf : x == 5 ? -inf : x == 6 ? 1e-42f : 0.0f;
  };
  makeStore<float>(directory_ / "s.kiln", info, f);
  exported();
  const test::DirectGrid grid(out(), "density");
  for (std::int64_t x = 0; x < 20; ++x) {
    for (std::int64_t y = 0; y < 9; ++y) {
      const float expected = f(x, y, 0), found = static_cast<float>(grid.value({x, y, 4}));
      if (std::isnan(expected)) {
        EXPECT_TRUE(std::isnan(found));
      } else {
        EXPECT_EQ(std::bit_cast<std::uint32_t>(found), std::bit_cast<std::uint32_t>(expected)) << x << " " << y;
      }
      EXPECT_EQ(grid.active({x, y, 4}), std::bit_cast<std::uint32_t>(expected) != 0);
    }
  }
}

// NaN is equal to nothing, so that a leaf whose first voxel is NaN, or whose others are, could count as constant.
TEST_F(ExportVdb, KeepsTheVoxelsBesideNan) {
  const SourceInfo info = denseInfo(VoxelType::f32, {16, 8, 8});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto f = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    if (x < 8) return x + y + z == 0 ? nan : static_cast<float>(x + 8 * y + 64 * z);
    return x == 9 ? nan : 5.0f;
  };
  makeStore<float>(directory_ / "s.kiln", info, f);
  exported();
  const test::DirectGrid grid(out(), "density");
  for (std::int64_t x = 0; x < 16; ++x) {
    for (std::int64_t y = 0; y < 8; ++y) {
      for (std::int64_t z = 0; z < 8; ++z) {
        const float expected = f(x, y, z), found = static_cast<float>(grid.value({x, y, z}));
        EXPECT_TRUE(std::isnan(expected) ? std::isnan(found) : found == expected) << x << " " << y << " " << z;
      }
    }
  }
}

// From OpenVDB to a store and back: both files hold equal values at every coordinate of the source's active box.
void expectRoundTrip(const fs::path& in, const fs::path& store, const fs::path& out) {
  const auto source = openVdb(in, {});
  makeStore(store, source->info(), [&](const VoxelBox& box, std::span<std::byte> to) { source->read(box, to); });
  Progress silent;
  exportVdb(StoreReader(store), exportedVolume(StoreReader(store), 0, {}), {.out = out}, silent);
  const std::string name = source->info().vdb->grid_name;
  const test::DirectGrid before(in, name), after(out, name);
  EXPECT_EQ(after.type(), before.type());
  EXPECT_EQ(after.background(), before.background());
  EXPECT_EQ(after.levelSet(), before.levelSet());
  EXPECT_EQ(after.worldFromGrid(), before.worldFromGrid());
  const VoxelBox box = before.activeBox();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
        const double value = before.value({x, y, z});
        ASSERT_EQ(after.value({x, y, z}), value) << x << " " << y << " " << z;
        const bool active = before.levelSet() ? std::abs(value) < before.background() : value != before.background();
        ASSERT_EQ(after.active({x, y, z}), active) << x << " " << y << " " << z;
      }
    }
  }
}

TEST_F(ExportVdb, GridsComeBackAtTheirOwnCoordinates) {
  int n = 0;
  for (const VdbKind kind :
       {VdbKind::kFloat, VdbKind::kHalf, VdbKind::kDouble, VdbKind::kInt32, VdbKind::kTiles, VdbKind::kLevelSet}) {
    const glm::dmat4 m = {{0, 2, 0, 0}, {-1.5, 0, 0.25, 0}, {0, 0, 3, 0}, {4, 5, 6, 1}};
    test::writeVdb(directory_ / "in.vdb", {{kind, "heat", m}});
    const std::string name = std::to_string(n++);
    expectRoundTrip(directory_ / "in.vdb", directory_ / (name + ".kiln").c_str(), directory_ / (name + ".vdb").c_str());
  }
}

// Known because OpenVDB refuses voxels of less than 3e-15 cubic units: the error comes before any brick is read.
TEST_F(ExportVdb, VoxelsTooSmallForOpenVdbAreRefused) {
  struct Silent : Progress {
    void advance(const char*, const char*, std::uint64_t, std::uint64_t) override { ADD_FAILURE(); }
  } silent;
  SourceInfo info = denseInfo(VoxelType::u8, {20, 9, 9});
  for (int axis = 0; axis < 3; ++axis) info.geometry.world_from_index[axis] *= 1e-5;
  makeStore<std::uint8_t>(directory_ / "s.kiln", info, denseValue<std::uint8_t>);
  const StoreReader store(directory_ / "s.kiln");
  test::expectError([&] { exportVdb(store, exportedVolume(store, 0, {}), {.out = out()}, silent); },
                    ErrorCode::kUnsupported, "geometry: OpenVDB has no transform for voxels of 7.07107e-06 x ");
  EXPECT_FALSE(fs::exists(out()));
}

// A ramp of steps of 0.3 from 100 on: halves have steps of 1/16 between 64 and 128, so the error is at most 1/32.
TEST_F(ExportVdb, LooserValuesStateTheirLargestError) {
  const Extent3 dims = {40, 9, 9};
  const auto ramp = [](std::int64_t x, std::int64_t, std::int64_t) {
    return static_cast<float>(100 + 0.3 * static_cast<double>(x));
  };
  makeStore<float>(directory_ / "s.kiln", denseInfo(VoxelType::f32, dims), ramp);
  const VdbReport half = written({.out = out(), .values = {.type = VdbType::kHalf}});
  const test::DirectGrid halves(out(), "density");
  EXPECT_TRUE(halves.savedAsHalf());
  double largest = 0;
  for (std::int64_t x = 0; x < dims.x; ++x)
    largest = std::max(largest, std::abs(halves.value({x, 4, 4}) - ramp(x, 4, 4)));
  EXPECT_EQ(half.largest_error, largest);
  EXPECT_LE(largest, 1.0 / 32);
  EXPECT_GT(largest, 1.0 / 128);

  const VdbReport sparse = written({.out = out(), .overwrite = true, .values = {VdbType::kFloat, 106.0, 2.5}});
  const test::DirectGrid grid(out(), "density");
  EXPECT_FALSE(grid.savedAsHalf());
  EXPECT_EQ(grid.background(), 106);
  std::uint64_t active = 0;
  largest = 0;
  for (std::int64_t x = 0; x < dims.x; ++x) {
    const double difference = std::abs(ramp(x, 4, 4) - 106.0);
    ASSERT_EQ(grid.active({x, 4, 4}), difference > 2.5) << x;
    EXPECT_EQ(grid.value({x, 4, 4}), difference > 2.5 ? ramp(x, 4, 4) : 106);
    active += difference > 2.5 ? 81 : 0;
    if (difference <= 2.5) largest = std::max(largest, difference);
  }
  EXPECT_EQ(sparse.voxels, active);
  EXPECT_EQ(sparse.largest_error, largest);
}

// A box of one value that begins inside leaves makes leaves at its border.
TEST_F(ExportVdb, BordersOfConstantBricksAreCharged) {
  makeStore<std::uint8_t>(directory_ / "s.kiln", denseInfo(VoxelType::u8, {90, 90, 90}),
                          [](std::int64_t, std::int64_t, std::int64_t) { return std::uint8_t{7}; });
  const StoreReader store(directory_ / "s.kiln");
  const auto part = [&](std::int64_t lo, std::int64_t hi) {
    return exportedVolume(store, 0, VoxelBox{{lo, lo, lo}, {hi, hi, hi}});
  };
  const std::uint64_t little = store.index().bytes() + (100u << 10);
  EXPECT_NO_THROW(exportVdb(store, part(0, 64), {.out = out(), .memory_bytes = little}, silent_));
  test::expectError(
      [&] { exportVdb(store, part(3, 67), {.out = out(), .overwrite = true, .memory_bytes = little}, silent_); },
      ErrorCode::kBudget, "--memory");
}

TEST_F(ExportVdb, ValuesThatAGridCannotHoldAreRefused) {
  makeStore<double>(directory_ / "s.kiln", denseInfo(VoxelType::f64, {9, 9, 9}),
                    [](std::int64_t x, std::int64_t, std::int64_t) { return 1e5 + static_cast<double>(x); });
  const auto expectRefusal = [&](const VdbValues& values, const char* part) {
    test::expectError([&] { written({.out = out(), .values = values}); }, ErrorCode::kUsage, part);
  };
  expectRefusal({.type = VdbType::kHalf}, "--type: values must be at most 65504 (found 100008); write --type float");
  expectRefusal({.type = VdbType::kFloat, .background = 1e39}, "--background");
  EXPECT_FALSE(fs::exists(out()));
}

// 2^63 is the first number beyond 64 bits with a sign, and no double lies between it and 2^63 - 1024.
TEST_F(ExportVdb, BackgroundBeyondWholeNumbersOf64Bits_isRefused) {
  makeStore<std::uint32_t>(directory_ / "s.kiln", denseInfo(VoxelType::u32, {9, 9, 9}), denseValue<std::uint32_t>);
  for (const double background : {0x1p63, -0x1p63, 0.5})
    test::expectError([&] { written({.out = out(), .values = {.background = background}}); }, ErrorCode::kUsage,
                      "--background");
  EXPECT_NO_THROW(written({.out = out(), .values = {.background = 0x1p63 - 1024}}));
}

// An infinity stays as it is, and hides no value that a float cannot hold: 1e300 lies in the second brick.
TEST_F(ExportVdb, InfinitiesAreFloats) {
  const double inf = std::numeric_limits<double>::infinity();
  for (const double large : {2.5, 1e300}) {
    const auto value = [&](std::int64_t x, std::int64_t, std::int64_t) {
      return x == 3 ? inf : x == 4 ? -inf : x == 20 ? large : 1.5;
    };
    for (const VdbType type : {VdbType::kFloat, VdbType::kHalf}) {
      fs::remove_all(directory_ / "s.kiln");
      makeStore<double>(directory_ / "s.kiln", denseInfo(VoxelType::f64, {30, 9, 9}), value);
      const VdbRequest request = {.out = out(), .overwrite = true, .values = {.type = type}};
      if (large > 3) {
        test::expectError([&] { written(request); }, ErrorCode::kUsage, "(found a larger value)");
        continue;
      }
      written(request);
      const test::DirectGrid grid(out(), "density");
      for (std::int64_t x = 0; x < 30; ++x) EXPECT_EQ(grid.value({x, 4, 4}), value(x, 4, 4)) << x;
    }
  }
}

// Opacity rises from 0 at 100 to 1/2 at 200 over 2 world units, and the colour from black to (1, 0.5, 0): -ln(1 - a) /
// 2 and the colour at each voxel. A brick of one value becomes a tile.
TEST_F(ExportVdb, ATransferFunctionIsBakedIntoDensityAndColour) {
  TransferFunction function;
  function.unit = 2;
  function.points = {{100, glm::dvec3(0), 0}, {200, glm::dvec3(1, 0.5, 0), 0.5}};
  const auto value = [](std::int64_t x, std::int64_t y, std::int64_t) { return x > 31 ? 180 : 80 + 4 * x + y; };
  const Extent3 dims = {52, 9, 9};
  for (const VoxelType type : {VoxelType::u8, VoxelType::i32}) {
    fs::remove_all(directory_ / "s.kiln");
    withVoxelType(type, [&]<class T>(std::type_identity<T>) {
      makeStore<T>(directory_ / "s.kiln", denseInfo(type, dims), value);
    });
    const VdbReport report = written({.out = out(), .overwrite = true, .baked = function});
    EXPECT_EQ(test::gridNames(out()), (std::vector<std::string>{"Cd", "density"}));
    const test::DirectGrid density(out(), "density"), color(out(), "Cd");
    EXPECT_EQ(report.voxels, density.activeVoxels());
    for (std::int64_t x = 0; x < dims.x; ++x) {
      for (std::int64_t y = 0; y < dims.y; ++y) {
        const double share = std::clamp((static_cast<double>(value(x, y, 3)) - 100) / 100, 0.0, 1.0);
        ASSERT_EQ(density.active({x, y, 3}), share > 0);
        if (share == 0) continue;
        ASSERT_NEAR(density.value({x, y, 3}), -std::log(1 - share / 2) / 2, 1e-6) << x << " " << y;
        const std::array<float, 3> found = color.color({x, y, 3});
        ASSERT_NEAR(found[0], share, 1e-6);
        ASSERT_NEAR(found[1], share / 2, 1e-6);
        ASSERT_EQ(found[2], 0);
      }
    }
  }
  function.gradient_opacity = {{0, 0}, {1, 1}};
  EXPECT_THROW(written({.out = out(), .overwrite = true, .baked = function}), Error);
}

// Opacity 1/2 in a length u is the density ln(2) / u: 69315 for u = 1e-5, and infinite in floats for u = 1e-39.
TEST_F(ExportVdb, DensitiesThatAFileCannotHoldAreRefused) {
  for (const auto& value : std::vector<std::function<double(int)>>{[](int x) { return x; }, [](int) { return 7; }}) {
    makeStore<std::uint8_t>(directory_ / "s.kiln", denseInfo(VoxelType::u8, {20, 9, 9}),
                            [&](auto x, auto, auto) { return value(static_cast<int>(x)); });
    TransferFunction function = {1e-5, {{0, glm::dvec3(1), 0}, {1, glm::dvec3(1), 0.5}}};
    VdbRequest request = {.out = out(), .values = {.type = VdbType::kHalf}, .baked = function};
    test::expectError([&] { written(request); }, ErrorCode::kUsage,
                      "--type: densities must be at most 65504 (found a larger value); write --type float");
    EXPECT_FALSE(fs::exists(out()));
    request.values = {};
    EXPECT_NO_THROW(written(request));
    request.overwrite = true;
    request.baked->unit = 1e-39;
    test::expectError([&] { written(request); }, ErrorCode::kUsage, "--tf: densities must be at most 3.40282e+38");
    fs::remove(out());
    fs::remove_all(directory_ / "s.kiln");
  }
}

// Each active voxel of the whole is active in exactly one tile, with its value.
TEST_F(ExportVdb, TilesLieSideBySide) {
  const Extent3 dims = {53, 49, 21};
  makeStore<std::int16_t>(directory_ / "s.kiln", denseInfo(VoxelType::i16, dims), denseValue<std::int16_t>);
  ExportRequest request;
  request.out = directory_ / "t_##.vdb";
  request.tiles = 5;
  request.region = VoxelBox{{3, 0, 0}, {53, 49, 20}};
  const StoreReader store(directory_ / "s.kiln");
  exportStore(store, request, silent_);
  std::vector<std::unique_ptr<test::DirectGrid>> grids;
  for (int tile = 1; tile <= 5; ++tile)
    grids.push_back(
        std::make_unique<test::DirectGrid>(directory_ / ("t_0" + std::to_string(tile) + ".vdb").c_str(), "density"));
  for (std::int64_t i = 0; i < dims.count(); ++i) {
    const VoxelCoord v = {i % dims.x, i / dims.x % dims.y, i / dims.x / dims.y};
    const double value = request.region->contains(v) ? denseValue<std::int16_t>(v.x, v.y, v.z) : 0;
    int holders = 0;
    for (const auto& grid : grids) {
      if (!grid->active(v)) continue;
      ++holders;
      ASSERT_EQ(grid->value(v), static_cast<std::int16_t>(value));
    }
    ASSERT_EQ(holders, static_cast<std::int16_t>(value) != 0 ? 1 : 0) << v.x << " " << v.y << " " << v.z;
  }
  EXPECT_FALSE(fs::exists(directory_ / "t_##.vdb.partial"));
  request.out = directory_ / "t.vdb";
  EXPECT_THROW(exportStore(store, request, silent_), Error);
  request.out = directory_ / "u_#.vdb";
  request.tiles = 1000;
  EXPECT_THROW(exportStore(store, request, silent_), Error);
}

// The fifth tile of the earlier export would lie in the volume a second time.
TEST_F(ExportVdb, TilesBesideATileOfAnEarlierExport_areRefused) {
  makeStore<std::int16_t>(directory_ / "s.kiln", denseInfo(VoxelType::i16, {53, 49, 21}), denseValue<std::int16_t>);
  const StoreReader store(directory_ / "s.kiln");
  ExportRequest request = {.out = directory_ / "t_#.vdb", .overwrite = true, .tiles = 4};
  exportStore(store, request, silent_);
  EXPECT_NO_THROW(exportStore(store, request, silent_));
  test::writeBytes(directory_ / "t_5.vdb", {1});
  test::expectError([&] { exportStore(store, request, silent_); }, ErrorCode::kExists,
                    "t_5.vdb: would be taken for one of these 4 tiles");
  fs::rename(directory_ / "t_5.vdb", directory_ / "t_02.vdb");
  test::expectError([&] { exportStore(store, request, silent_); }, ErrorCode::kExists, "t_02.vdb: would be taken");
  EXPECT_FALSE(fs::exists(directory_ / "t_#.vdb.partial"));
}

// Stopped while the third tile is made: no tile has its name, and two are kept, and not made again.
TEST_F(ExportVdb, TilesAreResumed) {
  makeStore<std::int16_t>(directory_ / "s.kiln", denseInfo(VoxelType::i16, {53, 49, 21}), denseValue<std::int16_t>);
  const StoreReader store(directory_ / "s.kiln");
  ExportRequest request;
  request.out = directory_ / "t_#.vdb";
  request.tiles = 4;
  const fs::path partial = request.out.string() + ".partial";
  interruptTiles(store, request);
  EXPECT_FALSE(fs::exists(directory_ / "t_1.vdb"));
  ASSERT_TRUE(fs::exists(partial / "t_2.vdb"));
  EXPECT_FALSE(fs::exists(partial / "t_3.vdb"));
  test::expectError([&] { exportStore(store, request, silent_); }, ErrorCode::kExists, "continue it by --resume");
  request.resume = true;
  request.values.tolerance = 1;
  test::expectError([&] { exportStore(store, request, silent_); }, ErrorCode::kExists, "is an unfinished export of");
  request.values.tolerance = 0;
  const std::string kept = readTextFile(partial / "t_2.vdb");
  const ExportReport resumed = exportStore(store, request, silent_);
  EXPECT_FALSE(fs::exists(partial));
  EXPECT_EQ(readTextFile(directory_ / "t_2.vdb"), kept);  // another run writes another identifier

  request.resume = false;
  request.out = directory_ / "u_#.vdb";
  const ExportReport whole = exportStore(store, request, silent_);
  EXPECT_EQ(resumed.contents, whole.contents);
  EXPECT_EQ(resumed.bytes, whole.bytes);
  for (int tile = 1; tile <= 4; ++tile) {
    const std::string name = "_" + std::to_string(tile) + ".vdb";
    const test::DirectGrid again((directory_ / "t").concat(name), "density"),
        at_once((directory_ / "u").concat(name), "density");
    EXPECT_EQ(again.activeVoxels(), at_once.activeVoxels());
    for (std::int64_t x = 0; x < 53; ++x) EXPECT_EQ(again.value({x, 17, 11}), at_once.value({x, 17, 11})) << x;
  }
  request.tiles = 1;
  request.resume = true;
  request.out = out();
  EXPECT_THROW(exportStore(store, request, silent_), Error);
}

// Known because the bricks of both stores have equal bytes and checksums, and labels are grids of another type.
TEST_F(ExportVdb, TilesOfAnotherStoreOfEqualBricks_resumed_areRefused) {
  SourceInfo info = denseInfo(VoxelType::i16, {53, 49, 21});
  makeStore<std::int16_t>(directory_ / "s.kiln", info, denseValue<std::int16_t>);
  info.volume_class = VolumeClass::kLabels;
  makeStore<std::int16_t>(directory_ / "l.kiln", info, denseValue<std::int16_t>);
  const StoreReader values(directory_ / "s.kiln"), labels(directory_ / "l.kiln");
  ASSERT_EQ(values.manifest().index_checksum, labels.manifest().index_checksum);
  ExportRequest request = {.out = directory_ / "t_#.vdb", .tiles = 4};
  interruptTiles(values, request);
  request.resume = true;
  test::expectError([&] { exportStore(labels, request, silent_); }, ErrorCode::kExists, "is an unfinished export of");
  EXPECT_NO_THROW(exportStore(values, request, silent_));
}

TEST_F(ExportVdb, RefusesAnExistingFileAndReplacesItWhenTold) {
  makeStore<std::uint8_t>(directory_ / "s.kiln", denseInfo(VoxelType::u8, {9, 9, 9}), denseValue<std::uint8_t>);
  test::writeBytes(out(), {1, 2, 3});
  test::expectError([&] { exported(); }, ErrorCode::kExists, "--overwrite");
  EXPECT_EQ(fs::file_size(out()), 3u);
  EXPECT_GT(exported(/*overwrite=*/true).voxels, 0u);
}

// Known because one brick of 16 x 16 x 16 bytes with its apron takes more than 4 KiB: no brick may be read first. The
// named amount must suffice, and the volume is noise, of which the grid holds every voxel.
TEST_F(ExportVdb, NamesTheMemoryThatSuffices) {
  makeStore<std::uint8_t>(directory_ / "s.kiln", denseInfo(VoxelType::u8, {40, 33, 20}), denseValue<std::uint8_t>);
  const StoreReader store(directory_ / "s.kiln");
  const auto exportWithin = [&](std::uint64_t bytes) {
    exportVdb(store, exportedVolume(store, 0, {}), {.out = out(), .overwrite = true, .memory_bytes = bytes}, silent_);
  };
  std::string named;
  for (const std::uint64_t bytes : {std::uint64_t{0}, store.index().bytes() + 4096}) {
    try {
      exportWithin(bytes);
      FAIL() << "exported within " << bytes;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBudget);
      const std::string said = error.what();
      const std::size_t at = said.find("give --memory ") + 14;
      named = said.substr(at, said.find(',', at) - at);
    }
    EXPECT_FALSE(fs::exists(out()));
  }
  EXPECT_NO_THROW(exportWithin(parseBytes(named, "--memory"))) << named;
}

// A disk without sync or rename, a missing directory, a user who stops: no new file remains, and no old file is lost.
TEST_F(ExportVdb, AFailureLeavesNothing) {
  struct Stop : Progress {
    bool cancelled() const override { return true; }
  } stop;
  makeStore<std::uint8_t>(directory_ / "s.kiln", denseInfo(VoxelType::u8, {9, 9, 9}), denseValue<std::uint8_t>);
  const StoreReader store(directory_ / "s.kiln");
  for (const std::uint64_t change : {0, 1}) {
    test::FaultyFileSystem disk({change, EIO});
    EXPECT_THROW(exportVdb(store, exportedVolume(store, 0, {}), {.out = out()}, silent_, disk), Error);
    EXPECT_EQ(disk.calls(), change + 1);
  }
  EXPECT_THROW(exportVdb(store, exportedVolume(store, 0, {}), {.out = out()}, stop), Error);
  EXPECT_FALSE(fs::exists(out()));
  for (const auto& entry : fs::directory_iterator(out().parent_path())) EXPECT_NE(entry.path().extension(), ".tmp");
  EXPECT_THROW(exportVdb(store, exportedVolume(store, 0, {}), {.out = directory_ / "missing/out.vdb"}, silent_), Error);
}

#ifdef KILN_TEST_DATA_DIR
class RealExport : public ::testing::TestWithParam<const char*> {};

TEST_P(RealExport, ComesBack) {
  const fs::path path = fs::path(KILN_TEST_DATA_DIR) / "vdb" / GetParam();
  if (!fs::exists(path)) GTEST_SKIP() << path << " is not here; see shared/data/README.md";
  const test::ScratchDirectory directory;
  expectRoundTrip(path, directory / "s.kiln", directory / "out.vdb");
}
INSTANTIATE_TEST_SUITE_P(Files, RealExport, ::testing::Values("smoke.vdb", "sphere.vdb"));
#endif

}  // namespace
}  // namespace kiln
