#include "convert/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <mutex>
#include <optional>

#include "base/parallel.h"
#include "convert/destination.h"
#include "convert/foreign_cache.h"
#include "convert/forward_window.h"
#include "convert/journal.h"
#include "convert/plan.h"
#include "convert/pyramid_builder.h"
#include "convert/value_counter.h"
#include "convert/write_behind.h"
#include "grid/pyramid.h"
#include "store/store_reader.h"
#include "store/store_writer.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

Manifest draftOf(const SourceInfo& info, const ConvertOptions& options) {
  Manifest manifest;
  manifest.type = info.type;
  manifest.background = info.background;
  manifest.volume_class = info.volume_class;
  manifest.brick_size = options.brick_size;
  for (const VolumeGeometry& geometry : pyramidOf(info.geometry, options.brick_size, options.most_levels)) {
    LevelInfo level;
    level.geometry = geometry;
    manifest.levels.push_back(level);
  }
  manifest.source.format = info.format;
  for (const fs::path& file : info.files) manifest.source.files.push_back(file.string());
  manifest.source.command = options.command;
  manifest.source.time = options.time;
  manifest.source.vdb = info.vdb;
  return manifest;
}

// What bricks are made of, as text: the same text gives the same bricks.
std::string identityOf(const SourceInfo& info, Manifest draft) {
  draft.source.command.clear();
  draft.source.time.clear();
  std::string out = containerVersion() + "\n";
  for (const fs::path& file : info.files) {
    std::error_code ignored;
    if (!fs::exists(file, ignored)) continue;
    out += fmt::format("{} {} {}\n", file.string(), fs::is_directory(file, ignored) ? 0 : fs::file_size(file, ignored),
                       fs::last_write_time(file, ignored).time_since_epoch().count());
  }
  return out + manifestText(draft);
}

// The lanes take bricks in the order of the lattice as they come free, and build the coarser bricks that a finished one
// makes possible.
class Conversion {
 public:
  Conversion(VolumeSource& source, StoreWriter& writer, const fs::path& directory, const JournalContent& earlier,
             const ConversionPlan& plan, bool half, FileSystem& disk, Progress& progress)
      : source_(source),
        writer_(writer),
        directory_(directory),
        progress_(progress),
        pyramid_(writer, directory / "parts", plan.parts_bytes, disk, half),
        boxes_(plan.lanes),
        counters_(plan.lanes, ValueCounter(source.info().type)),
        totals_(counters_),
        unwritten_bricks_(plan.unwritten_bricks) {
    if (plan.window_slices > 0) {
      const SourceInfo& info = source.info();
      window_.emplace(source,
                      plan.window_on_disk ? sliceRingOnDisk(info, plan.window_slices, directory, disk)
                                          : sliceRingInMemory(info, plan.window_slices),
                      writer.manifest().brick_size, progress);
    }
    for (const LevelInfo& level : writer.manifest().levels)
      finished_.emplace_back(static_cast<std::size_t>(level.bricks.count()));
    JournalContent kept{earlier.identity, wholeBricksOf(earlier)};
    journal_.emplace(directory, kept, disk);
  }

  void run() {
    WriteBehind disk(unwritten_bricks_, [this](const UnwrittenBrick& brick) { write(brick); });
    takeUp(disk);
    const Extent3 lattice = writer_.manifest().levels.front().bricks;
    std::atomic<std::int64_t> next = 0;
    parallelFor(counters_.size(), [&](std::size_t lane) {
      const auto convertBrick = [&](std::int64_t i) {
        if (!finished_[0][static_cast<std::size_t>(i)]) build(brick({0, brickAt(lattice, i)}, lane, disk), disk);
      };
      if (window_) return window_->work(convertBrick);
      for (std::int64_t i = next++; i < lattice.count(); i = next++) {
        progress_.throwIfCancelled("converting");
        convertBrick(i);
      }
    });
    disk.finish();
    source_.finish();
    for (std::size_t lane = 1; lane < totals_.size(); ++lane) totals_[0].add(totals_[lane].take());
  }

  const ValueCounter& counter() const { return totals_.front(); }
  double halfError() const { return pyramid_.largestError(); }
  std::uint64_t finishedBricks() const { return finished_bricks_; }

