// An array in memory is the volume that its conversion makes: manifest, index, every brick and every picture are equal,
// for each type, order in memory, size of bricks and affine. Known because a store is the conversion of equal voxels.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <optional>

#include "base/error.h"
#include "base/file/file.h"
#include "convert/open_array.h"
#include "sequence/render_job_run.h"
#include "store/brick_index.h"
#include "store/codec/brick_block.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

VoxelArray arrayOf(const DenseVolume& volume) {
  VoxelArray out;
  out.voxels = volume.voxels.data();
  out.type = volume.type;
  out.geometry = volume.geometry;
  return out;
}

// A volume in another order of memory, with gaps between voxels.
struct LaidOutVolume {
  std::vector<std::byte> bytes;
  VoxelArray array;
};

// `order` names the axes, nearest neighbours first; axes in `reversed` run backwards.
LaidOutVolume laidOut(const DenseVolume& volume, const std::array<int, 3>& order, const std::array<bool, 3>& reversed,
                      std::int64_t gap) {
  const Extent3& n = volume.geometry.dims;
  const auto voxel = static_cast<std::int64_t>(sizeOf(volume.type));
  LaidOutVolume out{{}, arrayOf(volume)};
  std::array<std::int64_t, 3> strides{};
  std::int64_t bytes = voxel + gap, first = 0;
  for (const int axis : order) {
    const auto a = static_cast<std::size_t>(axis);
    strides[a] = reversed[a] ? -bytes : bytes;
    if (reversed[a]) first += bytes * (n[axis] - 1);
    bytes = bytes * n[axis] + gap;
  }
  out.bytes.resize(static_cast<std::size_t>(bytes));
  std::size_t i = 0;
  for (std::int64_t z = 0; z < n.z; ++z) {
    for (std::int64_t y = 0; y < n.y; ++y) {
      for (std::int64_t x = 0; x < n.x; ++x, i += static_cast<std::size_t>(voxel))
        std::memcpy(out.bytes.data() + first + x * strides[0] + y * strides[1] + z * strides[2],
                    volume.voxels.data() + i, static_cast<std::size_t>(voxel));
    }
  }
  out.array.voxels = out.bytes.data() + first;
  out.array.strides = strides;
  return out;
}

void expectEqualManifests(const Manifest& found, const Manifest& expected) {
  EXPECT_EQ(found.type, expected.type);
  EXPECT_EQ(found.range, expected.range);
  EXPECT_EQ(found.nan_count, expected.nan_count);
  EXPECT_EQ(found.histogram.lo, expected.histogram.lo);
  EXPECT_EQ(found.histogram.hi, expected.histogram.hi);
  EXPECT_EQ(found.histogram.counts, expected.histogram.counts);
  EXPECT_EQ(found.volume_class, expected.volume_class);
  ASSERT_EQ(found.levels.size(), expected.levels.size());
  for (std::size_t l = 0; l < found.levels.size(); ++l) {
    EXPECT_EQ(found.levels[l].bricks, expected.levels[l].bricks);
    EXPECT_EQ(found.levels[l].geometry.dims, expected.levels[l].geometry.dims);
    EXPECT_EQ(found.levels[l].geometry.world_from_index, expected.levels[l].geometry.world_from_index);
  }
}

void expectEqualEntries(const BrickEntry& found, const BrickEntry& expected) {
  EXPECT_EQ(found.constant, expected.constant);
  EXPECT_EQ(found.core, expected.core);
  EXPECT_EQ(found.support, expected.support);
  ASSERT_EQ(found.sub_ranges == nullptr, expected.sub_ranges == nullptr);
  if (expected.sub_ranges) {
    EXPECT_EQ(*found.sub_ranges, *expected.sub_ranges);
  }
}

void expectEqualBlocks(const BrickBlock& found, const BrickBlock& expected) {
  EXPECT_EQ(found.core, expected.core);
  EXPECT_EQ(found.extent, expected.extent);
  EXPECT_TRUE(found.voxels == expected.voxels);
  ASSERT_EQ(found.octree.depth(), expected.octree.depth());
  EXPECT_TRUE(std::ranges::equal(found.octree.cells(), expected.octree.cells()));
  ASSERT_EQ(found.supports.edge(), expected.supports.edge());
  const int edge = expected.supports.edge();
  for (int i = 0; i < edge * edge * edge; ++i) {
    const int x = i % edge, y = i / edge % edge, z = i / edge / edge;
    EXPECT_EQ(found.supports.at(x, y, z), expected.supports.at(x, y, z));
  }
}

