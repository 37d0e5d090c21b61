// A store returns its voxels bit for bit, and its metadata follow FORMAT.md.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <iostream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file/file.h"
#include "base/hash.h"
#include "base/thread/parallel.h"
#include "grid/pyramid.h"
#include "store/store_reader.h"
#include "store/store_writer.h"
#include "support/files/foreign_files.h"
#include "support/files/vdb_files.h"
#include "support/reference/drawing.h"
#include "support/volumes/procedural.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/sub_bricks.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::int64_t kBrickSizes[] = {8, 16, 32, 64, 128};

std::vector<BrickKey> keysOf(const StoreReader& store) {
  std::vector<BrickKey> keys;
  const Extent3& n = store.index().lattice(0);
  for (std::int32_t z = 0; z < n.z; ++z) {
    for (std::int32_t y = 0; y < n.y; ++y) {
      for (std::int32_t x = 0; x < n.x; ++x) keys.push_back({0, {x, y, z}});
    }
  }
  return keys;
}

template <class F>
void forEachVoxel(const VoxelBox& box, F&& f) {
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) f(VoxelCoord{x, y, z});
    }
  }
}

// Puts values that a careless codec loses at random positions: extremes for integers. For floats also NaN, both
// infinities, -0.0, the smallest denormal, and values not representable as half.
template <class T>
void sprinkle(DenseVolume& volume, Random& random) {
  std::vector<T> specials = {std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max(), T(0), T(1)};
  if constexpr (std::is_floating_point_v<T>) {
    using Limits = std::numeric_limits<T>;
    const T more[] = {Limits::quiet_NaN(),
                      Limits::infinity(),
                      -Limits::infinity(),
                      T(-0.0),
                      Limits::denorm_min(),
                      T(65504),
                      T(65520),
                      T(1e-8),
                      T(0.1)};
    specials.insert(specials.end(), std::begin(more), std::end(more));
  }
  const auto count = static_cast<int>(volume.geometry.dims.count());
  for (int i = 0; i < 1 + count / 50; ++i) {
    const T value = specials[static_cast<std::size_t>(random.between(0, static_cast<int>(specials.size()) - 1))];
    std::memcpy(volume.voxels.data() + static_cast<std::size_t>(random.between(0, count - 1)) * sizeof(T), &value,
                sizeof(T));
  }
}

enum class Content { kNoise, kCheese, kSpecials, kConstant, kIsland, kContents };

DenseVolume makeVolume(Content content, const VolumeShape& shape, std::uint64_t seed) {
  Random random(seed ^ 0x51ab);
  const ValueRange range = usualRange(shape.type);
  switch (content) {
    case Content::kNoise:
      return noise(shape, seed, range);
    case Content::kCheese:
      return cheese(shape, seed, range);
    case Content::kConstant: {
      // -0.0 differs from 0.0, and an infinite value is legal.
      const double floats[] = {-0.0, std::numeric_limits<double>::infinity(), 0.1, range.hi};
      const double value = isFloating(shape.type) ? floats[random.between(0, 3)]
                           : random.chance(0.5)   ? range.lo
                                                  : range.hi;
      return fill(shape, [=](std::int64_t, std::int64_t, std::int64_t) { return value; });
    }
    case Content::kIsland:  // one voxel in a corner: most bricks are constant, those whose apron sees it are not
      return fill(shape, [=, n = shape.dims](std::int64_t i, std::int64_t j, std::int64_t k) {
        return i == n.x - 1 && j == n.y / 2 && k == n.z - 1 ? range.hi : 0.0;
      });
    default:
      break;
  }
  DenseVolume volume = cheese(shape, seed, range);
  withVoxelType(shape.type, [&]<class T>(std::type_identity<T>) { sprinkle<T>(volume, random); });
  return volume;
}

// Equal bits; a NaN keeps its position, not its payload (FORMAT.md).
template <class T>
bool same(T a, T b) {
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
  }
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

ValueRange rangeIn(const DenseVolume& volume, const VoxelBox& box) {
  ValueRange out;
  forEachVoxel(box, [&](const VoxelCoord& v) { out.include(volume.valueAt(v.x, v.y, v.z)); });
  return out;
}

