// MRC, CCP4 and MAP. Known because the test puts each number of the header at its documented offset, and the voxels
// are known bytes. Geometry is the closed form of the cell.
#include <gtest/gtest.h>

#include <cmath>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"
#include "support/files/header_writer.h"
#include "support/files/mrc_mgh_files.h"

namespace kiln::test {
namespace {

class IngestMrc : public ::testing::Test {
 protected:
  VolumeGeometry geometry(const HeaderChange& change, const SourceOptions& options = {}) const {
    return open(change, options)->info().geometry;
  }
  std::unique_ptr<VolumeSource> open(const HeaderChange& change, const SourceOptions& options = {}) const {
    return openSource(files_.write("a.mrc", mrcFile(volume_, false, change)), options);
  }
  void refused(const HeaderChange& change, ErrorCode code, const std::string& part,
               const SourceOptions& options = {}) const {
    expectRefused(files_.write("a.mrc", mrcFile(volume_, false, change)), code, part, options);
  }
  ForeignFiles files_;
  ForeignVolume volume_ = randomVolume(kFewVoxels, VoxelType::i16, 301);
};

TEST_F(IngestMrc, EveryModeOrderAndContainerReadsBack) {
  for (const VoxelType type : {VoxelType::u8, VoxelType::i8, VoxelType::u16, VoxelType::i16, VoxelType::f32}) {
    for (const bool big : {false, true}) {
      SCOPED_TRACE(testing::Message() << nameOf(type) << " big " << big);
      const ForeignVolume volume = randomVolume({13, 9, 7}, type, 302);
      const std::string whole = mrcFile(volume, big);
      expectReadsBack(volume, files_.write("a.map", whole), 303);
      expectReadsBack(volume, files_.write("b.map.gz", gzipped(whole)), 304);
      // An extended header of 80 bytes.
      std::string extended = mrcFile(volume, big, [&](std::string& header) { putNumber(header, 92, 80, big); });
      expectReadsBack(volume, files_.write("c.rec", extended.insert(1024, 80, 'e')), 305);
    }
  }
}

// Known: the values of IEEE 754's binary16, by its definition.
TEST_F(IngestMrc, HalfFloatsBecomeTheirValues) {
  const std::pair<int, float> halves[] = {{0x0000, 0.f},
                                          {0x8000, -0.f},
                                          {0x3c00, 1.f},
                                          {0xc000, -2.f},
                                          {0x7bff, 65504.f},
                                          {0x0001, 0x1p-24f},
                                          {0x83ff, -1023 * 0x1p-24f},
                                          {0x0400, 0x1p-14f},
                                          {0x3555, 0x555p-12f},
                                          {0x7c00, INFINITY},
                                          {0xfc00, -INFINITY},
                                          {0x7e00, NAN}};
  for (const bool big : {false, true}) {
    std::string file = mrcHeader({12, 1, 1}, 12, big);
    for (const auto& [bits, value] : halves)
      file += big ? std::string{static_cast<char>(bits >> 8), static_cast<char>(bits)}
                  : std::string{static_cast<char>(bits), static_cast<char>(bits >> 8)};
    const auto source = openSource(files_.write("a.mrc", file));
    ASSERT_EQ(source->info().type, VoxelType::f32);
    const std::vector<std::byte> raw = readWhole(*source);
    for (std::size_t i = 0; i < std::size(halves); ++i) {
      float found;
      std::memcpy(&found, raw.data() + 4 * i, 4);
      if (std::isnan(halves[i].second))
        EXPECT_TRUE(std::isnan(found));
      else
        EXPECT_EQ(std::bit_cast<std::uint32_t>(found), std::bit_cast<std::uint32_t>(halves[i].second)) << i;
    }
  }
}

TEST_F(IngestMrc, CellOverSamplesIsTheSpacing) {
  const VolumeGeometry plain = geometry({});
  EXPECT_EQ(plain.worldOf({1, 1, 1}), glm::dvec3(1, 1.5, 4));
  EXPECT_EQ(plain.unit, "angstrom");
  // A map of a part of the cell: the samples count, not the extent.
  const auto finer = [](std::string& header) { putNumber(header, 28, 20); };
  EXPECT_EQ(geometry(finer).worldOf({1, 1, 1}), glm::dvec3(0.25, 1.5, 4));
  const auto unknown = [](std::string& header) { putNumber(header, 40, 0.f); };
  const auto source = open(unknown);
  EXPECT_EQ(source->info().geometry.worldOf({1, 1, 1}), glm::dvec3(1));
  EXPECT_EQ(source->info().geometry.unit, "");
  ASSERT_EQ(source->info().notes.size(), 1u);
  EXPECT_NE(source->info().notes[0].find("no size of a voxel"), std::string::npos);
  SourceOptions options;
  options.spacing = glm::dvec3(7, 8, 9);
  EXPECT_EQ(geometry(unknown, options).worldOf({1, 1, 1}), glm::dvec3(7, 8, 9));
}

// Known: columns, rows and sections step along the axes that the header names, and voxels stay in their order.
TEST_F(IngestMrc, OrderOfAxesTurnsTheAffine) {
  const auto turned = [](std::string& header) {
    putNumber(header, 64, 3), putNumber(header, 68, 1), putNumber(header, 72, 2);
    putNumber(header, 16, 10), putNumber(header, 20, -20), putNumber(header, 24, 30);
  };
  const VolumeGeometry g = geometry(turned);
  EXPECT_EQ(g.worldOf({1, 0, 0}) - g.worldOf({0, 0, 0}), glm::dvec3(0, 0, 4));
  EXPECT_EQ(g.worldOf({0, 1, 0}) - g.worldOf({0, 0, 0}), glm::dvec3(1, 0, 0));
  EXPECT_EQ(g.worldOf({0, 0, 1}) - g.worldOf({0, 0, 0}), glm::dvec3(0, 1.5, 0));
  EXPECT_EQ(g.worldOf({0, 0, 0}), glm::dvec3(-20, 45, 40));
  EXPECT_EQ(g.dims, volume_.dims);
  const auto zeros = [](std::string& header) { header.replace(64, 12, 12, '\0'); };
  EXPECT_EQ(geometry(zeros).worldOf({1, 1, 1}), glm::dvec3(1, 1.5, 4));
}

// Known: a monoclinic cell leans c by beta against a; a hexagonal cell has 120 degrees between a and b.
TEST_F(IngestMrc, AnglesOfTheCellLeanTheAxes) {
  const VolumeGeometry leaning = geometry([](std::string& header) { putNumber(header, 56, 60.f); });
  const glm::dvec3 z = leaning.worldOf({0, 0, 1}) - leaning.worldOf({0, 0, 0});
  EXPECT_NEAR(z.x, 2, 1e-12);
  EXPECT_NEAR(z.y, 0, 1e-12);
  EXPECT_NEAR(z.z, 4 * std::sqrt(0.75), 1e-12);
  const VolumeGeometry hexagonal = geometry([](std::string& header) { putNumber(header, 60, 120.f); });
  const glm::dvec3 y = hexagonal.worldOf({0, 1, 0});
  EXPECT_NEAR(y.x, -0.75, 1e-12);
  EXPECT_NEAR(y.y, 1.5 * std::sqrt(0.75), 1e-12);
  SourceOptions options;
  options.spacing = glm::dvec3(1);
  refused([](std::string& header) { putNumber(header, 60, 120.f); }, ErrorCode::kUsage, "--spacing", options);
}

TEST_F(IngestMrc, OriginComesBeforeTheStart) {
  const auto placed = [](std::string& header) {
    putNumber(header, 16, 2);
    putNumber(header, 196, -7.5f), putNumber(header, 204, 3.f);
  };
  const auto source = open(placed);
  EXPECT_EQ(source->info().geometry.worldOf({0, 0, 0}), glm::dvec3(-7.5, 0, 3));
  ASSERT_EQ(source->info().notes.size(), 1u);
  EXPECT_NE(source->info().notes[0].find("place it differently"), std::string::npos);
  // IMOD's older origins have the opposite sign.
  const auto imod = [&](std::string& header) {
    putNumber(header, 196, 5.f);
    putNumber(header, 152, 1146047817);
  };
  EXPECT_EQ(geometry(imod).worldOf({0, 0, 0}), glm::dvec3(-5, 0, 0));
  const auto newer = [&](std::string& header) { imod(header), putNumber(header, 156, 4); };
  EXPECT_EQ(geometry(newer).worldOf({0, 0, 0}), glm::dvec3(5, 0, 0));
}

// Known: the second of two volumes of 5 x 4 x 3 begins behind the first.
TEST_F(IngestMrc, StackOfVolumes_isOneOfThemByTime) {
  const ForeignVolume both = randomVolume({5, 4, 6}, VoxelType::i16, 311);
  const std::string whole = mrcFile(both, false, [](std::string& header) {
    putNumber(header, 88, 401), putNumber(header, 36, 3), putNumber(header, 48, 12.f);
  });
  for (const auto& path : {files_.write("s.mrc", whole), files_.write("s.mrc.gz", gzipped(whole))}) {
    expectRefused(path, ErrorCode::kUsage, "holds 2 times; choose one with --time, from 0 to 1");
    for (const std::int64_t time : {0, 1}) {
      SourceOptions options;
      options.time = time;
      expectReadsBack(
          both.part({{0, 0, 3 * time}, {5, 4, 3 * time + 3}}), [&] { return openSource(path, options); }, 312);
      const auto source = openSource(path, options);
      readWhole(*source);
      EXPECT_TRUE(source->info().notes.empty());
      EXPECT_EQ(source->info().format, "MRC, time " + std::to_string(time));
      EXPECT_EQ(source->info().geometry.worldOf({1, 1, 1}), glm::dvec3(1, 1.5, 4));
    }
    SourceOptions beyond;
    beyond.time = 2;
    expectRefused(path, ErrorCode::kUsage, "--time: expected a number from 0 to 1 (found 2)", beyond);
  }
  SourceOptions second;
  second.time = 1;
  const auto path = files_.directory() / "s.mrc";
  expectNoCutGoesUnnoticed(both.slices({3, 4, 5}), files_, "s.mrc", whole, path, second);
}

TEST_F(IngestMrc, OtherModesAreRefusedByName) {
  const auto mode = [](int number) { return [number](std::string& header) { putNumber(header, 12, number); }; };
  refused(mode(101), ErrorCode::kUnsupported, "4-bit integers (mode 101)");
  refused(mode(3), ErrorCode::kUnsupported, "complex numbers (mode 3)");
  refused(mode(4), ErrorCode::kUnsupported, "complex numbers (mode 4)");
  refused(mode(16), ErrorCode::kUnsupported, "RGB");
  refused(mode(5), ErrorCode::kFormat, "byte 12: mode 5");
  SourceOptions channel;
  channel.channel = "1";
  refused({}, ErrorCode::kUsage, "MRC files have no channels", channel);
}

TEST_F(IngestMrc, HostileNumbersAreFormatErrors) {
  const auto set = [](std::size_t at, auto value) {
    return [=](std::string& header) { putNumber(header, at, value); };
  };
  refused(set(4, 0), ErrorCode::kFormat, "byte 4: 0 voxels");
  refused(set(8, -3), ErrorCode::kFormat, "byte 8: -3 voxels");
  refused(set(0, 2147483647), ErrorCode::kFormat, "dimensions need");
  refused(set(64, 2), ErrorCode::kFormat, "byte 64: the order of axes is 2, 2, 3");
  refused(set(92, -1), ErrorCode::kFormat, "byte 92");
  refused(set(92, 2147483647), ErrorCode::kFormat, "should begin at byte 2147484671");
  refused(set(52, 180.f), ErrorCode::kFormat, "byte 52: an angle of the cell is 180");
  refused([](std::string& header) { putNumber(header, 52, 10.f), putNumber(header, 56, 170.f); }, ErrorCode::kFormat,
          "byte 52: the angles of the cell enclose no volume");
}

// A stamp that is missing or wrong: numbers that make sense in one order decide.
TEST_F(IngestMrc, WrongStamp_isMended) {
  for (const bool big : {false, true}) {
    for (const std::string& stamp : {std::string(2, '\0'), std::string("\x11\x11"), std::string("\x44\x41")}) {
      const auto path =
          files_.write("a.mrc", mrcFile(volume_, big, [&](std::string& header) { header.replace(212, 2, stamp); }));
      expectReadsBack(volume_, path, 321);
    }
  }
  // Files of before 2000 have no magic; the ending decides.
  const auto old = [](std::string& header) { header.replace(208, 8, 8, '\0'); };
  expectReadsBack(volume_, files_.write("old.ccp4", mrcFile(volume_, true, old)), 322);
  expectRefused(files_.write("old.dat", mrcFile(volume_, true, old)), ErrorCode::kUsage, "--dims");
}

TEST_F(IngestMrc, EveryCutIsNoticedAndFlipsAreHarmless) {
  for (const bool big : {false, true}) {
    const std::string whole = mrcFile(volume_, big);
    expectNoCutGoesUnnoticed(volume_, files_, "a.mrc", whole, files_.directory() / "a.mrc");
    expectBitFlipsAreHarmless(files_, "a.mrc", whole, 1024, files_.directory() / "a.mrc", 331);
  }
  const std::string packed = gzipped(mrcFile(volume_));
  expectNoCutGoesUnnoticed(volume_, files_, "a.map.gz", packed, files_.directory() / "a.map.gz");
}

}  // namespace
}  // namespace kiln::test
