// OpenVDB grids. Known because OpenVDB's own io::File and getValue read the file (tests/support/files/vdb_files.h),
// or because the grid is filled here with a known function of the coordinate.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/ext/matrix_transform.hpp>
#include <random>
#include <thread>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "ingest/source/formats.h"
#include "support/files/nifti_files.h"
#include "support/files/vdb_files.h"
#include "support/system/sanitized.h"

namespace kiln {
namespace {
namespace fs = std::filesystem;
using test::VdbKind;

std::vector<double> readBox(VolumeSource& source, const VoxelBox& box) {
  std::vector<std::byte> raw(static_cast<std::size_t>(box.count()) * sizeOf(source.info().type));
  source.read(box, raw);
  std::vector<double> out;
  withVoxelType(source.info().type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t at = 0; at < raw.size(); at += sizeof(T)) {
      T value;
      std::memcpy(&value, raw.data() + at, sizeof(T));
      out.push_back(static_cast<double>(value));
    }
  });
  return out;
}

// Every voxel, or every `step`-th, of the source against OpenVDB's own reading.
void expectSame(VolumeSource& source, const test::DirectGrid& direct, std::int64_t step = 1) {
  const SourceInfo& info = source.info();
  const VoxelBox box = direct.activeBox();
  ASSERT_TRUE(info.vdb);
  EXPECT_EQ(info.vdb->index_origin, box.lo);
  ASSERT_EQ(info.geometry.dims, box.extent());
  EXPECT_EQ(info.background, direct.background());
  EXPECT_EQ(info.volume_class, direct.levelSet() ? VolumeClass::kLevelSet : VolumeClass::kFog);
  for (const glm::dvec3 v : {glm::dvec3(0), glm::dvec3(3, 1, 2)}) {
    const glm::dvec3 lo(static_cast<double>(box.lo.x), static_cast<double>(box.lo.y), static_cast<double>(box.lo.z));
    const glm::dvec3 expected(direct.worldFromGrid() * glm::dvec4(lo + v, 1));
    for (int a = 0; a < 3; ++a)
      EXPECT_NEAR(info.geometry.worldOf(v)[a], expected[a], 1e-9 * (1 + std::abs(expected[a])));
  }
  const Extent3 n = info.geometry.dims;
  for (std::int64_t z = 0; z < n.z; ++z) {
    const std::vector<double> slice = readBox(source, {{0, 0, z}, {n.x, n.y, z + 1}});
    for (std::int64_t i = z % step; i < n.x * n.y; i += step) {
      const double expected = direct.value({box.lo.x + i % n.x, box.lo.y + i / n.x, box.lo.z + z});
      ASSERT_EQ(slice[static_cast<std::size_t>(i)], expected) << i << " of slice " << z;
    }
  }
}

class Vdb : public ::testing::Test {
 protected:
  fs::path write(const std::vector<test::VdbSpec>& specs, bool seekable = true) {
    test::writeVdb(directory_ / "a.vdb", specs, seekable);
    return directory_ / "a.vdb";
  }
  void expectRefused(const fs::path& path, ErrorCode code, const std::string& says, const SourceOptions& options = {}) {
    try {
      openVdb(path, options);
      ADD_FAILURE() << "was opened, should say " << says;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
    }
  }
  // Returns the error of a hostile file, or reads a volume of moderate size.
  std::string openAndRead(const test::Bytes& file) {
    test::writeBytes(directory_ / "hostile.vdb", file);
    try {
      const auto source = openVdb(directory_ / "hostile.vdb", {});
      const Extent3 dims = source->info().geometry.dims;
      if (dims.x < 100 && dims.y < 100 && dims.z < 100) readBox(*source, boxOf(dims));
      return {};
    } catch (const Error& error) {
      return error.what();
    }
  }
  test::ScratchDirectory directory_;
};

