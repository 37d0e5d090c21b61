// Interrupted conversions of a source that is read forwards, with its slices in memory and on disk. The disk fails at
// its n-th change for every n, the source fails, or the user stops. Known because a directory is a store if and only if
// it has a manifest, and because the next conversion must write the files of an undisturbed one.
#include <gtest/gtest.h>

#include <map>
#include <optional>

#include "base/thread/parallel.h"
#include "convert/plan.h"
#include "convert/stream/slice_ring.h"
#include "support/system/faulty_file_system.h"
#include "support/system/impatient_progress.h"
#include "support/volumes/forward_source.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

const DenseVolume& volume() {
  static const DenseVolume made = cheese({{33, 18, 25}, VoxelType::i16}, 1, usualRange(VoxelType::i16));
  return made;
}

ConvertOptions options(bool on_disk) {
  ConvertOptions out;
  out.brick_size = 16;
  out.overwrite = true;
  if (!on_disk) return out;
  // Memory for the lanes, the tables and a strip: no layer of slices fits.
  const ForwardSource source(volume());
  const ConversionPlan ample = planConversion(source, out);
  out.memory_bytes = ample.index_bytes + ample.lanes * ample.lane_bytes + stripBytes(source.info());
  EXPECT_TRUE(planConversion(source, out).window_on_disk);
  return out;
}

std::optional<ErrorCode> errorOf(VolumeSource& source, const fs::path& out, bool on_disk, Progress& progress,
                                 FileSystem& disk = FileSystem::real()) {
  try {
    ConvertOptions asked = options(on_disk);
    asked.disk = &disk;
    convert(source, out, asked, progress);
  } catch (const Error& error) {
    EXPECT_FALSE(error.code() != ErrorCode::kCancelled && error.path().empty()) << error.what();
    return error.code();
  }
  return std::nullopt;
}

std::map<std::string, std::vector<std::byte>> filesOf(const fs::path& directory) {
  std::map<std::string, std::vector<std::byte>> out;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file()) out[fs::relative(entry.path(), directory)] = readFile(entry.path());
  }
  return out;
}

const std::map<std::string, std::vector<std::byte>>& undisturbed() {
  static const auto files = [] {
    const fs::path out = freshDirectory("undisturbed") / "volume.kiln";
    DenseSource source(volume());
    Progress silent;
    EXPECT_FALSE(errorOf(source, out, false, silent));
    return filesOf(out);
  }();
  return files;
}

void expectNoStoreThenOne(const fs::path& directory, bool on_disk) {
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    EXPECT_NE(entry.path().filename(), "manifest.json");
    EXPECT_NE(entry.path().extension(), ".tmp");
  }
  ForwardSource source(volume());
  Progress silent;
  EXPECT_FALSE(errorOf(source, directory / "volume.kiln", on_disk, silent));
  EXPECT_TRUE(filesOf(directory / "volume.kiln") == undisturbed());
}

class ForwardFault : public ::testing::TestWithParam<std::tuple<bool, unsigned>> {
 protected:
  bool on_disk_ = std::get<0>(GetParam());
  ThreadLimit threads_{std::get<1>(GetParam())};
  Progress silent_;
};

TEST_P(ForwardFault, ByTheDiskAtAnyChange) {
  FaultyFileSystem counted;
  ForwardSource first(volume());
  ASSERT_FALSE(errorOf(first, freshDirectory("count") / "volume.kiln", on_disk_, silent_, counted));
  ASSERT_GT(counted.calls(), 12u + (on_disk_ ? 25u : 0u));
  // The changes of the bricks are covered by convert_fault_test; every change is tested only if the slices are on disk.
  const std::uint64_t step = on_disk_ && ThreadLimit::active() == 1 ? 1 : 5;
  for (std::uint64_t n = 0; n < counted.calls(); n += step) {
    SCOPED_TRACE("change " + std::to_string(n) + " of " + std::to_string(counted.calls()));
    const bool full = n / step % 2 == 0;
    const fs::path directory = freshDirectory("disk");
    FaultyFileSystem disk({n, full ? ENOSPC : EIO});
    ForwardSource source(volume());
    EXPECT_EQ(errorOf(source, directory / "volume.kiln", on_disk_, silent_, disk),
              full ? ErrorCode::kNoSpace : ErrorCode::kIo);
    expectNoStoreThenOne(directory, on_disk_);
  }
}

TEST_P(ForwardFault, BySourcesThatEndEarly) {
  for (const int reads : {0, 1, 12, 24}) {
    SCOPED_TRACE(reads);
    const fs::path directory = freshDirectory("source");
    ForwardSource source(volume(), reads);
    EXPECT_EQ(errorOf(source, directory / "volume.kiln", on_disk_, silent_), ErrorCode::kFormat);
    expectNoStoreThenOne(directory, on_disk_);
  }
}

TEST_P(ForwardFault, ByTheUser) {
  for (const int polls : {0, 1, 20, 36}) {
    SCOPED_TRACE(polls);
    const fs::path directory = freshDirectory("user");
    ForwardSource source(volume());
    ImpatientProgress progress(polls);
    EXPECT_EQ(errorOf(source, directory / "volume.kiln", on_disk_, progress), ErrorCode::kCancelled);
    expectNoStoreThenOne(directory, on_disk_);
  }
}

INSTANTIATE_TEST_SUITE_P(Windows, ForwardFault, ::testing::Combine(::testing::Bool(), ::testing::Values(1u, 4u)),
                         [](const auto& made) {
                           return std::string(std::get<0>(made.param) ? "OnDisk" : "InMemory") +
                                  (std::get<1>(made.param) == 1 ? "" : "WithThreads");
                         });

// A strip holds as many thin slices as fit, and no list of layers is searched: 10,000 layers of bricks take time
// proportional to their number. Known by the count of reads, after which the source ends.
TEST(ForwardSourceOfThinSlices, IsReadManySlicesAtATime) {
  constexpr std::int64_t kSlices = 80'000;
  const DenseVolume thin = ramp({{1, 1, kSlices}, VoxelType::u8}, 7, 0);
  ConvertOptions asked;
  asked.brick_size = 8;
  asked.most_levels = 1;
  // One read for each layer of bricks, and a few more at the ends of the ring buffer.
  ForwardSource source(thin, static_cast<int>(2 * kSlices / asked.brick_size));
  Progress silent;
  const ConvertReport report = convert(source, freshDirectory("thin_slices") / "v.kiln", asked, silent);
  EXPECT_EQ(report.bricks, static_cast<std::uint64_t>(kSlices / asked.brick_size));
}

}  // namespace
}  // namespace kiln::test
