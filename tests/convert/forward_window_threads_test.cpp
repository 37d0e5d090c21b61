// Bricks cut from a source that is read forwards equal the volume's, in memory or on disk, for any number of slices and
// threads. After any failure all threads return the error. Known because the volume is also in memory.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "base/thread/parallel.h"
#include "convert/stream/forward_window.h"
#include "grid/geometry.h"
#include "store/codec/brick_codec.h"
#include "store/manifest/manifest.h"
#include "support/system/faulty_file_system.h"
#include "support/system/impatient_progress.h"
#include "support/volumes/forward_source.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kBrickSize = 8;

// Slices larger than a strip, and layers of one and a half bricks.
const DenseVolume& volume() {
  static const DenseVolume made = noise({{1031, 130, 48}, VoxelType::u16}, 3, {0, 65535});
  return made;
}

VoxelBox storedOf(std::int64_t brick, std::int64_t brick_size) {
  const Extent3& dims = volume().geometry.dims;
  const BrickKey key{0, brickAt(brickLattice(dims, brick_size), brick)};
  return BrickDesc{key, volume().type, brick_size, kApron, volume().geometry}.stored();
}

std::vector<std::byte> voxelsIn(const VoxelBox& box) {
  std::vector<std::byte> out(static_cast<std::size_t>(box.count()) * sizeOf(volume().type));
  DenseSource(volume()).read(box, out);
  return out;
}

// Returns all bricks in order.
ForwardWindow::Next all(std::int64_t brick_size) {
  return [next = std::int64_t{0},
          count = brickLattice(volume().geometry.dims, brick_size).count()]() mutable -> std::optional<std::int64_t> {
    return next < count ? std::optional(next++) : std::nullopt;
  };
}

std::unique_ptr<SliceRing> ring(bool on_disk, std::int64_t slices, const fs::path& directory,
                                FileSystem& disk = FileSystem::real()) {
  const ForwardSource source(volume());
  return on_disk ? sliceRingOnDisk(source.info(), slices, directory, disk) : sliceRingInMemory(source.info(), slices);
}

void expectBricks(bool on_disk, std::int64_t brick_size, std::int64_t slices, std::size_t lanes) {
  SCOPED_TRACE(
      fmt::format("{}, bricks of {}, {} slices, {} lanes", on_disk ? "disk" : "memory", brick_size, slices, lanes));
  const fs::path directory = freshDirectory("ring");
  ForwardSource source(volume());
  Progress silent;
  ForwardWindow window(source, ring(on_disk, slices, directory), brick_size, all(brick_size), silent);
  EXPECT_TRUE(fs::is_empty(directory));  // no file remains, however the process ends
  std::vector<std::atomic<int>> taken(
      static_cast<std::size_t>(brickLattice(volume().geometry.dims, brick_size).count()));
  std::atomic<int> wrong = 0;
  const ThreadLimit threads(static_cast<unsigned>(lanes));
  parallelFor(lanes, [&](std::size_t) {
    window.work([&](std::int64_t brick) {
      const VoxelBox box = storedOf(brick, brick_size);
      std::vector<std::byte> voxels(static_cast<std::size_t>(box.count()) * sizeOf(volume().type));
      window.copy(box, voxels);
      wrong += voxels != voxelsIn(box);
      ++taken[static_cast<std::size_t>(brick)];
    });
  });
  EXPECT_EQ(wrong, 0);
  EXPECT_TRUE(std::all_of(taken.begin(), taken.end(), [](int times) { return times == 1; }));
  EXPECT_EQ(source.slicesRead(), volume().geometry.dims.z);
  EXPECT_LE(source.largestReadBytes(), stripBytes(source.info()));
}

TEST(ForwardWindow, GivesTheBricksOfTheVolume) {
  const Extent3& dims = volume().geometry.dims;
  ASSERT_GT(sliceBytes(ForwardSource(volume()).info()), stripBytes(ForwardSource(volume()).info()));
  const std::int64_t least = ForwardWindow::slicesOfLayer(dims, 32);
  for (const bool on_disk : {false, true}) {
    expectBricks(on_disk, 32, least, 1);
    expectBricks(on_disk, 32, least + 3, 3);
    expectBricks(on_disk, 64, dims.z, 2);
  }
}