TEST_F(Vdb, ScalarGridsGiveTheirValuesInactiveOnesToo) {
  const std::pair<VdbKind, VoxelType> kinds[] = {{VdbKind::kFloat, VoxelType::f32},
                                                 {VdbKind::kHalf, VoxelType::f32},
                                                 {VdbKind::kDouble, VoxelType::f64},
                                                 {VdbKind::kInt32, VoxelType::i32},
                                                 {VdbKind::kInt64, VoxelType::i32}};
  for (const auto& [kind, type] : kinds) {
    for (const bool seekable : {true, false}) {
      const auto source = openVdb(write({{kind, "smoke"}}, seekable), {});
      EXPECT_EQ(source->info().type, type);
      EXPECT_EQ(source->info().vdb->grid_name, "smoke");
      EXPECT_EQ(source->info().vdb->index_origin, test::kVdbOrigin);
      ASSERT_EQ(source->info().geometry.dims, test::kVdbDims);
      EXPECT_EQ(source->info().background, test::kVdbBackground);
      const std::vector<double> values = readBox(*source, boxOf(test::kVdbDims));
      for (std::int64_t i = 0; i < test::kVdbDims.count(); ++i) {
        const VoxelCoord v = {i % 13 + test::kVdbOrigin.x, i / 13 % 9 + test::kVdbOrigin.y,
                              i / 117 + test::kVdbOrigin.z};
        ASSERT_EQ(values[static_cast<std::size_t>(i)], test::vdbValue(v));
      }
    }
  }
}

// OpenVDB's own writer omits the sizes of leaves without Blosc or zip compression.
TEST_F(Vdb, Compression_noneOrActiveValuesOrZip_readsEveryVoxel) {
  using test::VdbCompression;
  for (const VdbCompression compression :
       {VdbCompression::kZip, VdbCompression::kActiveValues, VdbCompression::kNone}) {
    for (const VdbKind kind : {VdbKind::kFloat, VdbKind::kHalf, VdbKind::kInt32, VdbKind::kTiles, VdbKind::kLevelSet}) {
      for (const bool seekable : {true, false}) {
        test::writeVdb(directory_ / "a.vdb", {{kind, "a"}}, seekable, compression);
        const auto source = openVdb(directory_ / "a.vdb", {});
        if (seekable) {
          const test::DirectGrid direct(directory_ / "a.vdb", "a");
          ASSERT_EQ(source->info().geometry.dims, direct.activeBox().extent());
          const VoxelCoord at = source->info().vdb->index_origin;
          const std::vector<double> values = readBox(*source, boxOf(source->info().geometry.dims));
          const Extent3 n = source->info().geometry.dims;
          for (std::int64_t i = 0; i < n.count(); i += 3)
            ASSERT_EQ(values[static_cast<std::size_t>(i)],
                      direct.value({at.x + i % n.x, at.y + i / n.x % n.y, at.z + i / n.x / n.y}));
        }
      }
    }
  }
}

TEST_F(Vdb, Int64Grid_valuesOf32Bits_areReadAsU32) {
  const auto source = openVdb(write({{VdbKind::kUnsigned, "a"}}), {});
  EXPECT_EQ(source->info().type, VoxelType::u32);
  EXPECT_EQ(readBox(*source, boxOf({2, 1, 1})), (std::vector<double>{4294967295, 7}));
  // A grid of identifiers beside the volume is not chosen.
  EXPECT_EQ(openVdb(write({{VdbKind::kInt64, "id"}, {VdbKind::kFloat, "heat"}}), {})->info().vdb->grid_name, "heat");
}

// The last 4096 voxels at either end of the 32-bit coordinates cannot be iterated; all others are read.
TEST_F(Vdb, IndicesNearTheEndOf32Bits_areReadOrRefused) {
  constexpr std::int64_t kEnd = std::int64_t{1} << 31;
  for (const std::int64_t x : {-kEnd + 4096, kEnd - 4096 - 6, std::int64_t{1} << 30, -(std::int64_t{1} << 30) - 3}) {
    test::VdbSpec spec{VdbKind::kFar, "a"};
    spec.at = {x, x / 2, 0};
    const auto source = openVdb(write({spec}), {});
    ASSERT_EQ(source->info().geometry.dims, (Extent3{6, 6, 6})) << x;
    const std::vector<double> values = readBox(*source, boxOf({6, 6, 6}));
    EXPECT_EQ(values.front(), 1);
    EXPECT_EQ(values.back(), 2);
    EXPECT_EQ(std::count(values.begin(), values.end(), 0.0), 214);
  }
  for (const std::int64_t x : {-kEnd, -kEnd + 4095, kEnd - 4096 - 5, kEnd - 6}) {
    test::VdbSpec spec{VdbKind::kFar, "a"};
    spec.at = {0, x, 0};
    expectRefused(write({spec}), ErrorCode::kUnsupported, "-2147479552 to 2147479551 are read");
  }
}