template <class T>
void expectVoxels(const DenseVolume& volume, const BrickBlock& block) {
  std::int64_t wrong = 0;
  VoxelCoord first;
  forEachVoxel(block.extent, [&](const VoxelCoord& v) {
    if (same(block.data<T>()[block.offsetOf(v)], volume.at<T>(v.x, v.y, v.z))) return;
    if (wrong++ == 0) first = v;
  });
  EXPECT_EQ(wrong, 0) << "first at " << first.x << " " << first.y << " " << first.z;
}

void expectOctree(const DenseVolume& volume, const BrickBlock& block, std::int64_t brick_size) {
  ASSERT_EQ(block.octree.edge(0) * kCellSize, brick_size);
  ASSERT_EQ(block.octree.edge(block.octree.depth() - 1), 1);
  for (int level = 0; level < block.octree.depth(); ++level) {
    const std::int64_t size = kCellSize << level;
    forEachVoxel(boxOf({block.octree.edge(level), block.octree.edge(level), block.octree.edge(level)}),
                 [&](const VoxelCoord& node) {
                   const VoxelCoord lo = {block.core.lo.x + node.x * size, block.core.lo.y + node.y * size,
                                          block.core.lo.z + node.z * size};
                   const VoxelBox box = intersection({lo, {lo.x + size, lo.y + size, lo.z + size}}, block.core);
                   const ValueRange& found = block.octree.at(level, static_cast<int>(node.x), static_cast<int>(node.y),
                                                             static_cast<int>(node.z));
                   EXPECT_EQ(found, rangeIn(volume, box))
                       << "level " << level << " node " << node.x << " " << node.y << " " << node.z;
                 });
  }
}

// Tests for equal bits of all voxels of `box`, without NaN.
bool isConstant(const DenseVolume& volume, const VoxelBox& box) {
  return withVoxelType(volume.type, [&]<class T>(std::type_identity<T>) {
    const T first = volume.at<T>(box.lo.x, box.lo.y, box.lo.z);
    bool equal = first == first;
    forEachVoxel(box, [&](const VoxelCoord& v) {
      const T value = volume.at<T>(v.x, v.y, v.z);
      equal = equal && std::memcmp(&value, &first, sizeof(T)) == 0;
    });
    return equal;
  });
}

// Each range contains the values of its sub-brick, and is wider by less than a step at either end.
void expectSubRanges(const DenseVolume& volume, const StoreReader& store, const BrickKey& key) {
  const BrickEntry& entry = store.index().at(key);
  ASSERT_EQ(entry.sub_ranges == nullptr, entry.constant);
  if (entry.constant) return;
  const std::int64_t size = store.manifest().brick_size;
  const double step = (entry.support.hi - entry.support.lo) / 255 * (1 + 1e-12);
  forEachSubBrick(coreBox(key.brick, size, volume.geometry.dims), size, volume.geometry.dims,
                  [&](std::size_t i, const VoxelBox& voxels) {
                    const ValueRange expected = rangeIn(volume, voxels), found = entry.sub_ranges->at(i, entry.support);
                    EXPECT_EQ(found.empty(), expected.empty()) << "sub-brick " << i;
                    EXPECT_TRUE(found.contains(expected)) << "sub-brick " << i;
                    if (expected.empty() || !std::isfinite(step)) return;
                    EXPECT_LT(expected.lo - found.lo, step) << "sub-brick " << i;
                    EXPECT_LT(found.hi - expected.hi, step) << "sub-brick " << i;
                  });
}

void expectBrick(const DenseVolume& volume, const StoreReader& store, const BrickKey& key) {
  SCOPED_TRACE(brickPath(key));
  const BrickBlock block = store.read(key);
  EXPECT_EQ(block.core, coreBox(key.brick, store.manifest().brick_size, volume.geometry.dims));
  EXPECT_EQ(block.extent, dilated(block.core, 6));
  withVoxelType(volume.type, [&]<class T>(std::type_identity<T>) { expectVoxels<T>(volume, block); });
  expectOctree(volume, block, store.manifest().brick_size);

  const BrickEntry& entry = store.index().at(key);
  EXPECT_EQ(entry.core, rangeIn(volume, block.core));
  EXPECT_EQ(entry.support, rangeIn(volume, storedBox(block.core, 6, volume.geometry.dims)));
  EXPECT_EQ(entry.constant, isConstant(volume, storedBox(block.core, 6, volume.geometry.dims)));
  EXPECT_EQ(fs::exists(store.path() / brickPath(key)), !entry.constant);
  expectSubRanges(volume, store, key);
}

