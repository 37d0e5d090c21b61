#include "store/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <optional>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/memory/memory.h"
#include "base/text.h"
#include "base/thread/parallel.h"
#include "store/codec/brick_ranges.h"
#include "store/manifest/store_files.h"
#include "store/store_writer.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRemedy = "; convert the source again";

std::string textOf(const ValueRange& range) {
  return range.empty() ? "no value" : fmt::format("[{}, {}]", range.lo, range.hi);
}

// True if a stored range is right for voxels of the given range: a coarser level also covers finer levels.
bool covers(int level, const ValueRange& stored, const ValueRange& voxels) {
  return level == 0 ? stored == voxels : stored.contains(voxels);
}

// Returns the brick whose file has this path in a store; nothing for other files.
std::optional<BrickKey> brickKeyOf(const fs::path& file) {
  const std::string level = file.parent_path().filename().string(), name = file.stem().string();
  const std::vector<std::string_view> parts = splitAt(name, '_');
  if (parts.size() != 3) return std::nullopt;
  const std::array numbers = {decimalOf<int>(level), decimalOf<int>(parts[0]), decimalOf<int>(parts[1]),
                              decimalOf<int>(parts[2])};
  if (!std::all_of(numbers.begin(), numbers.end(), [](const auto& number) { return number.has_value(); }))
    return std::nullopt;
  const BrickKey key{*numbers[0], {*numbers[1], *numbers[2], *numbers[3]}};
  return brickPath(key) == file ? std::optional(key) : std::nullopt;
}

class Verification {
 public:
  Verification(const StoreReader& store, const std::function<void(const Error&)>& damaged, Progress& progress,
               const std::function<bool(const BrickKey&)>& holds)
      : store_(store), damaged_(damaged), progress_(progress), holds_(holds) {}

  VerifyReport run(std::size_t lanes) {
    checkWithoutBricks(kIndexFile, [&] { checkConstants(); });
    checkWithoutBricks(kManifestFile, [&] { checkManifest(); });
    forEachEntry([&](const BrickKey& key, const BrickEntry&) { total_ += has(key) ? 1 : 0; });
    for (int level = 0; level < store_.index().levels(); ++level) {
      const Extent3& lattice = store_.index().lattice(level);
      parallelInLanes(lanes, static_cast<std::size_t>(lattice.count()), [&](std::size_t, std::size_t i) {
        const BrickKey key{level, brickAt(lattice, static_cast<std::int64_t>(i))};
        if (has(key)) brick(key);
      });
    }
    noteStrangers();
    return report_;
  }

 private:
  bool has(const BrickKey& key) const { return !store_.index().at(key).constant && (!holds_ || holds_(key)); }

  template <class Check>
  void checkWithoutBricks(const char* file, Check&& check) {
    ++report_.files;
    try {
      check();
    } catch (const Error& error) {
      report(Error(ErrorCode::kDamaged, store_.path() / file, "", error.what()));
    }
  }

  void report(const Error& error) {
    ++report_.damaged;
    damaged_(error);
  }

  void checkConstants() const {
    forEachEntry([&](const BrickKey& key, const BrickEntry& entry) {
      if (!entry.constant) return;
      if (entry.core.lo == entry.core.hi && covers(key.level, entry.support, entry.core) && entry.file_bytes == 0)
        return;
      throw Error(ErrorCode::kDamaged, brickPath(key), "",
                  fmt::format("is constant, but has range {}, support {} and {} bytes{}", textOf(entry.core),
                              textOf(entry.support), entry.file_bytes, kRemedy));
    });
  }

  void checkManifest() const {
    const Manifest& manifest = store_.manifest();
    ValueRange range;
    std::vector<LevelInfo> found(manifest.levels.size());
    forEachEntry([&](const BrickKey& key, const BrickEntry& entry) {
      if (key.level == 0) range.include(entry.core);
      LevelInfo& level = found[static_cast<std::size_t>(key.level)];
      level.stored_bricks += entry.constant ? 0 : 1;
      level.stored_bytes += entry.file_bytes;
    });
    if (range != manifest.range)
      throw Error(ErrorCode::kDamaged, fmt::format("range: {}, but the bricks of the index have {}{}",
                                                   textOf(manifest.range), textOf(range), kRemedy));
    for (std::size_t l = 0; l < found.size(); ++l) {
      const LevelInfo& stored = manifest.levels[l];
      if (found[l].stored_bricks == stored.stored_bricks && found[l].stored_bytes == stored.stored_bytes) continue;
      throw Error(
          ErrorCode::kDamaged,
          fmt::format("levels[{}]: {} files of {} bytes, but the index has {} of {} bytes{}", l, stored.stored_bricks,
                      stored.stored_bytes, found[l].stored_bricks, found[l].stored_bytes, kRemedy));
    }
  }