// The values come from earlyVdb, written from OpenVDB's description of its older formats.
TEST_F(Vdb, FileOfBeforeOpenVdb2_readsItsLeaf) {
  test::writeBytes(directory_ / "a.vdb", test::earlyVdb());
  const auto source = openVdb(directory_ / "a.vdb", {});
  ASSERT_EQ(source->info().geometry.dims, (Extent3{8, 8, 8}));
  const std::vector<double> values = readBox(*source, boxOf({8, 8, 8}));
  for (std::size_t i = 0; i < values.size(); ++i) ASSERT_EQ(values[i], static_cast<double>(i));
  test::Bytes older = test::earlyVdb();
  older[8] = 217;
  test::writeBytes(directory_ / "a.vdb", older);
  expectRefused(directory_ / "a.vdb", ErrorCode::kUnsupported, "version 217");
}

// Every four bytes of the header are set to a length of some GiB, in all file formats: an error, or an equal volume, in
// little memory. OpenVDB would clear as many bytes as the length claims.
TEST_F(Vdb, HostileLengths_takeLittleMemory) {
  using test::VdbCompression;
  std::vector<test::Bytes> files = {test::earlyVdb()};
  for (const VdbCompression compression : {VdbCompression::kBlosc, VdbCompression::kNone}) {
    for (const bool seekable : {true, false}) {
      test::writeVdb(directory_ / "a.vdb", {{VdbKind::kFloat, "a"}, {VdbKind::kFrustum, "b"}}, seekable, compression);
      const std::vector<std::byte> whole = readFile(directory_ / "a.vdb");
      const auto* const first = reinterpret_cast<const std::uint8_t*>(whole.data());
      files.emplace_back(first, first + whole.size());
    }
  }
  const std::uint64_t before = peakResidentBytes();
  for (const test::Bytes& whole : files) {
    constexpr std::size_t kHead = 760;
    for (std::size_t at = 8; at + 4 <= std::min(whole.size(), kHead); at += test::casesOf(7u, 31u)) {
      test::Bytes file = whole;
      const std::uint32_t length = at % 2 == 0 ? 0xfffffff0 : 0x70000000;
      std::memcpy(&file[at], &length, sizeof length);
      test::writeBytes(directory_ / "hostile.vdb", file);
      try {
        openVdb(directory_ / "hostile.vdb", {});
      } catch (const Error&) {
      }
    }
  }
  if (!test::kSanitized) {
    EXPECT_LT(peakResidentBytes() - before, 256u << 20);
  }
}

// A file of a pipe is read whole. The memory of points is not known before, and a mask has a known length.
TEST_F(Vdb, PipedGridBesideOthers_ofUnknownMemory_isRefused) {
  for (const VdbKind kind : {VdbKind::kPointIndex, VdbKind::kPointData}) {
    expectRefused(write({{kind, "a"}, {VdbKind::kFloat, "b"}}, false), ErrorCode::kUnsupported,
                  "needs memory of unknown amount");
    EXPECT_EQ(openVdb(write({{kind, "a"}, {VdbKind::kFloat, "b"}}), {})->info().vdb->grid_name, "b");
  }
  for (const VdbKind kind : {VdbKind::kMask, VdbKind::kBool, VdbKind::kVec3})
    EXPECT_EQ(openVdb(write({{kind, "a"}, {VdbKind::kFloat, "b"}}, false), {})->info().vdb->grid_name, "b");
}