// Known: OpenVDB's own reader and writer reproduce the file, except for the UUID.
void expectWrittenAsByOpenVdb(const fs::path& file) {
  constexpr std::size_t kUuidAt = 21, kUuidEnd = 57;
  const std::vector<std::byte> ours = readFile(file);
  std::vector<std::byte> theirs = writtenAgain(file);
  ASSERT_EQ(theirs.size(), ours.size());
  std::copy(ours.begin() + kUuidAt, ours.begin() + kUuidEnd, theirs.begin() + kUuidAt);
  EXPECT_TRUE(theirs == ours);
}

// A brick file in OpenVDB's hands: exactly the core in `density` and the apron in `apron`, at global coordinates.
// With transforms in units of 2^unit_exponent world units.
void expectOpens(const DenseVolume& volume, const StoreReader& store, const BrickKey& key, int unit_exponent = 0) {
  SCOPED_TRACE(brickPath(key));
  glm::dmat4 unit_from_index = volume.geometry.world_from_index * std::ldexp(1.0, -unit_exponent);
  unit_from_index[3][3] = 1;
  const VoxelBox core = coreBox(key.brick, store.manifest().brick_size, volume.geometry.dims);
  const VoxelBox stored = storedBox(core, 6, volume.geometry.dims);
  const fs::path file = store.path() / brickPath(key);
  ASSERT_EQ(gridNames(file), (std::vector<std::string>{"apron", "cell_max", "cell_min", "density"}));
  expectWrittenAsByOpenVdb(file);
  for (const char* name : {"density", "apron"}) {
    SCOPED_TRACE(name);
    const DirectGrid grid(file, name);
    const auto active = grid.activeValues();
    const bool is_core = std::string_view(name) == "density";
    EXPECT_EQ(grid.background(), 0);
    EXPECT_EQ(grid.unitExponent(), unit_exponent);
    const std::int64_t expected = is_core ? core.count() : stored.count() - core.count();
    EXPECT_EQ(static_cast<std::int64_t>(active.size()), expected);
    std::int64_t wrong = 0;
    for (const auto& [v, value] : active) {
      wrong += !stored.contains(v) || core.contains(v) != is_core || !same(value, volume.valueAt(v.x, v.y, v.z));
    }
    EXPECT_EQ(wrong, 0);
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row)
        EXPECT_NEAR(grid.worldFromGrid()[column][row], unit_from_index[column][row], 1e-12);
    }
  }
  for (const char* name : {"cell_min", "cell_max"}) {
    SCOPED_TRACE(name);
    const DirectGrid grid(file, name);
    const bool least = std::string_view(name) == "cell_min";
    for (const auto& [c, value] : grid.activeValues()) {
      const VoxelBox cell = intersection({{c.x * 8, c.y * 8, c.z * 8}, {c.x * 8 + 8, c.y * 8 + 8, c.z * 8 + 8}}, core);
      const ValueRange range = rangeIn(volume, cell);
      EXPECT_EQ(value, least ? range.lo : range.hi);
    }
    EXPECT_EQ(grid.unitExponent(), unit_exponent);
    // Cell c has its centre between voxels 8c + 3 and 8c + 4.
    const glm::dvec4 origin = grid.worldFromGrid() * glm::dvec4(0, 0, 0, 1);
    const glm::dvec4 centre = unit_from_index * glm::dvec4(glm::dvec3(3.5), 1);
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(origin[axis], centre[axis], 1e-12);
  }
}

