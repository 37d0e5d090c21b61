// Every real volume is converted, verified and exported. The exported file is read by the same reader as the source and
// compared with the source, voxel by voxel and matrix by matrix. The answer is the input itself.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "convert/convert.h"
#include "export/vdb/export_vdb.h"
#include "ingest/open_source.h"
#include "store/codec/brick_block.h"
#include "store/store_reader.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

struct RealVolume {
  const char* file;
  Extent3 dims;          // {0,0,0}: the extents in the file are used
  VoxelType raw_type{};  // for headerless raw
  bool raw = false;
};

const RealVolume kVolumes[] = {
    {"cthead_256x256x113_u16le.nrrd", {256, 256, 113}},
    {"mrbrain_256x256x109_u16le.nrrd", {256, 256, 109}},
    {"vhm_head_512x512x245_i16le.nrrd", {512, 512, 245}},
    {"raw/brainsmall_128x128x84_u8.nhdr", {128, 128, 84}},
    {"raw/brainsmall_128x128x84_u8.mhd", {128, 128, 84}},
    {"raw/engine.raw", {149, 208, 110}, VoxelType::u8, true},
    {"tiff/cthead", {256, 256, 99}},
    {"dicom", {512, 512, 40}},
    {"nifti/ch2.nii.gz", {181, 217, 181}},
    {"nifti/CT_AVM.nii.gz", {}},
    {"nifti/eun_brain_uchar_8.nii.gz", {}},
    {"fetal_template_T2.nrrd", {117, 159, 126}},
    {"vdb/smoke.vdb", {}},
    {"vdb/sphere.vdb", {}},
    {"vdb/dragon_with_xform.vdb", {}},
    {"vdb/wdas_cloud_sixteenth.vdb", {}},
};

// Reads the whole source slice by slice, as streams require.
std::vector<double> allVoxels(VolumeSource& source) {
  const Extent3& dims = source.info().geometry.dims;
  const std::size_t slice = static_cast<std::size_t>(dims.x * dims.y);
  std::vector<std::byte> bytes(slice * sizeOf(source.info().type));
  std::vector<double> out;
  out.reserve(slice * static_cast<std::size_t>(dims.z));
  for (std::int64_t z = 0; z < dims.z; ++z) {
    source.read({{0, 0, z}, {dims.x, dims.y, z + 1}}, bytes);
    withVoxelType(source.info().type, [&]<class T>(std::type_identity<T>) {
      const T* const values = reinterpret_cast<const T*>(bytes.data());
      out.insert(out.end(), values, values + slice);
    });
  }
  source.finish();
  return out;
}

// Compares bits, so that NaN equals NaN and -0 differs from 0.
bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

class RealData : public ::testing::TestWithParam<RealVolume> {};

TEST_P(RealData, ComesBackAsItWas) {
  const RealVolume& volume = GetParam();
  const fs::path input = fs::path(KILN_TEST_DATA_DIR) / volume.file;
  if (!fs::exists(input)) GTEST_SKIP() << input << " is not here; the round trips of real volumes are not tested";
  SourceOptions options;
  if (volume.raw) {
    options.dims = volume.dims;
    options.type = volume.raw_type;
  }
  const fs::path directory = freshDirectory("real_" + fs::path(volume.file).filename().string());
  Progress silent;
  const auto source = openSource(input, options);
  const SourceInfo info = source->info();
  if (volume.dims.x > 0) {
    EXPECT_EQ(info.geometry.dims, volume.dims);
  }
  convert(*source, directory / "store.kiln", {}, silent);
  const StoreReader store(directory / "store.kiln");
  EXPECT_GT(wholeFiles(store.path()), 2u);
  EXPECT_EQ(store.manifest().geometry().world_from_index, info.geometry.world_from_index);
  exportVdb(store, exportedVolume(store, 0, {}), {.out = directory / "export.vdb"}, silent);

  const std::vector<double> expected = allVoxels(*openSource(input, options));
  const auto exported = openSource(directory / "export.vdb");
  const SourceInfo& back = exported->info();
  ASSERT_TRUE(back.vdb);
  const VoxelCoord origin = info.vdb ? info.vdb->index_origin : VoxelCoord{};
  EXPECT_EQ(back.vdb->world_from_grid, info.vdb ? info.vdb->world_from_grid : info.geometry.world_from_index);
  const std::vector<double> found = allVoxels(*exported);
  // The exported grid ends with its active voxels; all voxels beyond must be background.
  const Extent3& dims = info.geometry.dims;
  const Extent3& inner = back.geometry.dims;
  const VoxelBox box = boxOf(inner);
  std::size_t i = 0, wrong = 0;
  for (std::int64_t z = 0; z < dims.z; ++z) {
    for (std::int64_t y = 0; y < dims.y; ++y) {
      for (std::int64_t x = 0; x < dims.x; ++x, ++i) {
        const VoxelCoord at = {x + origin.x - back.vdb->index_origin.x, y + origin.y - back.vdb->index_origin.y,
                               z + origin.z - back.vdb->index_origin.z};
        const double value = box.contains(at)
                                 ? found[static_cast<std::size_t>((at.z * inner.y + at.y) * inner.x + at.x)]
                                 : back.background;
        // A level set has two backgrounds, outside and inside, by sign.
        const bool beyond = !box.contains(at) && info.volume_class == VolumeClass::kLevelSet;
        wrong += same(value, expected[i]) || (beyond && std::abs(expected[i]) == back.background) ? 0 : 1;
      }
    }
  }
  EXPECT_EQ(wrong, 0u) << "of " << expected.size() << " voxels";
  fs::remove_all(directory);
}

INSTANTIATE_TEST_SUITE_P(Files, RealData, ::testing::ValuesIn(kVolumes), [](const auto& info) {
  std::string name;
  for (const char c : fs::path(info.param.file).filename().string())
    name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

TEST(RealData, PointsAreRefusedWithASentence) {
  const fs::path input = fs::path(KILN_TEST_DATA_DIR) / "vdb/points.vdb";
  if (!fs::exists(input)) GTEST_SKIP() << input << " is not here";
  try {
    openSource(input);
    FAIL() << "points were taken for a volume";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUnsupported);
    EXPECT_NE(std::string(error.what()).find("points.vdb"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("oint"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace kiln::test
