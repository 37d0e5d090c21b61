// Conversions whose n-th change of the disk fails, for every n. Guarantees (convert.h):
// 1. The destination never holds an incomplete store.
// 2. A store that was there before is still there.
// 3. A resumed conversion writes the bytes of an uninterrupted conversion.
#include <gtest/gtest.h>

#include <atomic>
#include <iterator>
#include <map>
#include <new>
#include <optional>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "convert/plan.h"
#include "convert/resume/journal.h"
#include "store/codec/brick_block.h"
#include "store/store_reader.h"
#include "support/system/expect_error.h"
#include "support/system/faulty_file_system.h"
#include "support/system/impatient_progress.h"
#include "support/system/sanitized.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kBrickSize = 16;

enum class How { kNew, kOverwrite, kResume };

ConvertOptions options(How how = How::kNew) {
  ConvertOptions out;
  out.brick_size = kBrickSize;
  out.overwrite = how == How::kOverwrite;
  out.resume = how == How::kResume;
  return out;
}

// Tests that `path` is a whole store and holds exactly `volume`.
bool holds(const fs::path& path, const DenseVolume& volume) {
  try {
    const StoreReader store(path);
    wholeFiles(path);
    if (store.manifest().geometry().dims != volume.geometry.dims) return false;
    const Extent3& n = store.index().lattice(0);
    for (std::int64_t i = 0; i < n.count(); ++i) {
      const BrickBlock block = store.read({0, brickAt(n, i)});
      for (std::int64_t z = block.core.lo.z; z < block.core.hi.z; ++z) {
        for (std::int64_t y = block.core.lo.y; y < block.core.hi.y; ++y) {
          for (std::int64_t x = block.core.lo.x; x < block.core.hi.x; ++x) {
            if (block.data<std::int16_t>()[block.offsetOf({x, y, z})] != volume.at<std::int16_t>(x, y, z)) return false;
          }
        }
      }
    }
    return true;
  } catch (const Error&) {
    return false;
  }
}

// Tests that `path` opens as a store, whole or not.
bool opens(const fs::path& path) {
  try {
    StoreReader store(path);
    return true;
  } catch (const Error&) {
    return false;
  }
}

int temporaryFiles(const fs::path& directory) {
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) count += entry.path().extension() == ".tmp";
  return count;
}

DenseVolume newVolume() { return cheese({{33, 18, 9}, VoxelType::i16}, 1, usualRange(VoxelType::i16)); }
DenseVolume oldVolume() { return cheese({{20, 9, 9}, VoxelType::i16}, 2, usualRange(VoxelType::i16)); }

// Runs a conversion on `disk` and returns its error, if any.
std::optional<Error> convertWith(const DenseVolume& volume, const fs::path& out, How how, FaultyFileSystem& disk) {
  DenseSource source(volume);
  Progress silent;
  ConvertOptions asked = options(how);
  // Leaves no memory for half bricks, so that each is a file whose writing may fail.
  const ConversionPlan ample = planConversion(source, asked);
  asked.memory_bytes = ample.total() - ample.parts_bytes;
  try {
    asked.disk = &disk;
    convert(source, out, asked, silent);
    return std::nullopt;
  } catch (const Error& error) {
    return error;
  }
}

// Returns a store that a user stopped after some of its bricks were written.
fs::path interruptedConversion(const DenseVolume& volume, const std::string& name) {
  const fs::path out = freshDirectory(name) / "volume.kiln";
  DenseSource source(volume);
  ImpatientProgress impatient(5);
  EXPECT_THROW(convert(source, out, options(), impatient), Error);
  return out;
}

// Returns the files of an uninterrupted conversion.
std::map<std::string, std::vector<std::byte>> wholeStore(const DenseVolume& volume) {
  const fs::path directory = freshDirectory("fault_whole");
  FaultyFileSystem works;
  EXPECT_FALSE(convertWith(volume, directory / "volume.kiln", How::kNew, works));
  return filesOf(directory);
}

