// Sources that change during a conversion, or are replaced afterwards by files of equal size and time. A store never
// mixes two states of a source. Known because the test changes the files itself.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "base/error.h"
#include "base/file/file.h"
#include "base/thread/parallel.h"
#include "convert/foreign_cache.h"
#include "convert/resume/source_state.h"
#include "convert/store_of_source.h"
#include "ingest/open_source.h"
#include "store/store_reader.h"
#include "support/files/foreign_files.h"
#include "support/system/impatient_progress.h"
#include "support/system/text_of.h"
#include "support/volumes/conversions.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr Extent3 kDims = {48, 48, 48};

std::string voxels(std::uint64_t seed) {
  return std::string(textOf(noise({kDims, VoxelType::u8}, seed, {0, 255}).voxels));
}

SourceOptions described() {
  SourceOptions out;
  out.dims = kDims;
  out.type = VoxelType::u8;
  return out;
}

// Replaces the bytes, and puts the former time of writing back.
void rewrite(const fs::path& path, const std::string& bytes) {
  const fs::file_time_type before = fs::last_write_time(path);
  writeText(path, bytes);
  fs::last_write_time(path, before);
}

ConvertOptions bricksOf16() {
  ConvertOptions out;
  out.brick_size = 16;
  return out;
}

TEST(ChangedSource, WhileItIsConverted_LeavesNoStore) {
  const ThreadLimit one(1);  // another thread would see the file truncated during the rewrite
  const fs::path directory = freshDirectory("changed_source"), path = directory / "v.raw", out = directory / "v.kiln";
  const std::pair<const char*, std::function<void()>> changes[] = {
      {"rewritten", [&] { writeText(path, voxels(2)); }},
      {"rewritten with the former time", [&] { rewrite(path, voxels(3)); }},
      {"replaced", [&] {
         writeText(directory / "next", voxels(4));
         fs::last_write_time(directory / "next", fs::last_write_time(path));
         fs::rename(directory / "next", path);
       }}};
  for (const auto& [what, change] : changes) {
    writeText(path, voxels(1));
    ChangingSource source(openSource(path, described()), 8, change);
    Progress silent;
    SCOPED_TRACE(what);
    expectError([&] { convert(source, out, bricksOf16(), silent); }, ErrorCode::kFormat,
                path.string() + ": was changed while it was converted");
    EXPECT_EQ(std::distance(fs::directory_iterator(directory), {}), 1);
  }
  // Neither a look nor a change of rights is a change of the file.
  ChangingSource source(openSource(path, described()), 8, [&] {
    readFile(path);
    fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write);
  });
  Progress silent;
  convert(source, out, bricksOf16(), silent);
  EXPECT_TRUE(isStoreOf(out, source.info()));
  SourceInfo in_inches = source.info();
  in_inches.geometry.unit = "inch";
  EXPECT_FALSE(isStoreOf(out, in_inches));
}

TEST(ChangedSource, BetweenTwoRuns_IsNotResumed) {
  const fs::path directory = freshDirectory("changed_resume"), path = directory / "v.raw", out = directory / "v.kiln";
  writeText(path, voxels(1));
  ImpatientProgress impatient(5);
  EXPECT_THROW(convert(*openSource(path, described()), out, bricksOf16(), impatient), Error);
  rewrite(path, voxels(2));
  ConvertOptions resuming = bricksOf16();
  resuming.resume = true;
  Progress silent;
  expectError([&] { convert(*openSource(path, described()), out, resuming, silent); }, ErrorCode::kExists,
              "another source, an older state of it");
}

TEST(SourceState, IsTheFilesContentAndOrder) {
  const fs::path directory = freshDirectory("source_state");
  const std::vector<fs::path> files = {directory / "a", directory / "b"};
  for (const fs::path& file : files) writeText(file, voxels(1));
  const std::string state = stateOf(files);
  EXPECT_TRUE(isStateOf(state, files));
  // Changes one byte of a file that is hashed completely.
  std::string changed = voxels(1);
  changed[77777] ^= 1;
  rewrite(files[1], changed);
  EXPECT_FALSE(isStateOf(state, files));
  EXPECT_NE(portableState(stateOf(files)), portableState(state));
  rewrite(files[1], voxels(1));
  EXPECT_TRUE(isStateOf(state, files)) << "equal content, another ctime";
  EXPECT_EQ(portableState(stateOf(files)), portableState(state));
  EXPECT_FALSE(isStateOf(state, {files[1], files[0]}));
  // A state of an earlier version: sizes and times alone.
  EXPECT_TRUE(isStateOf(state.substr(0, 32), files));
  // Larger files are hashed in blocks between the first and the last byte.
  const std::vector<fs::path> large = {directory / "large"};
  writeText(large[0], std::string(100 << 20, 'x'));
  const std::string of_large = stateOf(large);
  for (const std::size_t at : {std::size_t{0}, std::size_t{(100 << 20) - 1}}) {
    std::string bytes(100 << 20, 'x');
    bytes[at] = 'y';
    rewrite(large[0], bytes);
    EXPECT_FALSE(isStateOf(of_large, large)) << at;
  }
}

}  // namespace
}  // namespace kiln::test