// Known because the first brick waits for slices beyond its own, so another thread must read them.
TEST(ForwardWindow, ReadsAheadWhileABrickIsInTheMaking) {
  const std::int64_t layer = ForwardWindow::slicesOfLayer(volume().geometry.dims, kBrickSize);
  ForwardSource source(volume());
  Progress silent;
  ForwardWindow window(source, ring(false, layer + kBrickSize, {}), kBrickSize, all(kBrickSize), silent);
  std::atomic<bool> ahead = false;
  const auto lane = [&] {
    window.work([&](std::int64_t brick) {
      const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
      while (brick == 0 && source.slicesRead() < layer + kBrickSize - kApron &&
             std::chrono::steady_clock::now() < deadline)
        std::this_thread::yield();
      if (brick == 0) ahead = source.slicesRead() >= layer + kBrickSize - kApron;
    });
  };
  std::thread other(lane);
  lane();
  other.join();
  EXPECT_TRUE(ahead);
}

// Returns the error code of all lanes together, or kUsage for none.
ErrorCode endOf(
    ForwardSource& source, bool on_disk, Progress& progress, FileSystem& disk,
    const std::function<void(std::int64_t)>& brick = [](std::int64_t) {}) {
  const fs::path directory = freshDirectory("stopped");
  ErrorCode code = ErrorCode::kUsage;
  const ThreadLimit threads(3);
  try {
    const std::int64_t slices = ForwardWindow::slicesOfLayer(volume().geometry.dims, 32);
    ForwardWindow window(source, ring(on_disk, slices, directory, disk), 32, all(32), progress);
    parallelFor(3, [&](std::size_t) { window.work(brick); });
  } catch (const Error& error) {
    code = error.code();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
  EXPECT_TRUE(fs::is_empty(directory));
  return code;
}

TEST(ForwardWindow, StopsAllLanesWithTheFirstError) {
  const ForwardSource counting(volume());
  const std::int64_t rows = stripRows(counting.info()), height = volume().geometry.dims.y;
  const int strips = static_cast<int>((height + rows - 1) / rows * volume().geometry.dims.z);
  Progress silent;
  for (const bool on_disk : {false, true}) {
    for (const int reads : {0, 1, strips / 2, strips - 1}) {
      ForwardSource cut_short(volume(), reads);
      EXPECT_EQ(endOf(cut_short, on_disk, silent, FileSystem::real()), ErrorCode::kFormat) << reads << " reads";
    }
    for (const int polls : {0, 1, strips / 2, strips}) {
      ForwardSource source(volume());
      ImpatientProgress stopping(polls);
      EXPECT_EQ(endOf(source, on_disk, stopping, FileSystem::real()), ErrorCode::kCancelled) << polls << " questions";
    }
    for (const std::int64_t bad : {0, 40, 2 * 5 * 33 - 1}) {
      ForwardSource source(volume());
      EXPECT_EQ(endOf(source, on_disk, silent, FileSystem::real(),
                      [&](std::int64_t i) {
                        if (i == bad) throw Error(ErrorCode::kDamaged, "a brick");
                      }),
                ErrorCode::kDamaged)
          << "brick " << bad;
    }
  }
  // The scratch file is the first change of the disk, each column of a strip another.
  for (const int writes : {0, 1, 2, strips / 2, strips}) {
    ForwardSource source(volume());
    FaultyFileSystem full({static_cast<std::uint64_t>(writes), ENOSPC});
    EXPECT_EQ(endOf(source, true, silent, full), ErrorCode::kNoSpace) << writes << " writes";
    ForwardSource again(volume());
    FaultyFileSystem broken({static_cast<std::uint64_t>(writes), EIO});
    EXPECT_EQ(endOf(again, true, silent, broken), ErrorCode::kIo) << writes << " writes";
  }
}

TEST(ForwardWindow, AFullDiskIsToldWithWhatItShouldHold) {
  ForwardSource source(volume());
  FaultyFileSystem full({1, ENOSPC});
  const auto on_disk = ring(true, 40, freshDirectory("full"), full);
  try {
    on_disk->read(source, {{0, 0, 0}, {1031, 1, 1}});
    ADD_FAILURE() << "written";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("10.2 MiB of slices"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("--memory"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace kiln::test