std::uint64_t changesOf(bool overwrite) {
  const fs::path out = freshDirectory("fault_count") / "volume.kiln";
  FaultyFileSystem disk;
  EXPECT_FALSE(convertWith(oldVolume(), out, How::kNew, disk));
  if (!overwrite) fs::remove_all(out);
  FaultyFileSystem counted;
  EXPECT_FALSE(convertWith(newVolume(), out, overwrite ? How::kOverwrite : How::kNew, counted));
  EXPECT_TRUE(holds(out, newVolume()));
  EXPECT_EQ(std::distance(fs::directory_iterator(out.parent_path()), {}), 1) << "something was left beside the store";
  return counted.calls();
}

// Known because half bricks have equal contents in memory and in files.
TEST(ConvertParts, MayBeInMemoryOrInFiles) {
  // A single thread, because the number of waiting half bricks depends on the threads.
  const ThreadLimit one(1);
  const DenseVolume volume = cheese({{70, 40, 40}, VoxelType::i16}, 1, usualRange(VoxelType::i16));
  DenseSource source(volume);
  ConvertOptions asked = options();
  const ConversionPlan ample = planConversion(source, asked);
  ASSERT_GT(ample.parts_bytes, 0u);
  ASSERT_EQ(ample.scratch_bytes, 0u);
  std::map<std::string, std::vector<std::byte>> first;
  std::vector<std::uint64_t> changes;
  for (const double share : {1.0, 0.1, 0.0}) {
    const fs::path directory = freshDirectory("parts");
    asked.memory_bytes =
        ample.total() - ample.parts_bytes + static_cast<std::uint64_t>(share * static_cast<double>(ample.parts_bytes));
    FaultyFileSystem disk;
    Progress silent;
    asked.disk = &disk;
    const ConvertReport report = convert(source, directory / "volume.kiln", asked, silent);
    EXPECT_LE(report.buffer_bytes, asked.memory_bytes);
    changes.push_back(disk.calls());
    if (first.empty()) first = filesOf(directory);
    EXPECT_EQ(filesOf(directory), first);
  }
  EXPECT_LT(changes[0], changes[1]);
  EXPECT_LT(changes[1], changes[2]);
}

// Known because the index is equal whether sub-ranges wait in memory or in a file.
TEST(ConvertSubRanges, MayBeInMemoryOrInAFile) {
  const ThreadLimit one(1);
  const DenseVolume volume = cheese({{70, 40, 40}, VoxelType::i16}, 1, usualRange(VoxelType::i16));
  DenseSource source(volume);
  ConvertOptions asked = options();
  const ConversionPlan ample = planConversion(source, asked);
  ASSERT_GT(ample.sub_ranges_bytes, 0u);
  Progress silent;
  std::map<std::string, std::vector<std::byte>> stores[2];
  for (const bool on_disk : {false, true}) {
    if (on_disk) asked.memory_bytes = ample.index_bytes + ample.lane_bytes;
    ASSERT_EQ(planConversion(source, asked).sub_ranges_on_disk, on_disk);
    const fs::path directory = freshDirectory("sub_ranges");
    convert(source, directory / "volume.kiln", asked, silent);
    stores[on_disk ? 1 : 0] = filesOf(directory);
  }
  EXPECT_EQ(stores[1], stores[0]);
}

struct FaultCase {
  const char* name;
  int error_number;
  ErrorCode code;
  bool torn_write, crash;
};
constexpr FaultCase kFaults[] = {
    {"Full", ENOSPC, ErrorCode::kNoSpace, false, false},
    {"FullTorn", ENOSPC, ErrorCode::kNoSpace, true, false},
    {"Io", EIO, ErrorCode::kIo, false, false},
    {"IoTorn", EIO, ErrorCode::kIo, true, false},
    {"Crash", EIO, ErrorCode::kIo, false, true},
    {"CrashTorn", EIO, ErrorCode::kIo, true, true},
    {"FullCrashTorn", ENOSPC, ErrorCode::kNoSpace, true, true},
};

// The parameter is the fault's place above.
class ConvertFault : public ::testing::TestWithParam<std::size_t> {
 protected:
  // A sanitizer sees every third change of each fault, and every change of some.
  static constexpr std::size_t kStep = casesOf(1, 3);
  std::uint64_t firstChange() const { return GetParam() % kStep; }

  const FaultCase& fault() const { return kFaults[GetParam()]; }
  DiskFault faultAt(std::uint64_t n) const { return {n, fault().error_number, fault().torn_write, fault().crash}; }