void expectStore(VoxelType type, std::int64_t brick_size, std::uint64_t seed, int largest) {
  Random random(seed);
  const auto content = static_cast<Content>(random.between(0, static_cast<int>(Content::kContents) - 1));
  Extent3 dims{random.between(1, largest), random.between(1, largest), random.between(1, largest)};
  if (random.chance(0.08)) dims = {1, 1, 1};
  if (random.chance(0.15)) dims = {std::min<std::int64_t>(brick_size, largest), dims.y, dims.z};
  const std::string what = std::string(nameOf(type)) + " seed " + std::to_string(seed) + " content " +
                           std::to_string(int(content)) + " dims " + std::to_string(dims.x) + "x" +
                           std::to_string(dims.y) + "x" + std::to_string(dims.z) + " bricks of " +
                           std::to_string(brick_size);
  SCOPED_TRACE(what);
  const DenseVolume volume =
      makeVolume(content, {dims, type, random.chance(0.5) ? obliqueAffine() : anisotropicAffine()}, seed);
  const std::string name =
      "format_" + std::string(nameOf(type)) + "_" + ::testing::UnitTest::GetInstance()->current_test_info()->name();
  const fs::path path = makeStore(volume, name.substr(0, name.find('/')), brick_size);
  const StoreReader store(path);

  std::uint64_t files = 0, bytes = 0, nans = 0;
  ValueRange all;
  for (const BrickKey& key : keysOf(store)) {
    expectBrick(volume, store, key);
    if (::testing::Test::HasFailure()) return;  // the messages of a single brick suffice
    files += !store.index().at(key).constant;
    bytes += store.index().at(key).file_bytes;
  }
  forEachVoxel(boxOf(dims), [&](const VoxelCoord& v) {
    const double value = volume.valueAt(v.x, v.y, v.z);
    nans += std::isnan(value);
    all.include(value);
  });
  const Manifest& manifest = store.manifest();
  EXPECT_EQ(manifest.range, all);
  EXPECT_EQ(manifest.nan_count, nans);
  EXPECT_EQ(manifest.levels[0].stored_bricks, files);
  EXPECT_EQ(manifest.levels[0].stored_bytes, bytes);
  std::uint64_t counted = 0;
  for (const std::uint64_t n : manifest.histogram.counts) counted += n;
  EXPECT_EQ(counted + nans, static_cast<std::uint64_t>(dims.count()));
  for (std::size_t level = 1; level < manifest.levels.size(); ++level) files += manifest.levels[level].stored_bricks;
  EXPECT_EQ(wholeFiles(path), files + 2);

  // A single thread and all threads write equal bytes to every file.
  const auto first = filesOf(path);
  const ThreadLimit one(1);
  EXPECT_EQ(filesOf(makeStore(volume, name.substr(0, name.find('/')), brick_size)), first);
}

class StoreFormat : public ::testing::TestWithParam<VoxelType> {};

// Known because the source is in memory: the voxels read back are compared voxel by voxel, and every derived number
// with the plain loop that defines the number.
TEST_P(StoreFormat, KeepsEveryVoxel) {
  const std::uint64_t first = 1000 * (1 + static_cast<std::uint64_t>(GetParam()));
  std::cout << "seeds from " << first << '\n';
  std::uint64_t seed = first;
  for (const std::int64_t brick_size : kBrickSizes) {
    // Small bricks have relatively large aprons: fewer voxels take the same time.
    for (int i = 0; i < 3; ++i)
      expectStore(GetParam(), brick_size, seed++, brick_size == 8 ? 24 : brick_size == 16 ? 40 : 70);
  }
}

TEST_P(StoreFormat, NightlyKeepsEveryVoxel) {
  const std::uint64_t first = 1'000'000 * (1 + static_cast<std::uint64_t>(GetParam()));
  std::cout << "seeds from " << first << '\n';
  std::uint64_t seed = first;
  for (int i = 0; i < 40; ++i) {
    for (const std::int64_t brick_size : kBrickSizes) expectStore(GetParam(), brick_size, seed++, 70);
  }
}