void expectEqualVolumes(const BrickedVolume& found, const BrickedVolume& expected) {
  expectEqualManifests(found.manifest(), expected.manifest());
  for (int level = 0; level < expected.index().levels(); ++level) {
    const Extent3& lattice = expected.index().lattice(level);
    for (std::int64_t i = 0; i < lattice.count(); ++i) {
      const BrickKey key{level, brickAt(lattice, i)};
      SCOPED_TRACE("level " + std::to_string(level) + ", brick " + std::to_string(i));
      expectEqualEntries(found.index().at(key), expected.index().at(key));
      expectEqualBlocks(found.read(key), expected.read(key));
      if (::testing::Test::HasFailure()) return;
    }
  }
}

struct ArrayCase {
  const char* name;
  std::function<DenseVolume()> volume;
  std::int64_t brick_size;
  bool labels = false;
};

const ArrayCase kArrayCases[] = {
    {"bytes",
     [] {
       return head({{75, 61, 90}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8));
     },
     32},
    {"shorts",
     [] {
       return cheese({{40, 51, 37}, VoxelType::i16, anisotropicAffine()}, 1, usualRange(VoxelType::i16));
     },
     16},
    {"floats_with_nan", [] { return smallHead(VoxelType::f32); }, 16},
    {"smallest_bricks", [] { return smallHead(VoxelType::f32); }, 8},
    {"doubles",
     [] {
       return noise({{21, 19, 17}, VoxelType::f64}, 2, {-1e300, 1e300});
     },
     8},
    {"wide_integers",
     [] {
       return noise({{33, 9, 17}, VoxelType::u32}, 3, usualRange(VoxelType::u32));
     },
     16},
    {"labels",
     [] {
       return cheese({{50, 33, 40}, VoxelType::u16}, 4, {0, 7});
     },
     16, true},
    {"one_value",
     [] {
       return fill({{40, 40, 40}, VoxelType::i8}, [](auto, auto, auto) { return -3.0; });
     },
     16},
    {"a_constant_part",
     [] {
       return fill({{64, 48, 40}, VoxelType::u8},
                   [](auto i, auto j, auto k) { return i < 40 ? 5.0 : static_cast<double>((i * j + k) % 251); });
     },
     8},
    {"one_voxel",
     [] {
       return fill({{1, 1, 1}, VoxelType::f32}, [](auto, auto, auto) { return 2.5; });
     },
     32},
};

class OpenArray : public ::testing::TestWithParam<ArrayCase> {
 protected:
  std::unique_ptr<BrickedVolume> opened(const VoxelArray& array) {
    ArrayOptions options;
    options.brick_size = GetParam().brick_size;
    options.labels = GetParam().labels;
    return openArray(array, options, silent_);
  }
  Progress silent_;
};

TEST_P(OpenArray, AnyOrderInMemory_isTheConversion) {
  const DenseVolume volume = GetParam().volume();
  const StoreReader store(makeStore(volume, "store", GetParam().brick_size, GetParam().labels));
  expectEqualVolumes(*opened(arrayOf(volume)), store);
  const LaidOutVolume z_fastest = laidOut(volume, {2, 1, 0}, {false, false, false}, 0);
  expectEqualVolumes(*opened(z_fastest.array), store);
  const LaidOutVolume odd = laidOut(volume, {1, 0, 2}, {true, false, true}, 3);
  expectEqualVolumes(*opened(odd.array), store);
}

INSTANTIATE_TEST_SUITE_P(Volumes, OpenArray, ::testing::ValuesIn(kArrayCases),
                         [](const auto& info) { return std::string(info.param.name); });

RenderJob jobOf(const std::filesystem::path& store) {
  RenderJob out;
  out.volume = store;
  out.picture.size = {61, 47};
  out.picture.clipping.planes = {{{1, 0.3, 0.2}, 20}};
  return out;
}