  void expectError(const std::optional<Error>& error) const {
    ASSERT_TRUE(error);
    EXPECT_EQ(error->code(), fault().code) << error->what();
    EXPECT_FALSE(error->path().empty()) << error->what();
  }
};

// Known because a folder is a store if and only if its manifest is there (FORMAT.md), and a failed conversion writes no
// manifest.
TEST_P(ConvertFault, LeavesNoStore) {
  const std::uint64_t changes = changesOf(false);
  ASSERT_GT(changes, 10u);
  const DenseVolume volume = newVolume();
  const ThreadLimit one(1);
  const auto whole = wholeStore(volume);
  for (std::uint64_t n = firstChange(); n < changes; n += kStep) {
    SCOPED_TRACE("change " + std::to_string(n) + " of " + std::to_string(changes));
    const fs::path directory = freshDirectory(std::string("fault_new_") + fault().name);
    const fs::path out = directory / "volume.kiln";
    FaultyFileSystem disk(faultAt(n));
    expectError(convertWith(volume, out, How::kNew, disk));
    EXPECT_TRUE(disk.failed());
    if (fault().crash) {
      disk.leaveWreckage();
    } else {
      EXPECT_EQ(temporaryFiles(directory), 0);
    }
    EXPECT_FALSE(opens(out));
    // Remains are no obstacle: the next conversion, with --resume or --overwrite, makes the store.
    FaultyFileSystem works;
    const std::optional<Error> again = convertWith(volume, out, n % 4 == 3 ? How::kOverwrite : How::kResume, works);
    EXPECT_FALSE(again) << again->what();
    EXPECT_EQ(filesOf(directory), whole);
  }
}

// Known because the old store stays untouched until the new store is whole. A crash before the names are exchanged
// leaves the new store at OUT.old, so nothing is lost; OUT itself is whole at any time.
TEST_P(ConvertFault, OverwriteKeepsTheOldStore) {
  const std::uint64_t changes = changesOf(true);
  const DenseVolume old_volume = oldVolume(), new_volume = newVolume();
  const ThreadLimit one(1);
  const fs::path old_store = makeStore(old_volume, std::string("fault_old_") + fault().name, kBrickSize);
  for (std::uint64_t n = firstChange(); n < changes; n += kStep) {
    SCOPED_TRACE("change " + std::to_string(n) + " of " + std::to_string(changes));
    const fs::path directory = freshDirectory(std::string("fault_over_") + fault().name);
    const fs::path out = directory / "volume.kiln", old_path = out.string() + ".old";
    fs::copy(old_store, out, fs::copy_options::recursive);
    FaultyFileSystem disk(faultAt(n));
    const std::optional<Error> error = convertWith(new_volume, out, How::kOverwrite, disk);
    EXPECT_TRUE(disk.failed());
    if (error) {
      expectError(error);
    } else {
      // Only the final cleanup may fail silently: the new store is already in place.
      EXPECT_TRUE(holds(out, new_volume));
    }
    if (fault().crash) {
      disk.leaveWreckage();
      EXPECT_TRUE(holds(out, old_volume) || holds(out, new_volume));
    } else if (error) {
      EXPECT_TRUE(holds(out, old_volume));
      EXPECT_EQ(temporaryFiles(directory), 0);
    }
    // Both names may exist now. A resumed conversion, or a new one without a journal, cleans up.
    FaultyFileSystem again;
    const bool begun = fs::exists(out.string() + ".partial/journal.bin");
    std::optional<Error> second = convertWith(new_volume, out, begun ? How::kResume : How::kOverwrite, again);
    // If the exchange or the first removal failed, OUT.old is still a whole store of unknown origin and is kept.
    if (second && opens(old_path)) {
      EXPECT_TRUE(second->code() == ErrorCode::kExists && second->path() == old_path) << second->what();
      fs::remove_all(old_path);
      second = convertWith(new_volume, out, How::kOverwrite, again);
    }
    EXPECT_FALSE(second) << second->what();
    EXPECT_TRUE(holds(out, new_volume));
    // A conversion removes OUT.old only after moving it there itself.
    EXPECT_TRUE(!fs::exists(old_path) || holds(old_path, old_volume));
    EXPECT_FALSE(fs::exists(out.string() + ".partial"));
  }
}