// Known because every content meets every type once, in a volume of several bricks along each axis.
TEST_P(StoreFormat, OpensInPlainOpenVdb) {
  for (int content = 0; content < static_cast<int>(Content::kContents); ++content) {
    SCOPED_TRACE(content);
    const DenseVolume volume =
        makeVolume(static_cast<Content>(content), {{37, 18, 21}, GetParam(), obliqueAffine()}, 5);
    const StoreReader store(makeStore(volume, "format_opens_" + std::string(nameOf(GetParam())), 16));
    for (const BrickKey& key : keysOf(store)) {
      if (!store.index().at(key).constant) expectOpens(volume, store, key);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Types, StoreFormat, ::testing::ValuesIn(kAllTypes),
                         [](const auto& type) { return std::string(nameOf(type.param)); });

// Known from FORMAT.md: voxel (0,0,0) alone is a volume; its store has one constant brick and no brick file.
TEST(StoreFormatEdges, OneVoxelIsAStore) {
  const DenseVolume volume = fill({{1, 1, 1}, VoxelType::f64}, [](auto, auto, auto) { return -0.0; });
  const StoreReader store(makeStore(volume, "format_one"));
  EXPECT_EQ(filesOf(store.path()).size(), 2u);
  const BrickBlock block = store.read({0, {0, 0, 0}});
  for (std::int64_t i = 0; i < block.extent.count(); ++i) EXPECT_TRUE(same(block.data<double>()[i], -0.0));
}

// Known because OpenVDB refuses voxels of less than 3e-15 cubic units, and the manifest has doubles, as the source has.
TEST(StoreFormatEdges, VoxelsTooSmallForOpenVdbAreAStore) {
  for (const glm::dmat4& shape : {glm::dmat4(1), anisotropicAffine(), obliqueAffine()}) {
    for (const double scale : {1e-5, 1e-6, 1e-90}) {
      SCOPED_TRACE(scale);
      DenseVolume volume = cheese({{37, 18, 21}, VoxelType::f32, scale * shape}, 5, usualRange(VoxelType::f32));
      volume.geometry.world_from_index[3][3] = 1;
      const StoreReader store(makeStore(volume, "format_small_voxels", 16));
      EXPECT_EQ(store.manifest().geometry().world_from_index, volume.geometry.world_from_index);
      const int exponent = std::ilogb(volume.geometry.meanSpacing());
      for (const BrickKey& key : keysOf(store)) {
        expectBrick(volume, store, key);
        if (!store.index().at(key).constant) expectOpens(volume, store, key, exponent);
      }
    }
  }
}

// Known because doubles near 1e17 are 16 apart.
TEST(StoreFormatEdges, VoxelsThatAreNotToldApartAreRefused) {
  const DenseVolume volume =
      noise({{9, 9, 9}, VoxelType::u8, spacingAffine(glm::dvec3(1), glm::dvec3(1e17))}, 1, usualRange(VoxelType::u8));
  expectError([&] { makeStore(volume, "format_far_origin"); }, ErrorCode::kUnsupported, "origin nearer to 0");
}

// Known because NaN never equals itself: bricks of only NaN are stored with files, and their range is empty.
TEST(StoreFormatEdges, NothingButNanIsAStore) {
  const DenseVolume volume = fill({{20, 9, 11}, VoxelType::f32}, [](auto, auto, auto) { return std::nan(""); });
  const StoreReader store(makeStore(volume, "format_nan", 8));
  EXPECT_TRUE(store.manifest().range.empty());
  EXPECT_EQ(store.manifest().nan_count, 20u * 9 * 11);
  EXPECT_EQ(wholeFiles(store.path()), 2u + 3 * 2 * 2 + 2 * 1 * 1 + 1);
  for (const BrickKey& key : keysOf(store)) expectBrick(volume, store, key);
}

// Known because formats differ only in the index: an earlier store opens, passes verification and draws the picture.
TEST(StoreFormatEdges, StoresOfEarlierFormatsOpen) {
  const DenseVolume volume = cheese({{60, 41, 37}, VoxelType::u8}, 3, usualRange(VoxelType::u8));
  const fs::path store = makeStore(volume, "earlier", 64);
  const RandomScene scene = randomScene(4, volume, {60, 50});
  const FrameRequest request = requestOf(scene, Lattice::kPixel, 0.99);
  const Image picture = draw(store, request);
  const std::uint64_t files = wholeFiles(store);
  const BrickKey first{0, {0, 0, 0}};
  EXPECT_EQ(StoreReader(store).index().at(first).sub_ranges->along(), 8);
  for (const int format : {3, 2, 1}) {
    makeFormat(format, store);
    const StoreReader reader(store);
    EXPECT_EQ(reader.manifest().format, format);
    const SubRanges* const ranges = reader.index().at(first).sub_ranges.get();
    EXPECT_EQ(ranges == nullptr ? 0 : ranges->along(), format == 3 ? 8 : format == 2 ? 4 : 0);
    EXPECT_TRUE(equalBits(draw(store, request), picture)) << "format " << format;
    EXPECT_EQ(wholeFiles(store), files) << "format " << format;
  }
}

// --- manifest
// ---------------------------------------------------------------------------------------------------------

// A manifest with something unusual under every key.
Manifest unusualManifest() {
  Manifest m;
  m.type = VoxelType::f32;
  m.range = {-std::numeric_limits<double>::infinity(), 0.1};
  m.nan_count = 12345678901234ull;
  m.histogram = {-1024.5, 3071.25, std::vector<std::uint64_t>(256, 7)};
  m.background = std::numeric_limits<double>::infinity();
  m.volume_class = VolumeClass::kLevelSet;
  m.brick_size = 64;
  LevelInfo level;
  level.geometry.dims = {100, 2000, 65};
  level.geometry.world_from_index = obliqueAffine();
  level.geometry.frame = PatientFrame::kLps;
  level.geometry.unit = "µm \"quoted\"";
  level.bricks = brickLattice(level.geometry.dims, 64);
  level.stored_bricks = 3;
  level.stored_bytes = 99999;
  LevelInfo coarser;
  coarser.geometry = coarserThan(level.geometry);
  coarser.bricks = brickLattice(coarser.geometry.dims, 64);
  m.levels = {level, coarser};
  m.container_version = "OpenVDB 10.0.1";
  m.source.format = "OpenVDB";
  m.source.files = {"/a b/ü.vdb", "\\ \" checksum\": \""};
  m.source.command = "kiln convert \"checksum\": \"00000000000000000000000000000000\"";
  m.source.time = "2000-01-01T00:00:00Z";
  m.source.vdb = VdbOrigin{"density", {-5, 7, -900}, anisotropicAffine()};
  m.index_bytes = 4242;
  m.index_checksum = hashOf(std::string_view("index"));
  return m;
}

// Returns the error of parsing `json`, or an empty text.
std::string complaintOf(const Json& json, ErrorCode expected = ErrorCode::kFormat) {
  try {
    parseManifest(restamped(json.dump(1)), "M/manifest.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), expected) << error.what();
    EXPECT_EQ(error.path(), "M/manifest.json") << error.what();
    return error.what();
  }
  return "";
}

// Known because equal texts are equal manifests: every field is in the text.
TEST(StoreManifest, ComesBackAsItWas) {
  const std::string text = manifestText(unusualManifest());
  const Manifest back = parseManifest(text, "m");
  EXPECT_EQ(manifestText(back), text);
  EXPECT_EQ(restamped(text), text);
  EXPECT_EQ(back.geometry().unit, "µm \"quoted\"");
  EXPECT_EQ(back.background, std::numeric_limits<double>::infinity());
  EXPECT_EQ(back.source.vdb->index_origin, (VoxelCoord{-5, 7, -900}));
  Manifest other = back;
  other.background = std::nan("");
  other.range = {};
  other.source.vdb.reset();
  other.volume_class = VolumeClass::kFog;
  EXPECT_EQ(manifestText(parseManifest(manifestText(other), "m")), manifestText(other));
}

// Known from FORMAT.md, Versions: a reader refuses an unknown format number and names the number.
TEST(StoreManifest, RefusesAnotherFormat) {
  Json json = Json::parse(manifestText(unusualManifest()));
  for (const int format : {0, 6}) {
    json["kiln"] = format;
    const std::string said = complaintOf(json, ErrorCode::kUnsupported);
    EXPECT_NE(said.find("kiln: store format " + std::to_string(format)), std::string::npos) << said;
  }
}

// Calls f(object, key, place) for every key of the manifest, including keys of inner objects.
template <class F>
void forEachKey(const Json& root, F&& f) {
  for (const auto& [key, value] : root.items()) {
    f(Json::json_pointer("/" + key), key);
    if (value.is_object()) {
      for (const auto& [inner, unused] : value.items()) f(Json::json_pointer("/" + key + "/" + inner), inner);
    }
  }
  for (const auto& [inner, unused] : root["levels"][0].items()) f(Json::json_pointer("/levels/0/" + inner), inner);
}

// Known because no voxel of the type has such a value. A loop over the range of 16 bits would not end.
TEST(StoreManifest, RangeBeyondItsType_isRefused) {
  Json json = Json::parse(manifestText(unusualManifest()));
  json["type"] = "u16";
  for (const auto& [lo, hi] : {std::pair(0.0, 2147483647.0), {-1.0, 5.0}, {0.0, 4.6e18}, {7.0, 6.0}}) {
    json["range"] = {lo, hi};
    EXPECT_NE(complaintOf(json).find("range"), std::string::npos) << lo << " to " << hi;
  }
  json["range"] = {0, 65535};
  EXPECT_EQ(complaintOf(json).find("range"), std::string::npos);
}

// Known from FORMAT.md: every key is required. A manifest with a missing key and a valid checksum is refused by the
// key's name.
TEST(StoreManifest, NamesTheMissingKey) {
  const Json whole = Json::parse(manifestText(unusualManifest()));
  int keys = 0;
  forEachKey(whole, [&](const Json::json_pointer& place, const std::string& key) {
    if (place.to_string() == "/checksum" || key == "grid")
      return;  // `checksum` is tested with damage; without `grid`, its sibling keys are unknown
    Json json = whole;
    json.at(place.parent_pointer()).erase(key);
    EXPECT_NE(complaintOf(json).find(key + ": is missing"), std::string::npos) << place;
    ++keys;
  });
  EXPECT_GE(keys, 35);
}

TEST(StoreManifest, NamesTheUnknownKey) {
  // Known from FORMAT.md, Versions: an unknown key is an error in every object.
  const Json whole = Json::parse(manifestText(unusualManifest()));
  for (const char* place : {"", "/histogram", "/levels/0", "/codec", "/index", "/source"}) {
    Json json = whole;
    Json& object = json.at(Json::json_pointer(place));
    Json with = {{"novelty", 1}};  // inserted first, so that the checksum stays last
    with.update(object);
    object = with;
    EXPECT_NE(complaintOf(json).find("novelty"), std::string::npos) << place;
  }
}

// Known because no key's value may be an object with a strange key, or a negative number with a fraction.
TEST(StoreManifest, NamesTheKeyOfAWrongValue) {
  const Json whole = Json::parse(manifestText(unusualManifest()));
  for (const Json& wrong : {Json{{"strange", 1}}, Json(-1.5), Json("wrong"), Json(nullptr), Json::array(), Json(1e300),
                            Json(18446744073709551615ull)}) {
    forEachKey(whole, [&](const Json::json_pointer& place, const std::string& key) {
      const std::string where = place.to_string();
      if (where == "/checksum") return;
      const bool text = whole.at(place).is_string();
      const bool number = where == "/background" || where == "/histogram/lo" || where == "/histogram/hi";
      if (text && wrong.is_string() && key != "type" && key != "class" && key != "frame" && where != "/index/checksum")
        return;  // any text is accepted
      if (number && wrong.is_number()) return;
      if (where == "/range" && wrong.is_null()) return;
      if ((key == "counts" || key == "files") && wrong.is_array()) return;
      Json json = whole;
      json.at(place) = wrong;
      const std::string said = complaintOf(json);
      EXPECT_NE(said.find(key), std::string::npos) << where << " = " << wrong;
      if (where == "/kiln" && wrong.is_number_integer()) return;
      EXPECT_NE(said.find("; restore this file of the store, or convert the source again"), std::string::npos) << said;
    });
  }
}

// Known because OpenVDB's position of a grid and the counts of a histogram are integers, and some keys accept a single
// value.
TEST(StoreManifest, SaysWhatItFound) {
  const Json whole = Json::parse(manifestText(unusualManifest()));
  const auto expect = [&](const char* place, const Json& value, const std::string& says) {
    Json json = whole;
    json.at(Json::json_pointer(place)) = value;
    const std::string said = complaintOf(json);
    EXPECT_NE(said.find(says), std::string::npos) << said;
  };
  expect("/source/indexOrigin/1", 1.5, "source.indexOrigin: expected 3 whole numbers (found [-5,1.5,-900])");
  expect("/histogram/counts/0", -1, "histogram.counts: expected a list of whole numbers from 0 on (found [-1,");
  expect("/histogram/counts/0", 0.5, "histogram.counts: expected a list of whole numbers from 0 on (found [0.5,");
  expect("/codec/compression", "zip", "codec.compression: expected \"blosc\" (found \"zip\")");
  expect("/index/file", "../x", "index.file: expected \"index.bin\" (found \"../x\")");
  expect("/apron", 65, "apron: expected a whole number from 1 to 64 (found 65)");
  expect("/dimensions/0", -3, "dimensions: expected three whole numbers from 1 to 2147483647 (found [-3,");
  expect("/affine/0", 1e300, "affine: geometry: a spacing must be from 1e-100 to 1e+100 world units (found 1e+300)");
  expect("/source/files", 7, "source.files: expected a list of texts (found 7)");
}

// Known because two numbers of a manifest determine others: inconsistent numbers are refused.
TEST(StoreManifest, RefusesWhatContradictsItself) {
  const Json whole = Json::parse(manifestText(unusualManifest()));
  const auto with = [&](const char* place, const Json& value) {
    Json json = whole;
    json.at(Json::json_pointer(place)) = value;
    return complaintOf(json);
  };
  EXPECT_NE(with("/levels/0/bricks/0", 3).find("bricks"), std::string::npos);
  EXPECT_NE(with("/levels/1/dimensions/0", 49).find("levels[1]"), std::string::npos);
  EXPECT_NE(with("/levels/1/affine/3", 0.25).find("levels[1]"), std::string::npos);
  EXPECT_NE(with("/dimensions/1", 1999).find("levels"), std::string::npos);
  EXPECT_NE(with("/affine/3", 0.5).find("levels"), std::string::npos);
  EXPECT_NE(with("/brickSize", 63).find("brickSize"), std::string::npos);
  EXPECT_NE(with("/apron", 0).find("apron"), std::string::npos) << "kernels read a voxel beside each";
  EXPECT_NE(with("/dimensions/1", 0).find("dimensions"), std::string::npos);
  EXPECT_NE(with("/dimensions/1", 1ll << 40).find("dimensions"), std::string::npos);
}

// Known from FORMAT.md: a look is in format 5 only, so earlier readers refuse no store that they could draw.
TEST(StoreManifest, LookComesBackInItsFormatOnly) {
  Manifest m = unusualManifest();
  m.look = {DeclaredLook::Ramp{-0.1, 1e9, {1, 2, 255, 255}}, {{-3, {255, 0, 0, 255}}, {12, {0, 255, 0, 7}}}};
  EXPECT_TRUE(parseManifest(manifestText(m), "m").look.empty());
  m.format = kFormatVersion;
  EXPECT_EQ(parseManifest(manifestText(m), "m").look, m.look);
  // As many as an atlas of cells has: keys of an object are not sought one by one.
  for (std::int64_t label = 1; label <= 36'000; ++label)
    m.look.labels.push_back({2 * label + 12, {static_cast<std::uint8_t>(label % 256), 0, 0, 255}});
  EXPECT_EQ(parseManifest(manifestText(m), "m").look, m.look);
  m.look = {};
  EXPECT_TRUE(parseManifest(manifestText(m), "m").look.empty());
}

TEST(StoreManifest, WrongLook_isNamed) {
  Manifest m = unusualManifest();
  m.format = kFormatVersion;
  m.look = {DeclaredLook::Ramp{0, 1, {}}, {{3, {}}}};
  const Json whole = Json::parse(manifestText(m));
  const auto with = [&](const char* place, const Json& value) {
    Json json = whole;
    json.at(Json::json_pointer(place)) = value;
    return complaintOf(json);
  };
  EXPECT_NE(with("/look", 3).find("look.: expected an object"), std::string::npos) << with("/look", 3);
  EXPECT_NE(with("/look/ramp/end", 0).find("look.ramp.end: expected a number above begin"), std::string::npos);
  EXPECT_NE(with("/look/ramp/begin", "-inf").find("look.ramp.end"), std::string::npos);
  EXPECT_NE(with("/look/ramp/color", "#12345").find("look.ramp.color: expected #rrggbb"), std::string::npos);
  EXPECT_NE(with("/look/labels/3", "red").find("look.labels.3: expected #rrggbb"), std::string::npos);
  EXPECT_NE(with("/look/labels", Json{{"x", "#000000"}}).find("look.labels.x: expected a whole number"),
            std::string::npos);
}

}  // namespace
}  // namespace kiln::test
