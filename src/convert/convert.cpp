#include "convert/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <chrono>
#include <mutex>
#include <optional>

#include "base/memory.h"
#include "base/parallel.h"
#include "convert/slab_window.h"
#include "convert/value_counter.h"
#include "store/store_writer.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// How the memory is used: one window of slices where the source is a stream, and a lane of buffers a thread; a source
// that decodes more than it is asked for may keep that in what is left.
struct Plan {
  std::uint64_t window_bytes = 0;
  std::uint64_t lane_bytes = 0;
  std::size_t lanes = 1;
  std::uint64_t kept_bytes = 0;
  std::uint64_t total() const { return window_bytes + lanes * lane_bytes + kept_bytes; }
};

Plan planMemory(const VolumeSource& source, const ConvertOptions& options) {
  const SourceInfo& info = source.info();
  Plan plan;
  const std::int64_t padded = options.brick_size + 2 * kApron;
  if (source.order() == ReadOrder::kForwardSlices) plan.window_bytes = SlabWindow::bytesFor(info, padded);
  const Extent3& dims = info.geometry.dims;
  const auto voxels =
      static_cast<std::uint64_t>(std::min(padded, dims.x) * std::min(padded, dims.y) * std::min(padded, dims.z));
  // A lane holds the box as read, its grids (8 bytes a voxel at most), the file, and the counts by value.
  const std::uint64_t grid_bytes = sizeOf(info.type) < 4 ? 4 : 8;
  plan.lane_bytes = voxels * (2 * sizeOf(info.type) + 2 * grid_bytes) + (1u << 20) + source.decodeBytes();
  const std::uint64_t smallest = plan.window_bytes + plan.lane_bytes;
  if (smallest > options.memory_bytes) {
    throw Error(ErrorCode::kBudget, info.files.empty() ? fs::path() : info.files.front(), "--memory",
                fmt::format("{} is too little: {} is the smallest that works here ({} of slices, {} a thread)",
                            formatBytes(options.memory_bytes), formatBytes(smallest), formatBytes(plan.window_bytes),
                            formatBytes(plan.lane_bytes)));
  }
  const std::uint64_t fitting = (options.memory_bytes - plan.window_bytes) / plan.lane_bytes;
  plan.lanes = static_cast<std::size_t>(std::min<std::uint64_t>(fitting, ThreadLimit::active()));
  if (source.decodeBytes() > 0) {
    const std::uint64_t volume_bytes = static_cast<std::uint64_t>(dims.count()) * sizeOf(info.type);
    plan.kept_bytes = std::min(options.memory_bytes - plan.total(), volume_bytes);
  }
  return plan;
}

Manifest draftOf(const SourceInfo& info, const ConvertOptions& options) {
  Manifest manifest;
  manifest.type = info.type;
  manifest.background = info.background;
  manifest.volume_class = info.volume_class;
  manifest.brick_size = options.brick_size;
  LevelInfo level;
  level.geometry = info.geometry;
  manifest.levels.push_back(level);
  manifest.source.format = info.format;
  for (const fs::path& file : info.files) manifest.source.files.push_back(file.string());
  manifest.source.command = options.command;
  manifest.source.time = options.time;
  manifest.source.vdb = info.vdb;
  return manifest;
}

// Converts one layer of bricks after the other; within a layer the lanes take bricks as they come free.
class Conversion {
 public:
  Conversion(VolumeSource& source, StoreWriter& writer, const Plan& plan, Progress& progress)
      : source_(source), writer_(writer), progress_(progress), counters_(plan.lanes, ValueCounter(source.info().type)) {
    if (source.order() == ReadOrder::kForwardSlices) window_.emplace(source);
  }

  void run(const Extent3& lattice) {
    const std::int64_t in_layer = lattice.x * lattice.y;
    for (std::int64_t z = 0; z < lattice.z; ++z) {
      const std::int64_t first = z * in_layer, end = first + in_layer;
      if (window_) {
        const VoxelBox layer = writer_.frame({0, brickAt(lattice, first)}).stored();
        window_->advance(layer.lo.z, layer.hi.z);
      }
      std::atomic<std::int64_t> next = first;
      parallelFor(counters_.size(), [&](std::size_t lane) {
        for (std::int64_t i = next++; i < end; i = next++) {
          progress_.throwIfCancelled("converting");
          brick({0, brickAt(lattice, i)}, counters_[lane]);
        }
      });
    }
    source_.finish();
    for (std::size_t lane = 1; lane < counters_.size(); ++lane) counters_[0].add(counters_[lane]);
  }

  const ValueCounter& counter() const { return counters_.front(); }