 private:
  // Of the bricks that an earlier conversion noted, those whose files are whole on the disk.
  std::vector<FinishedBrick> wholeBricksOf(const JournalContent& earlier) {
    std::vector<char> whole(earlier.bricks.size());
    parallelFor(earlier.bricks.size(), [&](std::size_t i) {
      progress_.throwIfCancelled("looking at what is finished");
      const FinishedBrick& brick = earlier.bricks[i];
      const fs::path path = directory_ / brickPath(brick.key);
      std::error_code ignored;
      whole[i] = brick.entry.constant || (fs::file_size(path, ignored) == brick.entry.file_bytes &&
                                          hashOf(readFile(path)) == brick.entry.checksum);
    });
    std::vector<FinishedBrick> out;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      const FinishedBrick& brick = earlier.bricks[i];
      if (!whole[i]) continue;
      char& finished = finished_[static_cast<std::size_t>(brick.key.level)][placeOf(brick.key)];
      if (std::exchange(finished, 1) != 0) continue;
      writer_.keep(brick.key, brick.entry);
      totals_[0].add(brick.counts);
      if (brick.key.level == 0) done_ += static_cast<std::uint64_t>(writer_.frame(brick.key).core().count());
      ++finished_bricks_;
      out.push_back(brick);
    }
    return out;
  }

  // The coarser levels go on from where the earlier conversion left them.
  void takeUp(WriteBehind& disk) {
    if (finished_bricks_ == 0) return;
    const std::vector<BrickKey> ready =
        pyramid_.takeUp([&](const BrickKey& key) { return isFinished(key); },
                        [&](const BrickKey& key) {
                          progress_.throwIfCancelled("taking up the coarser levels");
                          const BrickFrame frame = writer_.frame(key);
                          const fs::path path = directory_ / brickPath(key);
                          const BrickBlock block = decodeBrick(frame, readFile(path), path);
                          const BrickEntry& entry = writer_.entry(key);
                          const auto cells = block.octree.cells();
                          pyramid_.addFinished(key, block.voxels, block.extent,
                                               {{cells.begin(), cells.end()}, entry.core, entry.support, {}});
                        });
    build(ready, disk);
  }

  bool isFinished(const BrickKey& key) const {
    return finished_[static_cast<std::size_t>(key.level)][placeOf(key)] != 0;
  }

  std::size_t placeOf(const BrickKey& key) const {
    const Extent3& n = writer_.manifest().levels[static_cast<std::size_t>(key.level)].bricks;
    return static_cast<std::size_t>((key.brick.z * n.y + key.brick.y) * n.x + key.brick.x);
  }

  // Makes a brick of level 0; returns the coarser ones that can be built now.
  std::vector<BrickKey> brick(const BrickKey& key, std::size_t lane, WriteBehind& disk) {
    const BrickFrame frame = writer_.frame(key);
    const VoxelBox box = frame.stored();
    std::vector<std::byte>& voxels = boxes_[lane];
    voxels.resize(static_cast<std::size_t>(box.count()) * sizeOf(frame.type));
    if (window_) {
      window_->copy(box, voxels);
    } else {
      source_.read(box, voxels);
    }
    counters_[lane].count(voxels, box, frame.core());
    ValueCounts counts = counters_[lane].take();
    totals_[lane].add(counts);
    const BrickRanges ranges = rangesOf(frame, voxels);
    disk.add({writer_.encode(key, voxels, ranges), std::move(counts)});
    return pyramid_.add(key, voxels, box, ranges);
  }

  // A brick is finished when its file is there and its journal says so.
  void write(const UnwrittenBrick& unwritten) {
    const auto& [brick, counts] = unwritten;
    writer_.write(brick);
    journal_->append({brick.key, brick.entry, counts});
    const std::scoped_lock lock(mutex_);
    ++finished_bricks_;
    if (brick.key.level > 0) return;
    done_ += static_cast<std::uint64_t>(writer_.frame(brick.key).core().count());
    progress_.advance("converting", "voxels", done_, static_cast<std::uint64_t>(source_.info().geometry.dims.count()));
  }

  void build(std::vector<BrickKey> ready, WriteBehind& disk) {
    while (!ready.empty()) {
      progress_.throwIfCancelled("converting");
      const BrickKey key = ready.back();
      ready.pop_back();
      // Where only a brick below it was damaged, a coarser one is finished already.
      if (isFinished(key)) continue;
      PyramidBuilder::Built built = pyramid_.build(key);
      disk.add({std::move(built.brick), {}});
      ready.insert(ready.end(), built.ready.begin(), built.ready.end());
    }
  }

  VolumeSource& source_;
  StoreWriter& writer_;
  const fs::path directory_;
  Progress& progress_;
  PyramidBuilder pyramid_;
  std::optional<ForwardWindow> window_;
  std::vector<std::vector<std::byte>> boxes_;    // by lane, for its brick of level 0: one memory for all
  std::vector<ValueCounter> counters_, totals_;  // of a brick, and of all; by lane
  std::vector<std::vector<char>> finished_;      // by level and brick: what an earlier conversion left
  const std::size_t unwritten_bricks_;
  std::optional<Journal> journal_;
  std::mutex mutex_;
  std::uint64_t done_ = 0, finished_bricks_ = 0;
};

std::uint64_t brickCount(const Manifest& manifest) {
  std::uint64_t out = 0;
  for (const LevelInfo& level : manifest.levels) out += static_cast<std::uint64_t>(level.bricks.count());
  return out;
}

// Whether the finished bricks are worth keeping: the same conversion may succeed later.
bool mayBeResumed(ErrorCode code) {
  return code == ErrorCode::kCancelled || code == ErrorCode::kNoSpace || code == ErrorCode::kIo;
}

