// MGH and MGZ. Known because the test puts each number of the header at its documented offset.
#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"
#include "support/files/header_writer.h"
#include "support/files/mrc_mgh_files.h"

namespace kiln::test {
namespace {

// Four parameters of the scan, as FreeSurfer writes them behind the voxels.
const std::string kParameters(16, 'p');

TEST(IngestMgh, EveryTypeAndContainerReadsBack) {
  const ForeignFiles files;
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::i16, VoxelType::i32, VoxelType::f32}) {
    SCOPED_TRACE(nameOf(type));
    const ForeignVolume volume = randomVolume({13, 9, 7}, type, 341);
    const std::string whole = mghFile(volume) + kParameters;
    for (const auto& path : {files.write("a.mgh", whole), files.write("b.mgz", gzipped(whole)),
                             files.write("c.mgh.gz", gzipped(mghFile(volume)))}) {
      expectReadsBack(volume, path, 342);
      const auto source = openSource(path);
      readWhole(*source);
      EXPECT_TRUE(source->info().notes.empty()) << source->info().notes[0];
    }
  }
}

// Known: voxel dims / 2 lies at the centre.
TEST(IngestMgh, DirectionsAndCentreAreTheAffine) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({4, 6, 8}, VoxelType::u8, 351);
  const auto path = files.write("a.mgh", mghFile(volume));
  const VolumeGeometry g = openSource(path)->info().geometry;
  EXPECT_EQ(g.worldOf({2, 3, 4}), glm::dvec3(10, 20, 30));
  EXPECT_EQ(g.worldOf({3, 4, 5}), glm::dvec3(10 - 4, 20 + 2, 30 + 3));
  EXPECT_EQ(g.frame, PatientFrame::kRas);
  EXPECT_EQ(g.unit, "mm");
  SourceOptions options;
  options.spacing = glm::dvec3(1);
  expectRefused(path, ErrorCode::kUsage, "--spacing", options);
  const auto unplaced = openSource(files.write(
      "b.mgh", mghFile(volume, 1, [](std::string& header) { putNumber(header, 28, std::int16_t{0}, true); })));
  EXPECT_EQ(unplaced->info().geometry.worldOf({2, 3, 4}), glm::dvec3(0));
  EXPECT_EQ(unplaced->info().geometry.worldOf({3, 4, 5}), glm::dvec3(-1, 1, -1));
  ASSERT_EQ(unplaced->info().notes.size(), 1u);
}

TEST(IngestMgh, FramesAreTimes) {
  const ForeignFiles files;
  const ForeignVolume both = randomVolume({5, 4, 6}, VoxelType::i16, 361);
  const auto path = files.write("a.mgz", gzipped(mghFile(both, 2)));
  expectRefused(path, ErrorCode::kUsage, "holds 2 times; choose one with --time");
  SourceOptions options;
  options.time = 1;
  expectReadsBack(
      both.slices({3, 4, 5}), [&] { return openSource(path, options); }, 362);
}

TEST(IngestMgh, WrongHeadersAreRefused) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 371);
  const auto refused = [&](std::size_t at, std::int32_t value, ErrorCode code, const std::string& part) {
    expectRefused(files.write("a.mgh", mghFile(volume, 1, [&](std::string& h) { putNumber(h, at, value, true); })),
                  code, part);
  };
  refused(0, 2, ErrorCode::kFormat, "byte 0: the version is 2");
  refused(4, 0, ErrorCode::kFormat, "byte 4: 0 voxels");
  refused(16, -1, ErrorCode::kFormat, "byte 16: -1");
  refused(16, 2147483647, ErrorCode::kUsage, "2147483647 times");
  refused(12, 2147483647, ErrorCode::kFormat, "dimensions need");
  refused(20, 11, ErrorCode::kFormat, "type 11");
  refused(20, 2, ErrorCode::kUnsupported, "long integers");
  refused(20, 6, ErrorCode::kUnsupported, "tensors");
  refused(20, 7, ErrorCode::kUnsupported, "complex");
  refused(20, 9, ErrorCode::kUnsupported, "RGB");
}

// The voxels end with the raw file: the parameters behind them are optional.
TEST(IngestMgh, EveryCutIsNoticedAndFlipsAreHarmless) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::f32, 381);
  const std::string whole = mghFile(volume), packed = gzipped(whole + kParameters);
  expectNoCutGoesUnnoticed(volume, files, "a.mgh", whole, files.directory() / "a.mgh");
  expectNoCutGoesUnnoticed(volume, files, "a.mgz", packed, files.directory() / "a.mgz");
  expectBitFlipsAreHarmless(files, "a.mgh", whole, 284, files.directory() / "a.mgh", 382);
}

}  // namespace
}  // namespace kiln::test