  template <class F>
  void forEachEntry(F&& f) const {
    const BrickIndex& index = store_.index();
    index.forEachKey([&](const BrickKey& key) { f(key, index.at(key)); });
  }

  void brick(const BrickKey& key) {
    progress_.throwIfCancelled("verifying");
    std::optional<Error> found;
    try {
      const BrickBlock block = store_.read(key);
      checkRanges(block, store_.index().at(key));
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kReplaced) throw;
      found = error;
    }
    const std::scoped_lock lock(mutex_);
    ++report_.files;
    if (found) report(*found);
    progress_.advance("verifying", "bricks", ++done_, total_);
  }

  void checkRanges(const BrickBlock& block, const BrickEntry& entry) const {
    const int level = block.key.level;
    const auto contradict = [&](const std::string& place, const ValueRange& stored, const ValueRange& found) {
      throw Error(ErrorCode::kDamaged, store_.path() / brickPath(block.key), place,
                  fmt::format("has {}, expected {}{}", textOf(stored), textOf(found), kRemedy));
    };
    const BrickRanges own = rangesOf(block);
    for (std::size_t c = 0; c < own.cells.size(); ++c) {
      const ValueRange& stored = block.octree.cells()[c];
      if (!covers(level, stored, own.cells[c]))
        contradict(fmt::format("cell {} of the min-max octree", c), stored, own.cells[c]);
    }
    // At a coarser level the root of the octree, and so the index, also covers finer levels.
    const ValueRange& core = block.octree.at(block.octree.depth() - 1, 0, 0, 0);
    if (!covers(level, entry.core, core)) contradict("core range in the index", entry.core, core);
    if (!covers(level, entry.support, own.support) || !entry.support.contains(entry.core))
      contradict("support range in the index", entry.support, own.support);
    if (!entry.sub_ranges) return;
    const int along = entry.sub_ranges->along();
    const std::int64_t brick_size = store_.manifest().brick_size;
    const SubRanges found(along,
                          along == subBricksOf(brick_size)
                              ? own.sub_bricks
                              : subBrickRanges(block.voxels, block.type, block.extent, block.core, brick_size, along),
                          entry.support);
    for (std::size_t i = 0; i < found.count(); ++i) {
      const ValueRange stored = entry.sub_ranges->at(i, entry.support), expected = found.at(i, entry.support);
      if (stored != expected) contradict(fmt::format("range of sub-brick {} in the index", i), stored, expected);
    }
  }

  bool isOurs(const fs::path& file) const {
    if (file == kManifestFile || file == kIndexFile || (holds_ && file == kPartFile)) return true;
    const std::optional<BrickKey> key = brickKeyOf(file);
    return key && store_.index().contains(*key) && !store_.index().at(*key).constant;
  }

  void noteStrangers() {
    std::uint64_t strangers = 0;
    fs::path first;
    const auto look = [&](const fs::directory_entry& entry) {
      std::error_code unknown;
      if (entry.is_directory(unknown)) return Walk::kGoOn;
      const fs::path file = entry.path().lexically_relative(store_.path());
      if (!isOurs(file) && strangers++ == 0) first = entry.path();
      return Walk::kGoOn;
    };
    try {
      forEachEntryBelow(store_.path(), look);
    } catch (const Error& unreadable) {
      // A folder that cannot be listed is no error by itself: bricks are read by name.
      progress_.note(unreadable.what());
    }
    if (strangers == 1) progress_.note(first.string() + ": is no part of the store");
    if (strangers > 1)
      progress_.note(fmt::format("{}: and {} more are no part of the store", first.string(), strangers - 1));
  }

  const StoreReader& store_;
  const std::function<void(const Error&)>& damaged_;
  Progress& progress_;
  const std::function<bool(const BrickKey&)>& holds_;
  std::mutex mutex_;  // guards the members below
  VerifyReport report_;
  std::uint64_t done_ = 0, total_ = 0;
};

}  // namespace

VerifyReport verify(const StoreReader& store, std::uint64_t memory_bytes,
                    const std::function<void(const Error&)>& damaged, Progress& progress,
                    const std::function<bool(const BrickKey&)>& holds) {
  const std::uint64_t brick_bytes = store.largestReadBytes(), index_bytes = store.index().bytes();
  if (brick_bytes + index_bytes > memory_bytes)
    throw Error(ErrorCode::kBudget, store.path(), "--memory",
                fmt::format("{} is too little: checking one brick takes {}, and the index {}; give --memory {}",
                            formatBytes(memory_bytes), formatBytes(brick_bytes), formatBytes(index_bytes),
                            roundedUpBytes(brick_bytes + index_bytes)));
  const std::uint64_t lanes =
      std::min<std::uint64_t>((memory_bytes - index_bytes) / brick_bytes, ThreadLimit::active());
  return Verification(store, damaged, progress, holds).run(static_cast<std::size_t>(lanes));
}

}  // namespace kiln