TEST_F(Vdb, TilesAndLevelSetsAreAsOpenVdbReadsThem) {
  for (const VdbKind kind : {VdbKind::kTiles, VdbKind::kLevelSet}) {
    const fs::path path = write({{kind, "a"}});
    expectSame(*openVdb(path, {}), test::DirectGrid(path, "a"));
  }
}

// A sheared, turned, mirrored affine: point by point the transform is OpenVDB's, so row and column are not swapped.
TEST_F(Vdb, TransformTakesPointsWhereOpenVdbTakesThem) {
  glm::dmat4 m = glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(100, -20, 3)), 0.7, glm::dvec3(1, 2, 3));
  m = m * glm::dmat4(-2, 0, 0, 0, 0.5, 3, 0, 0, 0.25, -0.125, 5, 0, 0, 0, 0, 1);
  const fs::path path = write({{VdbKind::kFloat, "density", m}});
  const auto source = openVdb(path, {});
  EXPECT_EQ(source->info().vdb->world_from_grid, m);
  expectSame(*source, test::DirectGrid(path, "density"));
}

TEST_F(Vdb, BoxesInAnyOrderFromAnyThread) {
  const auto source = openVdb(write({{VdbKind::kInt32, "a"}}), {});
  ASSERT_EQ(source->order(), ReadOrder::kAnyBox);
  const auto work = [&](unsigned seed) {
    std::mt19937 random(seed);
    for (int n = 0; n < 200; ++n) {
      VoxelBox box;
      for (int a = 0; a < 3; ++a) {
        box.lo[a] = random() % static_cast<unsigned>(test::kVdbDims[a]);
        box.hi[a] = box.lo[a] + 1 + random() % static_cast<unsigned>(test::kVdbDims[a] - box.lo[a]);
      }
      const std::vector<double> values = readBox(*source, box);
      const Extent3 e = box.extent();
      for (std::int64_t i = 0; i < e.count(); ++i) {
        const VoxelCoord v = {box.lo.x + i % e.x + test::kVdbOrigin.x, box.lo.y + i / e.x % e.y + test::kVdbOrigin.y,
                              box.lo.z + i / e.x / e.y + test::kVdbOrigin.z};
        ASSERT_EQ(values[static_cast<std::size_t>(i)], test::vdbValue(v)) << "seed " << seed;
      }
    }
  };
  std::thread other(work, 1);
  work(2);
  other.join();
}

TEST_F(Vdb, TheGridIsTheOnlyScalarOneOrDensityOrTheNamed) {
  EXPECT_EQ(openVdb(write({{VdbKind::kVec3, "v"}, {VdbKind::kDouble, "heat"}}), {})->info().vdb->grid_name, "heat");
  const fs::path two = write({{VdbKind::kFloat, "heat"}, {VdbKind::kInt32, "density"}, {VdbKind::kFloat, "apron"}});
  EXPECT_EQ(openVdb(two, {})->info().type, VoxelType::i32);
  EXPECT_EQ(openVdb(two, {})->info().notes,
            std::vector<std::string>{"grid 'density' is read, and not 'heat' (Tree_float_5_4_3), 'apron' "
                                     "(Tree_float_5_4_3); --grid NAME chooses"});
  SourceOptions options;
  options.grid_name = "heat";
  EXPECT_EQ(openVdb(two, options)->info().type, VoxelType::f32);
  EXPECT_TRUE(openVdb(two, options)->info().notes.empty());
  options.grid_name = "cold";
  expectRefused(two, ErrorCode::kUsage, "'heat' (Tree_float_5_4_3)", options);
  expectRefused(write({{VdbKind::kFloat, "heat"}, {VdbKind::kFloat, "fuel"}}), ErrorCode::kUsage,
                "'fuel' (Tree_float_5_4_3)");
  expectRefused(write({{VdbKind::kFloat, "density"}, {VdbKind::kInt32, "density"}}), ErrorCode::kUsage, "'density[1]'");
  options.grid_name = "density[1]";
  EXPECT_EQ(openVdb(directory_ / "a.vdb", options)->info().type, VoxelType::i32);
}