// What an interrupted conversion of the same volume left, where there is any; anything else that it left is cleared.
std::optional<JournalContent> resumable(Destination& destination, const SourceInfo& info, const Manifest& draft,
                                        const ConvertOptions& options) {
  std::optional<JournalContent> found = Journal::read(destination.building());
  if (found && found->identity.volume != identityOf(info, draft)) {
    if (!options.overwrite) {
      throw Error(ErrorCode::kExists, destination.building(), "",
                  "was begun from another source, an older state of it, or with other options; give --overwrite to "
                  "begin anew");
    }
    found.reset();
  }
  if (!found) destination.clear();
  return found;
}

// The last byte was written before; the store may still have to take its name, and the journal may lie there.
void finishEarlier(Destination& destination, const fs::path& out, const SourceInfo& info, Progress& progress,
                   ConvertReport& report) {
  const fs::path& store = destination.building();
  if (!isStoreOf(store, info))
    throw Error(ErrorCode::kExists, store, "",
                "is a store of another volume, or older than its source; give --overwrite");
  const StoreReader reader(store);
  destination.commit();
  progress.note(out.string() + " is finished already");
  report.bricks = brickCount(reader.manifest());
  for (const LevelInfo& level : reader.manifest().levels) {
    report.stored_bricks += level.stored_bricks;
    report.stored_bytes += level.stored_bytes;
  }
  report.nan_count = reader.manifest().nan_count;
}

void run(VolumeSource& source, const Manifest& draft, const JournalContent& earlier, const ConversionPlan& plan,
         Destination& destination, const ConvertOptions& options, Progress& progress, FileSystem& disk,
         ConvertReport& report) {
  std::optional<StoreWriter> begun;
  std::optional<Conversion> conversion;
  try {
    StoreWriter& writer = begun.emplace(destination.building(), draft, disk);
    conversion.emplace(source, writer, destination.building(), earlier, plan, options.half, disk, progress);
    report.bricks = brickCount(writer.manifest());
    if (conversion->finishedBricks() > 0) {
      progress.note(fmt::format("{} of {} bricks are finished already", conversion->finishedBricks(), report.bricks));
    }
    const double share = 1 - static_cast<double>(conversion->finishedBricks()) / static_cast<double>(report.bricks);
    conversion->run();
    writer.finish(conversion->counter().histogram(writer.range()), conversion->counter().nanCount());
    report.stored_bricks = writer.storedBricks();
    report.stored_bytes = writer.bytesWritten();
    report.voxels = static_cast<std::uint64_t>(share * static_cast<double>(draft.geometry().dims.count()));
    report.nan_count = conversion->counter().nanCount();
    report.half_error = conversion->halfError();
    conversion.reset();
    destination.commit();
  } catch (const Error& error) {
    const std::uint64_t finished = conversion ? conversion->finishedBricks() : report.stored_bricks;
    conversion.reset();
    if (finished == 0 || !mayBeResumed(error.code())) {
      destination.abandon();
      throw;
    }
    destination.keepForResuming();
    progress.note(fmt::format("{} of {} bricks are kept in {}; {} to go on from there", finished,
                              brickCount(begun->manifest()), destination.building().string(),
                              options.overwrite && options.resume ? "run again" : "run again with --resume"));
    throw;
  } catch (...) {
    conversion.reset();
    destination.abandon();
    throw;
  }
}

}  // namespace

ConvertReport convert(VolumeSource& source, const fs::path& out, const ConvertOptions& options, Progress& progress,
                      FileSystem& disk) {
  const auto begin = std::chrono::steady_clock::now();
  if (options.brick_size < kCellSize || options.brick_size > (1 << 12) ||
      !std::has_single_bit(static_cast<std::uint64_t>(options.brick_size))) {
    throw Error(ErrorCode::kUsage,
                "--brick-size: " + std::to_string(options.brick_size) + " is not a power of two from 8 to 4096");
  }
  const SourceInfo& info = source.info();
  for (const std::string& note : info.notes) progress.note(note);
  const ConversionPlan plan = planConversion(source, options);
  source.keepDecoded(plan.kept_bytes);
  ConvertReport report;
  Destination destination(out, options.overwrite, options.resume, disk);
  Manifest draft = draftOf(info, options);
  JournalContent earlier;
  if (destination.finished()) {
    finishEarlier(destination, out, info, progress, report);
  } else {
    if (options.resume) {
      if (std::optional<JournalContent> found = resumable(destination, info, draft, options))
        earlier = *std::move(found);
    }
    if (earlier.identity.volume.empty()) {
      earlier.identity = {identityOf(info, draft), options.command, options.time};
    } else {
      draft.source.command = earlier.identity.command;
      draft.source.time = earlier.identity.time;
    }
    run(source, draft, earlier, plan, destination, options, progress, disk, report);
  }
  report.buffer_bytes = plan.total();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report;
}

}  // namespace kiln