// Known as above. With several threads bricks are written behind their makers, so the failing thread is random, and all
// other threads must stop.
TEST_P(ConvertFault, LeavesNoStoreWithThreads) {
  const std::uint64_t changes = changesOf(false);
  const DenseVolume volume = newVolume();
  const auto whole = wholeStore(volume);
  const ThreadLimit four(4);
  for (std::uint64_t n = firstChange(); n < changes; n += kStep) {
    SCOPED_TRACE("change " + std::to_string(n) + " of " + std::to_string(changes));
    const fs::path directory = freshDirectory(std::string("fault_threads_") + fault().name);
    FaultyFileSystem disk(faultAt(n));
    expectError(convertWith(volume, directory / "volume.kiln", How::kNew, disk));
    if (fault().crash) disk.leaveWreckage();
    EXPECT_FALSE(opens(directory / "volume.kiln"));
    if (!fault().crash) {
      EXPECT_EQ(temporaryFiles(directory), 0);
    }
    if (n % 3 != 0) continue;
    FaultyFileSystem works;
    EXPECT_FALSE(convertWith(volume, directory / "volume.kiln", How::kResume, works));
    EXPECT_EQ(filesOf(directory), whole);
  }
}

INSTANTIATE_TEST_SUITE_P(Faults, ConvertFault, ::testing::Range<std::size_t>(0, std::size(kFaults)),
                         [](const auto& fault) { return std::string(kFaults[fault.param].name); });

// Like NFS, which cannot exchange names.
class WithoutExchange : public FaultyFileSystem {
 public:
  using FaultyFileSystem::FaultyFileSystem;
  bool exchange(const fs::path&, const fs::path&) override { return false; }
};

// Known as above: the old store is moved aside and comes back, and each of the last changes fails once.
TEST(ConvertStopped, WhereNamesCannotBeExchanged_TheOldStoreIsKept) {
  const DenseVolume old_volume = oldVolume(), new_volume = newVolume();
  const ThreadLimit one(1);
  const fs::path old_store = makeStore(old_volume, "fault_no_exchange", kBrickSize);
  const fs::path out = freshDirectory("fault_no_exchange_out") / "volume.kiln";
  const auto replace = [&](WithoutExchange& disk) {
    fs::remove_all(out.parent_path());
    fs::create_directories(out.parent_path());
    fs::copy(old_store, out, fs::copy_options::recursive);
    return convertWith(new_volume, out, How::kOverwrite, disk);
  };
  WithoutExchange works;
  EXPECT_FALSE(replace(works));
  EXPECT_TRUE(holds(out, new_volume));
  EXPECT_EQ(std::distance(fs::directory_iterator(out.parent_path()), {}), 1);
  for (std::uint64_t n = works.calls() - 9; n < works.calls(); ++n) {
    WithoutExchange disk(DiskFault{n, EIO});
    const bool failed = replace(disk).has_value();
    EXPECT_TRUE(holds(out, failed ? old_volume : new_volume)) << n;
  }
}

// Known because convert polls before every brick, and three levels have nine bricks. After an interrupt at any poll, a
// resumed conversion writes the bytes of an uninterrupted conversion.
TEST(ConvertStopped, ByTheUserIsResumed) {
  const DenseVolume volume = newVolume();
  const auto whole = wholeStore(volume);
  for (int polls = 0; polls < 9; ++polls) {
    SCOPED_TRACE(polls);
    const fs::path directory = freshDirectory("fault_cancel");
    const fs::path out = directory / "volume.kiln";
    DenseSource source(volume);
    ImpatientProgress progress(polls);
    test::expectError([&] { convert(source, out, options(), progress); }, ErrorCode::kCancelled, "");
    EXPECT_EQ(fs::is_empty(directory), polls == 0) << "what is begun is kept, what is not leaves nothing";
    EXPECT_FALSE(opens(out));
    Progress silent;
    convert(source, out, options(How::kResume), silent);
    EXPECT_EQ(filesOf(directory), whole);
  }
}