// Each engine, coarser levels, and a budget of few bricks.
TEST(OpenArrayPictures, EachEngine_drawsTheStoresPicture) {
  const DenseVolume volume = head({{75, 61, 90}, VoxelType::i16, obliqueAffine()}, usualRange(VoxelType::i16));
  RenderJob job = jobOf(makeStore(volume, "store", 16));
  Progress silent;
  const std::unique_ptr<BrickedVolume> array = openArray(arrayOf(volume), {.brick_size = 16}, silent);
  const BrickedVolume* const volumes[] = {array.get()};
  struct Engine {
    Mode mode;
    Lattice lattice;
    int coarser;
  };
  constexpr Engine kEngines[] = {{Mode::kComposite, Lattice::kPixel, 0},
                                 {Mode::kComposite, Lattice::kPixel, 1},
                                 {Mode::kComposite, Lattice::kVoxel, 0},
                                 {Mode::kMip, Lattice::kPixel, 0}};
  for (const auto& [mode, lattice, coarser] : kEngines) {
    job.picture.mode = mode, job.picture.lattice = lattice, job.picture.coarser = coarser;
    const RenderResult expected = runRenderJob(job, 1, silent), found = runRenderJob(job, volumes, silent);
    EXPECT_TRUE(showsSomething(expected.image));
    EXPECT_TRUE(equalBits(found.image, expected.image));
    EXPECT_EQ(found.statistics.frames[0].voxels_visited, expected.statistics.frames[0].voxels_visited);
    EXPECT_EQ(found.statistics.frames[0].bricks_hidden, expected.statistics.frames[0].bricks_hidden);
  }
}

// The volumes have different units, so that a picture moves one of them. The caller's volumes stay where they are.
TEST(OpenArrayPictures, SeveralVolumes_drawTheStoresPicture) {
  std::vector<DenseVolume> volumes = {smallHead(VoxelType::u8),
                                      ball({{30, 30, 30}, VoxelType::u8}, {15, 15, 15}, 9, 200)};
  volumes[0].geometry.unit = "mm";
  volumes[1].geometry.unit = "cm";
  RenderJob job = jobOf({});
  Progress silent;
  std::vector<std::unique_ptr<BrickedVolume>> arrays;
  std::vector<const BrickedVolume*> opened;
  for (std::size_t v = 0; v < volumes.size(); ++v) {
    VolumeOptions& options = job.volumes.emplace_back();
    options.volume = makeStore(volumes[v], "store" + std::to_string(v), 16);
    opened.push_back(arrays.emplace_back(openArray(arrayOf(volumes[v]), {.brick_size = 16}, silent)).get());
  }
  job.volume = job.volumes.front().volume;
  const Image expected = runRenderJob(job, 1, silent).image;
  EXPECT_TRUE(showsSomething(expected));
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(equalBits(runRenderJob(job, opened, silent).image, expected));
  EXPECT_EQ(opened[1]->manifest().geometry().unit, "cm");
  opened.pop_back();
  EXPECT_THROW(runRenderJob(job, opened, silent), Error);
}

// A job's trace has a frame whatever holds its volumes.
TEST(OpenArrayPictures, JobWithTrace_writesTheTrace) {
  const DenseVolume volume = smallHead(VoxelType::u8);
  RenderJob job = jobOf({});
  job.trace = freshDirectory("array_trace") / "trace.json";
  Progress silent;
  const std::unique_ptr<BrickedVolume> array = openArray(arrayOf(volume), {.brick_size = 16}, silent);
  const BrickedVolume* const volumes[] = {array.get()};
  runRenderJob(job, volumes, silent);
  EXPECT_NE(readTextFile(job.trace).find("\"frame\""), std::string::npos);
}

TEST(OpenArrayErrors, WrongArray_isRefused) {
  Progress silent;
  const DenseVolume volume = smallHead(VoxelType::f32);
  const auto codeOf = [&](const VoxelArray& array, const ArrayOptions& options) -> std::optional<ErrorCode> {
    try {
      openArray(array, options, silent);
    } catch (const Error& error) {
      return error.code();
    }
    return std::nullopt;
  };
  VoxelArray null = arrayOf(volume), flat = null, singular = null;
  null.voxels = nullptr;
  flat.geometry.dims.y = 0;
  singular.geometry.world_from_index[1] = {};
  EXPECT_EQ(codeOf(null, {}), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(flat, {}), ErrorCode::kFormat);
  EXPECT_EQ(codeOf(singular, {}), ErrorCode::kFormat);
  EXPECT_EQ(codeOf(arrayOf(volume), {.brick_size = 48}), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(arrayOf(volume), {.labels = true}), ErrorCode::kUsage);
  EXPECT_EQ(codeOf(arrayOf(volume), {.brick_size = 8, .memory_bytes = 1000}), ErrorCode::kBudget);
}

}  // namespace
}  // namespace kiln::test