 private:
  void brick(const BrickKey& key, ValueCounter& counter) {
    const BrickFrame frame = writer_.frame(key);
    const VoxelBox box = frame.stored();
    std::vector<std::byte> voxels(static_cast<std::size_t>(box.count()) * sizeOf(frame.type));
    if (window_) {
      window_->copy(box, voxels);
    } else {
      source_.read(box, voxels);
    }
    counter.count(voxels, box, frame.core());
    writer_.put(key, voxels);
    const std::scoped_lock lock(mutex_);
    done_ += static_cast<std::uint64_t>(frame.core().count());
    progress_.advance("converting", "voxels", done_, static_cast<std::uint64_t>(source_.info().geometry.dims.count()));
  }

  VolumeSource& source_;
  StoreWriter& writer_;
  Progress& progress_;
  std::optional<SlabWindow> window_;
  std::vector<ValueCounter> counters_;
  std::mutex mutex_;
  std::uint64_t done_ = 0;
};

// True for a directory that holds nothing but what a store, finished or not, holds: what --overwrite may replace.
bool mayReplace(const fs::path& directory) {
  std::error_code error;
  if (!fs::is_directory(directory, error)) return false;
  for (const auto& entry : fs::directory_iterator(directory, error)) {
    const std::string name = entry.path().filename().string();
    if (name != "manifest.json" && name != "index.bin" && name != "bricks" && !name.ends_with(".tmp")) return false;
  }
  return !error;
}

// Where the new store is built, and how it comes to stand at `out`.
class Destination {
 public:
  Destination(const fs::path& out, bool overwrite, FileSystem& disk) : out_(out), building_(out), disk_(disk) {
    std::error_code ignored;
    if (!fs::exists(fs::symlink_status(out, ignored)) || (fs::is_directory(out, ignored) && fs::is_empty(out, ignored)))
      return;
    if (!overwrite)
      throw Error(ErrorCode::kExists, out, "", "is there already; name another output or give --overwrite");
    if (!mayReplace(out))
      throw Error(ErrorCode::kExists, out, "",
                  "is not a store, so --overwrite does not replace it; name another output");
    building_ += ".partial";
    if (!fs::exists(building_, ignored)) return;
    if (!mayReplace(building_))
      throw Error(ErrorCode::kExists, building_, "", "is in the way and is not an unfinished store; move it");
    disk_.removeAll(building_);
  }

  const fs::path& building() const { return building_; }

  void commit() {
    if (building_ == out_) return;
    const fs::path old = out_.string() + ".old";
    disk_.removeAll(old);
    disk_.rename(out_, old);
    try {
      disk_.rename(building_, out_);
      // Both names must be on the disk before the old store goes.
      disk_.syncAll(out_);
    } catch (...) {
      std::error_code ignored;
      if (!fs::exists(building_, ignored)) fs::rename(out_, building_, ignored);
      fs::rename(old, out_, ignored);
      throw;
    }
    try {
      disk_.removeAll(old);
    } catch (const Error&) {
      // The new store is in place and that is what was asked for; the next --overwrite removes what is left of the old.
    }
  }
  void abandon() noexcept {
    std::error_code ignored;
    fs::remove_all(building_, ignored);
  }

 private:
  fs::path out_, building_;
  FileSystem& disk_;
};

fs::path withoutTrailingSlash(const fs::path& path) { return path.has_filename() ? path : path.parent_path(); }

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
  const Plan plan = planMemory(source, options);
  source.keepDecoded(plan.kept_bytes);
  Destination destination(withoutTrailingSlash(out), options.overwrite, disk);
  ConvertReport report;
  std::optional<StoreWriter> begun;
  try {
    StoreWriter& writer = begun.emplace(destination.building(), draftOf(info, options), disk);
    Conversion conversion(source, writer, plan, progress);
    const Extent3 lattice = brickLattice(info.geometry.dims, options.brick_size);
    conversion.run(lattice);
    writer.finish(conversion.counter().histogram(writer.range()), conversion.counter().nanCount());
    destination.commit();
    report.bricks = static_cast<std::uint64_t>(lattice.count());
    report.stored_bricks = writer.storedBricks();
    report.stored_bytes = writer.bytesWritten();
    report.nan_count = conversion.counter().nanCount();
  } catch (...) {
    // What this conversion did not begin is not its to remove.
    if (begun) destination.abandon();
    throw;
  }
  report.voxels = static_cast<std::uint64_t>(info.geometry.dims.count());
  report.source_bytes = report.voxels * sizeOf(info.type);
  report.buffer_bytes = plan.total();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report;
}

}  // namespace kiln