TEST_F(Vdb, RefusesByName) {
  const std::pair<VdbKind, const char*> kinds[] = {
      {VdbKind::kVec3, "vectors"},      {VdbKind::kBool, "mask"},
      {VdbKind::kMask, "mask"},         {VdbKind::kWide, "from -1 to 4294967295"},
      {VdbKind::kPointIndex, "points"}, {VdbKind::kPointData, "points"},
      {VdbKind::kFrustum, "frustum"}};
  for (const auto& [kind, says] : kinds) expectRefused(write({{kind, "a"}}), ErrorCode::kUnsupported, says);
  expectRefused(write({{VdbKind::kEmpty, "a"}}), ErrorCode::kFormat, "no active voxel");
  SourceOptions options;
  options.spacing = glm::dvec3(1);
  expectRefused(write({{VdbKind::kFloat, "a"}}), ErrorCode::kUsage, "--spacing", options);
  test::writeBytes(directory_ / "b.vdb", test::Bytes(100, 'x'));
  expectRefused(directory_ / "b.vdb", ErrorCode::kFormat, "b.vdb");
}

// A cut inside the grid's data, or in the directory before, must be detected when the file is opened, which reads all
// bytes.
TEST_F(Vdb, EveryTruncationIsAnError) {
  using test::VdbCompression;
  for (const auto& [seekable, compression] : {std::pair{true, VdbCompression::kBlosc},
                                              {false, VdbCompression::kBlosc},
                                              {true, VdbCompression::kNone},
                                              {false, VdbCompression::kActiveValues}}) {
    test::writeVdb(directory_ / "a.vdb", {{VdbKind::kFloat, "a"}}, seekable, compression);
    const std::vector<std::byte> whole = readFile(directory_ / "a.vdb");
    for (std::size_t n = 0; n < whole.size(); n += n < 1200 ? 1 : whole.size() / 400 + 1) {
      const auto* data = reinterpret_cast<const std::uint8_t*>(whole.data());
      test::writeBytes(directory_ / "cut.vdb", test::Bytes(data, data + n));
      EXPECT_THROW(openVdb(directory_ / "cut.vdb", {}), Error) << n;
    }
  }
}

// Names, metadata and the directory of grids, which are checked before OpenVDB reads them.
TEST_F(Vdb, FlippedLengthsInTheMetadataAreErrorsOrHarmless) {
  const std::vector<std::byte> whole = readFile(write({{VdbKind::kFloat, "a"}}));
  constexpr unsigned kFlips[] = {1, 0x80, 0xff};
  const std::size_t flips = std::size(kFlips) * std::min<std::size_t>(whole.size(), 480);
  for (std::size_t flip = 0; flip < flips; flip += test::casesOf(1u, 4u)) {
    test::Bytes file(reinterpret_cast<const std::uint8_t*>(whole.data()),
                     reinterpret_cast<const std::uint8_t*>(whole.data()) + whole.size());
    std::uint8_t& byte = file[flip / std::size(kFlips)];
    byte = static_cast<std::uint8_t>(byte ^ kFlips[flip % std::size(kFlips)]);
    test::writeBytes(directory_ / "flip.vdb", file);
    try {
      openVdb(directory_ / "flip.vdb", {});
    } catch (const Error&) {
    }
  }
}