// Known because each case differs by one byte from a conversion that may be resumed: another value, another brick size,
// a brick file damaged meanwhile.
TEST(ConvertStopped, OnlyTheSameConversionIsResumed) {
  const DenseVolume volume = newVolume();
  const auto whole = wholeStore(volume);
  const auto interrupted = [&] { return interruptedConversion(volume, "fault_same"); };
  const auto resume = [&](const DenseVolume& with, const fs::path& out, std::int64_t brick_size) {
    DenseSource source(with);
    Progress silent;
    ConvertOptions how = options(How::kResume);
    how.brick_size = brick_size;
    convert(source, out, how, silent);
  };
  const fs::path out = interrupted();
  EXPECT_THROW(resume(volume, out, 2 * kBrickSize), Error);
  EXPECT_THROW(resume(oldVolume(), out, kBrickSize), Error);
  const auto damage = [](const fs::path& brick) {
    std::vector<std::byte> file = readFile(brick);
    file[file.size() / 2] ^= std::byte{1};
    FileSystem::real().writeFile(brick, file, WritePolicy::kUnsynced);
  };
  damage(out / "bricks/0/1_0_0.vdb");
  resume(volume, out, kBrickSize);
  EXPECT_EQ(filesOf(out.parent_path()), whole);
  // The disk fails at the manifest, when every brick is finished. A damaged brick is then made again, its parents are
  // not.
  for (const char* brick : {"bricks/0/1_0_0.vdb", "bricks/1/0_0_0.vdb", "bricks/2/0_0_0.vdb"}) {
    SCOPED_TRACE(brick);
    const fs::path again = freshDirectory("fault_same") / "volume.kiln";
    FaultyFileSystem disk({changesOf(false) - 2, EIO, false, false});
    ASSERT_TRUE(convertWith(volume, again, How::kNew, disk));
    damage(again / brick);
    resume(volume, again, kBrickSize);
    EXPECT_EQ(filesOf(again.parent_path()), whole);
  }
  const fs::path finished = makeStore(volume, "fault_finished", kBrickSize);
  const auto before = filesOf(finished);
  resume(volume, finished, kBrickSize);
  EXPECT_EQ(filesOf(finished), before) << "a finished store is left as it is";
}

// The user's old store stays equal to the byte, at every point where the new conversion stops.
TEST(ConvertStopped, ByTheUserKeepsTheOldStore) {
  const DenseVolume volume = newVolume();
  for (const int polls : {0, 1, 5}) {
    SCOPED_TRACE(polls);
    const fs::path out = makeStore(oldVolume(), "fault_cancel_over", kBrickSize);
    DenseSource source(volume);
    ImpatientProgress progress(polls);
    EXPECT_THROW(convert(source, out, options(How::kOverwrite), progress), Error);
    EXPECT_TRUE(holds(out, oldVolume()));
    EXPECT_EQ(fs::exists(out.string() + ".partial"), polls > 0);
  }
}

// A truncated source file: reads fail from the n-th on, or at the very end, where a stream's own checksum is.
class TruncatedSource : public VolumeSource {
 public:
  TruncatedSource(const DenseVolume& volume, ReadOrder order, int reads)
      : dense_(volume), order_(order), left_(reads) {}
  const SourceInfo& info() const override { return dense_.info(); }
  ReadOrder order() const override { return order_; }
  void read(const VoxelBox& box, std::span<std::byte> out) override {
    if (left_-- <= 0) throw Error(ErrorCode::kFormat, "scan.raw", "byte 4711", "the file ends here");
    dense_.read(box, out);
  }
  void finish() override {
    throw Error(ErrorCode::kFormat, "scan.raw", "byte 9999", "the stream's checksum disagrees");
  }

 private:
  DenseSource dense_;
  ReadOrder order_;
  std::atomic<int> left_;
};

