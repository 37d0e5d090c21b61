// phantom:NAME:XxYxZ as a source. Known because a voxel is a function of name, size and coordinates: for every box
// read, its bits equal the whole volume's.
#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {

ForeignVolume wholeOf(const std::string& name) {
  const auto source = openSource(name);
  return {source->info().geometry.dims, source->info().type, readWhole(*source)};
}

TEST(IngestPhantom, EveryBoxHasTheBitsOfTheWhole) {
  for (const char* name :
       {"phantom:body:37x23x61", "phantom:head:45x44x31", "phantom:brain:21x33x17", "phantom:engine:50x41x29"}) {
    SCOPED_TRACE(name);
    EXPECT_EQ(openSource(name)->order(), ReadOrder::kAnyBox);
    expectReadsBack(
        wholeOf(name), [&] { return openSource(name); }, 5);
  }
}

TEST(IngestPhantom, SeveralThreadsReadAtOnce) {
  const ForeignVolume volume = wholeOf("phantom:head:40x40x36");
  const auto source = openSource("phantom:head:40x40x36");
  std::vector<int> wrong(4, 0);
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < wrong.size(); ++t) {
      threads.emplace_back([&, t] {
        for (std::int64_t z = 0; z + 5 <= 36; z += 3) {
          const VoxelBox box = {{static_cast<std::int64_t>(t), 2, z}, {33, 39, z + 5}};
          std::vector<std::byte> out(static_cast<std::size_t>(box.count()) * 2);
          source->read(box, out);
          if (out != volume.box(box)) ++wrong[t];
        }
      });
    }
  }
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST(IngestPhantom, SaysWhatItIs) {
  // Known: the body's box is 587 x 341 x 1878 mm, and its voxels divide the box.
  const auto source = openSource("phantom:body:587x341x939");
  const SourceInfo& info = source->info();
  EXPECT_EQ(info.type, VoxelType::u16);
  EXPECT_EQ(info.geometry.dims, (Extent3{587, 341, 939}));
  EXPECT_EQ(info.geometry.spacing(), glm::dvec3(1, 1, 2));
  EXPECT_EQ(info.geometry.unit, "mm");
  EXPECT_EQ(info.geometry.frame, PatientFrame::kLps);
  EXPECT_EQ(info.geometry.worldOf({-0.5, -0.5, -0.5}), glm::dvec3(-293.5, -170.5, 0));
  ASSERT_EQ(info.files.size(), 1u);
  EXPECT_EQ(info.files[0], "phantom:body:587x341x939");
  EXPECT_EQ(openSource("phantom:engine:16x16x8")->info().type, VoxelType::u8);
}

TEST(IngestPhantom, SpacingIsReplacedAndVoxelsStay) {
  SourceOptions options;
  options.spacing = glm::dvec3(2, 3, 4);
  const auto source = openSource("phantom:head:20x20x20", options);
  EXPECT_EQ(source->info().geometry.spacing(), glm::dvec3(2, 3, 4));
  EXPECT_TRUE(readWhole(*source) == wholeOf("phantom:head:20x20x20").voxels);
}

TEST(IngestPhantom, WrongUsesAreUsageErrors) {
  // Known: the contract of openSource; the message lists the phantoms.
  expectRefused("phantom:cat:8x8x8", ErrorCode::kUsage, "body, head, brain, engine");
  expectRefused("phantom:", ErrorCode::kUsage, "body, head, brain, engine");
  for (const char* size : {"", ":", ":8x8", ":8x8x", ":8x8x8x8", ":0x8x8", ":8x-8x8", ":8x8x8 ", ":8,8,8", ":axbxc",
                           ":99999999999999999999x1x1"}) {
    expectRefused(std::string("phantom:body") + size, ErrorCode::kUsage, "as in phantom:body:587x341x1878");
  }
  expectRefused("phantom:body:2147483648x1x1", ErrorCode::kUsage, "2147483647");
  expectRefused("phantom:body:2147483647x2147483647x2147483647", ErrorCode::kUsage, "2^63");
  SourceOptions options;
  options.dims = Extent3{8, 8, 8};
  expectRefused("phantom:body:8x8x8", ErrorCode::kUsage, "--dims", options);
  options = {};
  options.grid_name = "density";
  expectRefused("phantom:body:8x8x8", ErrorCode::kUsage, "--grid", options);
  options = {};
  options.skip_bytes = 4;
  expectRefused("phantom:body:8x8x8", ErrorCode::kUsage, "--skip", options);
  options = {};
  options.spacing = glm::dvec3(1, 0, 1);
  expectRefused("phantom:body:8x8x8", ErrorCode::kUsage, "--spacing", options);
}

}  // namespace
}  // namespace kiln::test