// Known: every length is checked, in the tree, too, and Kiln unpacks the values. A flipped value is another value.
TEST_F(Vdb, FlippedBits_neverCrash) {
  using test::VdbCompression;
  std::mt19937 random(11);
  for (const VdbCompression compression : {VdbCompression::kNone, VdbCompression::kBlosc, VdbCompression::kZip}) {
    for (const VdbKind kind : {VdbKind::kHalf, VdbKind::kTiles, VdbKind::kLevelSet}) {
      test::writeVdb(directory_ / "a.vdb", {{kind, "a"}}, true, compression);
      const std::vector<std::byte> whole = readFile(directory_ / "a.vdb");
      const auto* const first = reinterpret_cast<const std::uint8_t*>(whole.data());
      for (int i = 0; i < test::casesOf(200, 30); ++i) {
        test::Bytes file(first, first + whole.size());
        for (int flips = 0; flips < 3; ++flips)
          file[random() % file.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
        openAndRead(file);
      }
    }
  }
}

// OpenVDB reads values of a negative length by that length, into room for the values alone. Each number that may be a
// length of a leaf's values becomes such a length, longer than the values of any leaf.
TEST_F(Vdb, KeptValuesLongerThanTheirLeaf_areRefused) {
  constexpr std::int64_t kMostLength = 1024, kLonger = -1100;
  const std::vector<std::byte> whole = readFile(write({{VdbKind::kHalf, "a"}}));
  const auto* const first = reinterpret_cast<const std::uint8_t*>(whole.data());
  int refused = 0;
  for (std::size_t at = 0; at + 8 <= whole.size(); ++at) {
    std::int64_t length;
    std::memcpy(&length, first + at, sizeof length);
    if (length == 0 || std::abs(length) > kMostLength) continue;
    test::Bytes file(first, first + whole.size());
    std::memcpy(&file[at], &kLonger, sizeof kLonger);
    file.resize(file.size() + 2000);
    refused += openAndRead(file).find("have a stored length of -1100") != std::string::npos;
  }
  EXPECT_GE(refused, 8) << "leaves of the grid";
}

// Halves and floats differ in the room for values, so both statements of a file must agree.
TEST_F(Vdb, MetadataAgainstTheNameAboutHalves_areRefused) {
  constexpr std::string_view kName = "is_saved_as_half_float";
  const fs::path path = write({{VdbKind::kHalf, "a"}});
  std::string text = readTextFile(path);
  const std::size_t at = text.find(kName);
  ASSERT_NE(at, std::string::npos);
  // The name, then the length and the text of the type "bool", the value's length, the value.
  const std::size_t value = at + kName.size() + 4 + 4 + 4;
  ASSERT_EQ(text[value], 1);
  text[value] = 0;
  test::writeBytes(path, test::Bytes(text.begin(), text.end()));
  expectRefused(path, ErrorCode::kUnsupported, "differ about half precision");
}

// Known: the first leaf with compressed values gets a damaged frame.
TEST_F(Vdb, DamagedPackedValues_nameTheirPlace) {
  test::VdbSpec spec{VdbKind::kTiles, "a"};
  test::writeVdb(directory_ / "a.vdb", {spec}, true, test::VdbCompression::kZip);
  std::string text = readTextFile(directory_ / "a.vdb");
  // A zlib stream of OpenVDB's level begins so.
  const std::size_t stream = text.find("\x78\x9c", 400);
  ASSERT_NE(stream, std::string::npos);
  text[stream] = 'x' ^ 1;
  test::writeBytes(directory_ / "a.vdb", test::Bytes(text.begin(), text.end()));
  expectRefused(directory_ / "a.vdb", ErrorCode::kFormat, "the zlib stream is damaged");
}

#ifdef KILN_TEST_DATA_DIR
class RealVdb : public ::testing::TestWithParam<const char*> {};

TEST_P(RealVdb, IsAsOpenVdbReadsIt) {
  const fs::path path = fs::path(KILN_TEST_DATA_DIR) / "vdb" / GetParam();
  if (!fs::exists(path)) GTEST_SKIP() << path << " is not here; see shared/data/README.md";
  const auto source = openVdb(path, {});
  expectSame(*source, test::DirectGrid(path, source->info().vdb->grid_name), 13);
  if (std::string(GetParam()) == "smoke.vdb") {
    EXPECT_EQ(source->info().geometry.dims, (Extent3{111, 222, 112}));
  }
}
INSTANTIATE_TEST_SUITE_P(Files, RealVdb,
                         ::testing::Values("smoke.vdb", "sphere.vdb", "dragon_with_xform.vdb",
                                           "wdas_cloud_sixteenth.vdb"));

TEST_F(Vdb, RealPointsAreRefused) {
  const fs::path path = fs::path(KILN_TEST_DATA_DIR) / "vdb" / "points.vdb";
  if (!fs::exists(path)) GTEST_SKIP() << path << " is not here; see shared/data/README.md";
  expectRefused(path, ErrorCode::kUnsupported, "points");
}
#endif

}  // namespace
}  // namespace kiln