// Known because the source never delivers all voxels, or fails its checksum at the end.
TEST(ConvertStopped, ByATruncatedSourceLeavesNothing) {
  const DenseVolume volume = newVolume();
  for (const ReadOrder order : {ReadOrder::kAnyBox, ReadOrder::kForward}) {
    for (const int reads : {0, 1, 2, 5, 11, 1000}) {
      for (const bool over : {false, true}) {
        SCOPED_TRACE(std::to_string(reads) + (over ? " over" : ""));
        const fs::path out = over ? makeStore(oldVolume(), "fault_truncated", kBrickSize)
                                  : freshDirectory("fault_truncated") / "volume.kiln";
        TruncatedSource source(volume, order, reads);
        Progress silent;
        try {
          convert(source, out, options(over ? How::kOverwrite : How::kNew), silent);
          ADD_FAILURE() << "taken for whole";
        } catch (const Error& error) {
          EXPECT_EQ(error.code(), ErrorCode::kFormat);
          EXPECT_EQ(error.path(), "scan.raw");
        }
        EXPECT_EQ(holds(out, oldVolume()), over);
        EXPECT_EQ(std::distance(fs::directory_iterator(out.parent_path()), {}), over ? 1 : 0);
      }
    }
  }
}

// Known because a folder that is no store holds the user's data: it is replaced neither by default nor by --overwrite.
TEST(ConvertStopped, WhatIsThereIsNotReplaced) {
  const fs::path out = makeStore(oldVolume(), "fault_exists", kBrickSize);
  const DenseVolume volume = newVolume();
  DenseSource other(volume);
  Progress silent;
  const auto codeOf = [&](const fs::path& path, bool overwrite) {
    try {
      convert(other, path, options(overwrite ? How::kOverwrite : How::kNew), silent);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::kCancelled;
  };
  EXPECT_EQ(codeOf(out, false), ErrorCode::kExists);
  FileSystem::real().writeFile(out / "thesis.txt", {}, WritePolicy::kUnsynced);
  EXPECT_EQ(codeOf(out, true), ErrorCode::kExists);
  EXPECT_EQ(codeOf(out / "thesis.txt", true), ErrorCode::kUsage) << "a store holds no other";
  const fs::path beside = out.parent_path() / "thesis.txt";
  FileSystem::real().writeFile(beside, {}, WritePolicy::kUnsynced);
  EXPECT_EQ(codeOf(beside, true), ErrorCode::kExists);
  EXPECT_TRUE(fs::exists(beside));
  EXPECT_TRUE(fs::exists(out / "thesis.txt"));
  test::expectError([&] { convert(other, out, options(How::kOverwrite), silent); }, ErrorCode::kExists,
                    "holds 'thesis.txt' beside the store");
  fs::remove(out / "thesis.txt");
  fs::create_directory(out / "bricks/mine");
  for (const char* name : {"bricks/mine/thesis.txt", "bricks/0/.notes", "bricks/0/2024", "bricks/0/2024.pdf"}) {
    FileSystem::real().writeFile(out / name, {}, WritePolicy::kUnsynced);
    test::expectError([&] { convert(other, out, options(How::kOverwrite), silent); }, ErrorCode::kExists,
                      "holds '" + std::string(name) + "' beside the store");
    fs::remove(out / name);
  }
  EXPECT_TRUE(holds(out, oldVolume()));
  // A store at OUT.old, the name for moving the old store, is not replaced either; an incomplete store is.
  const fs::path kept = out.string() + ".old";
  fs::copy(out, kept, fs::copy_options::recursive);
  EXPECT_EQ(codeOf(out, true), ErrorCode::kExists);
  EXPECT_TRUE(holds(kept, oldVolume()));
  EXPECT_TRUE(holds(out, oldVolume()));
  fs::remove(kept / "manifest.json");
  EXPECT_EQ(codeOf(out, true), ErrorCode::kCancelled) << "which means that it succeeded";
  EXPECT_TRUE(holds(out, volume));
  EXPECT_FALSE(fs::exists(kept));
}

TEST(ConvertStopped, FileOfTheUserThatComesMeanwhile_staysInTheOldStore) {
  const fs::path out = makeStore(oldVolume(), "fault_meanwhile", kBrickSize);
  const DenseVolume volume = newVolume();
  ChangingSource source(std::make_unique<DenseSource>(volume), 2,
                        [&] { FileSystem::real().writeFile(out / "thesis.txt", {}, WritePolicy::kUnsynced); });
  Progress silent;
  convert(source, out, options(How::kOverwrite), silent);
  EXPECT_TRUE(holds(out, volume));
  EXPECT_TRUE(fs::exists(out.string() + ".old/thesis.txt"));
}

// Known because desktops write these files into every visited folder, and the files hold no user data.
TEST(ConvertStopped, FilesOfADesktopInAStore_areReplacedWithIt) {
  const fs::path out = makeStore(oldVolume(), "fault_desktop", kBrickSize);
  for (const char* name : {".DS_Store", "Thumbs.db", "desktop.ini", "._manifest.json"})
    FileSystem::real().writeFile(out / name, {}, WritePolicy::kUnsynced);
  const DenseVolume volume = newVolume();
  DenseSource other(volume);
  Progress silent;
  convert(other, out, options(How::kOverwrite), silent);
  EXPECT_TRUE(holds(out, volume));
  EXPECT_FALSE(fs::exists(out / ".DS_Store"));
}

// Known because bricks recorded in the journal are whole, whatever fails later.
TEST(ConvertStopped, WhatIsNoErrorOfOursCostsNoBrick) {
  const DenseVolume volume = newVolume();
  struct OutOfMemory : Progress {
    void advance(const char*, const char*, std::uint64_t, std::uint64_t) override {
      if (++bricks == 3) throw std::bad_alloc();
    }
    int bricks = 0;
  } progress;
  const ThreadLimit one(1);
  const fs::path out = freshDirectory("fault_memory") / "volume.kiln";
  DenseSource source(volume);
  EXPECT_THROW(convert(source, out, options(), progress), std::bad_alloc);
  EXPECT_FALSE(opens(out));
  EXPECT_TRUE(fs::exists(out / "journal.bin"));
  EXPECT_GE(progress.bricks, 3);
  Progress silent;
  convert(source, out, options(How::kResume), silent);
  EXPECT_TRUE(holds(out, volume));
}

// Known because the journal records the bricks before and after.
TEST(ConvertStopped, AResumedConversionThatStopsAtOnceKeepsTheBricks) {
  const DenseVolume volume = newVolume();
  const ThreadLimit one(1);
  const fs::path out = interruptedConversion(volume, "fault_at_once");
  DenseSource source(volume);
  const auto noted = [&] {
    std::size_t bricks = 0;
    Journal::forEachBrick(out, [&](const FinishedBrick&) { ++bricks; });
    return bricks;
  };
  const std::size_t before = noted();
  ASSERT_GT(before, 0u);
  ImpatientProgress at_once(0);
  EXPECT_THROW(convert(source, out, options(How::kResume), at_once), Error);
  EXPECT_EQ(noted(), before);
  for (const std::uint64_t change : {0u, 1u, 2u}) {
    FaultyFileSystem full({change, ENOSPC, false, false});
    EXPECT_TRUE(convertWith(volume, out, How::kResume, full));
    EXPECT_GE(noted(), before) << change;
  }
  Progress silent;
  convert(source, out, options(How::kResume), silent);
  EXPECT_TRUE(holds(out, volume));
}

// Known because the volume has three by two by one bricks, and levels up to a single brick.
TEST(ConvertStopped, ABrickOfTheJournalThatTheVolumeHasNotIsNone) {
  const DenseVolume volume = newVolume();
  const ThreadLimit one(1);
  const fs::path out = interruptedConversion(volume, "fault_keys");
  DenseSource source(volume);
  std::vector<FinishedBrick> noted;
  const auto read = [&] {
    noted.clear();
    Journal::forEachBrick(out, [&](const FinishedBrick& brick) { noted.push_back(brick); });
    return noted.size();
  };
  const std::optional<ConversionIdentity> identity = Journal::identityIn(out);
  const std::size_t before = read();
  ASSERT_TRUE(identity && before > 0);
  Journal journal(
      out, *identity, [](const FinishedBrick&) { return true; }, FileSystem::real());
  for (const BrickKey& key : {BrickKey{0, {99, 0, 0}}, {0, {0, -1, 0}}, {7, {0, 0, 0}}, {-1, {0, 0, 0}}})
    journal.append({key, noted.front().entry, {}});
  ASSERT_EQ(read(), before + 4);
  Progress silent;
  convert(source, out, options(How::kResume), silent);
  EXPECT_TRUE(holds(out, volume));
}

}  // namespace
}  // namespace kiln::test
