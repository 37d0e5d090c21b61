#include "convert/conversion.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/byte_record.h"
#include "base/elapsed.h"
#include "base/thread/parallel.h"
#include "convert/resume/earlier_bricks.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;

// Returns a folder per process, because each process clears the folder.
fs::path partsFolder(const fs::path& directory, const Ranks& ranks) {
  return ranks.alone() ? directory / "parts" : directory / "parts" / std::to_string(ranks.rank());
}

std::unique_ptr<SliceRing> ringFor(const Conversion::Parts& parts) {
  const SourceInfo& info = parts.source.info();
  const std::int64_t slices = parts.plan.window_slices;
  return parts.plan.window_on_disk ? sliceRingOnDisk(info, slices, parts.directory, parts.disk)
                                   : sliceRingInMemory(info, slices);
}

}  // namespace

Conversion::Conversion(const Parts& parts, const ConversionIdentity& identity, bool resumes)
    : parts_(parts),
      writer_(parts.writer),
      ranks_(parts.ranks),
      progress_(parts.progress),
      pyramid_(parts.writer, partsFolder(parts.directory, parts.ranks), parts.plan.parts_bytes, parts.disk, parts.half,
               {parts.ranks.rank(), parts.ranks.count(),
                [this](int to, const BrickKey& key, const HalfBrick* piece) {
                  exchange_->give(to, key, writer_.wholeEntry(key), piece);
                }}),
      boxes_(parts.plan.lanes),
      counters_(parts.plan.lanes,
                ValueCounter(parts.source.info().type, parts.writer.manifest().volume_class == VolumeClass::kLabels)),
      of_brick_(counters_) {
  for (const LevelInfo& level : writer_.manifest().levels)
    finished_.emplace_back(static_cast<std::size_t>(level.bricks.count()));
  left_to_build_ = pyramid_.ownBricks();
  if (resumes)
    forEachWholeBrick(parts.directory, ranks_, progress_, [&](const FinishedBrick& brick) { adoptFinished(brick); });
  known_ = finished_;
  if (ranks_.first()) openJournal(identity);
  const bool in_order = parts.plan.window_slices > 0;
  shares_.emplace(ranks_, bricksToMake(in_order), writer_.manifest().brick_size, in_order);
  if (in_order)
    window_.emplace(
        parts.source, ringFor(parts), writer_.manifest().brick_size, [this] { return shares_->next(); }, progress_);
}

// Keeps a whole brick of an earlier conversion. A journal may contain a brick twice, or bricks outside the volume.
void Conversion::adoptFinished(const FinishedBrick& brick) {
  if (!writer_.contains(brick.key)) return;
  if (std::exchange(finished_[static_cast<std::size_t>(brick.key.level)][placeOf(brick.key)], 1) != 0) return;
  writer_.keep(brick.key, brick.entry);
  if (brick.key.level > 0 && pyramid_.owns(brick.key)) --left_to_build_;
  if (brick.key.level == 0) done_ += static_cast<std::uint64_t>(writer_.frame(brick.key).core().count());
  ++finished_bricks_;
}

// Opens the journal: copies the records of the kept bricks, and counts their values.
void Conversion::openJournal(const ConversionIdentity& identity) {
  std::vector<std::vector<char>> due = finished_;
  journal_.emplace(
      parts_.directory, identity,
      [&](const FinishedBrick& brick) {
        if (!writer_.contains(brick.key) ||
            std::exchange(due[static_cast<std::size_t>(brick.key.level)][placeOf(brick.key)], 0) == 0)
          return false;
        counters_[0].add(brick.counts);
        return true;
      },
      parts_.disk);
}

// Lists the bricks in the order of the plan: all bricks of a stream, finished or not: the stream must be read to the
// end to compare the checksum.
std::vector<std::int64_t> Conversion::bricksToMake(bool in_order) const {
  std::vector<std::int64_t> out;
  out.reserve(finished_[0].size());
  for (std::size_t i = 0; i < finished_[0].size(); ++i) {
    if (in_order || !finished_[0][i]) out.push_back(static_cast<std::int64_t>(i));
  }
  const BrickOrder& order = *parts_.plan.order;
  if (order.isLayers()) return out;
  const Extent3& lattice = writer_.manifest().levels.front().bricks;
  const auto time = [&](std::int64_t i) { return order.timeOf(brickAt(lattice, i)); };
  std::sort(out.begin(), out.end(), [&](std::int64_t a, std::int64_t b) { return time(a) < time(b); });
  return out;
}

bool Conversion::isFinished(const BrickKey& key) const {
  return finished_[static_cast<std::size_t>(key.level)][placeOf(key)] != 0;
}

std::size_t Conversion::placeOf(const BrickKey& key) const {
  return kiln::placeOf(writer_.manifest().levels[static_cast<std::size_t>(key.level)].bricks, key.brick);
}

void Conversion::run() {
  began_ = Clock::now();
  WriteBehind disk(parts_.plan.unwritten_bricks, [this](const UnwrittenBrick& brick) { write(brick); });
  resumePyramid();
  startExchange();
  parallelFor(counters_.size(), [&](std::size_t lane) { work(lane, disk); });
  disk.finish();
  if (!window_ || window_->readAll()) parts_.source.finish();
  for (std::size_t lane = 1; lane < counters_.size(); ++lane) counters_[0].add(counters_[lane].take());
  report_.lanes = counters_.size();
  if (window_) waited_s_ += window_->waitedSeconds();
  report_.busy_s = std::max(secondsSince(began_) * static_cast<double>(report_.lanes) - waited_s_, 0.0);
  collectResults();
}

// Resumes the coarser levels where the earlier conversion stopped.
void Conversion::resumePyramid() {
  if (finished_bricks_ == 0) return;
  addReady(pyramid_.resume([&](const BrickKey& key) { return isFinished(key); },
                           [&](const BrickKey& key) {
                             progress_.throwIfCancelled("taking up the coarser levels");
                             const fs::path path = parts_.directory / brickPath(key);
                             const BrickBlock block = decodeBrick(writer_.frame(key), readFile(path), path);
                             const BrickEntry& entry = writer_.entry(key);
                             const auto cells = block.octree.cells();
                             pyramid_.addFinished(key, block.voxels, block.extent,
                                                  {{cells.begin(), cells.end()}, entry.core, entry.support, {}});
                           }));
}

// Starts the exchange of pieces, after resumePyramid, which earlier arrivals would disturb.
void Conversion::startExchange() {
  if (ranks_.alone()) return;
  exchange_.emplace(ranks_, parts_.plan.given_bytes,
                    RankExchange::Handlers{[this](const FinishedBrick& brick, std::optional<HalfBrick> piece) {
                                             known_[static_cast<std::size_t>(brick.key.level)][placeOf(brick.key)] = 1;
                                             addReady(pyramid_.addGiven(brick.key, brick.entry, std::move(piece)));
                                           },
                                           [this](const FinishedBrick& brick) { onRemoteBrick(brick); }});
}

void Conversion::work(std::size_t lane, WriteBehind& disk) {
  try {
    if (window_) {
      window_->work([&](std::int64_t i) { makeBrick(i, lane, disk); });
    } else {
      for (std::optional<std::int64_t> i = shares_->next(); i; i = shares_->next()) makeBrick(*i, lane, disk);
    }
    buildRest(disk);
  } catch (...) {
    {
      const std::scoped_lock lock(mutex_);
      failed_ = true;
    }
    changed_.notify_all();
    throw;
  }
}

void Conversion::throwIfStopped() {
  progress_.throwIfCancelled("converting");
  if (exchange_) exchange_->throwIfFailed();
}

void Conversion::makeBrick(std::int64_t i, std::size_t lane, WriteBehind& disk) {
  throwIfStopped();
  const BrickKey key{0, brickAt(writer_.manifest().levels.front().bricks, i)};
  if (!isFinished(key)) addReady(brick(key, lane, disk));
  buildReady(disk);
}

// Makes a brick of level 0; returns the coarser bricks that can now be built.
std::vector<BrickKey> Conversion::brick(const BrickKey& key, std::size_t lane, WriteBehind& disk) {
  const BrickDesc frame = writer_.frame(key);
  const VoxelBox box = frame.stored();
  std::vector<std::byte>& voxels = boxes_[lane];
  voxels.resize(static_cast<std::size_t>(box.count()) * sizeOf(frame.type));
  if (window_) {
    window_->copy(box, voxels);
  } else {
    parts_.source.read(box, voxels);
  }
  of_brick_[lane].count(voxels, box, frame.core());
  ValueCounts counts = of_brick_[lane].take();
  counters_[lane].add(counts);
  const BrickRanges ranges = rangesOf(frame, voxels);
  disk.add({writer_.encode(key, voxels, ranges), std::move(counts)});
  {
    const std::scoped_lock lock(mutex_);
    report_.read_bytes += voxels.size();
  }
  return pyramid_.add(key, voxels, box, ranges);
}

void Conversion::addReady(const std::vector<BrickKey>& ready) {
  if (ready.empty()) return;
  {
    const std::scoped_lock lock(mutex_);
    ready_.insert(ready_.end(), ready.begin(), ready.end());
  }
  changed_.notify_all();
}

std::optional<BrickKey> Conversion::takeReady() {
  const std::scoped_lock lock(mutex_);
  if (ready_.empty()) return std::nullopt;
  const BrickKey key = ready_.back();
  ready_.pop_back();
  return key;
}

void Conversion::build(const BrickKey& key, WriteBehind& disk) {
  throwIfStopped();
  // Finished already, if a previous run lost only a brick below.
  if (isFinished(key)) return;
  PyramidBuilder::Built built = pyramid_.build(key);
  disk.add({std::move(built.brick), {}});
  addReady(built.ready);
  {
    const std::scoped_lock lock(mutex_);
    --left_to_build_;
  }
  changed_.notify_all();
}

void Conversion::buildReady(WriteBehind& disk) {
  while (const std::optional<BrickKey> key = takeReady()) build(*key, disk);
}

// Builds the remaining bricks, waiting for the bricks of lanes and ranks still at work.
void Conversion::buildRest(WriteBehind& disk) {
  constexpr auto kLook = std::chrono::milliseconds(100);
  while (true) {
    buildReady(disk);
    throwIfStopped();
    std::unique_lock lock(mutex_);
    if (left_to_build_ == 0 || failed_) return;
    const auto begin = Clock::now();
    changed_.wait_for(lock, kLook, [&] { return !ready_.empty() || left_to_build_ == 0 || failed_; });
    waited_s_ += secondsSince(begin);
  }
}

// A brick is finished when its file is written and the journal has its record.
void Conversion::write(const UnwrittenBrick& unwritten) {
  const auto& [brick, counts] = unwritten;
  writer_.write(brick);
  FinishedBrick finished{brick.key, brick.entry, counts};
  {
    const std::scoped_lock lock(mutex_);
    ++report_.bricks;
    report_.written_bytes += brick.entry.file_bytes;
  }
  if (ranks_.first())
    noteFinished(finished);
  else
    exchange_->sendFinished(finished);
}

void Conversion::noteFinished(const FinishedBrick& brick) {
  journal_->append(brick);
  const std::scoped_lock lock(mutex_);
  ++finished_bricks_;
  if (brick.key.level > 0) return;
  done_ += static_cast<std::uint64_t>(writer_.frame(brick.key).core().count());
  progress_.advance("converting", "voxels", done_,
                    static_cast<std::uint64_t>(parts_.source.info().geometry.dims.count()));
}

void Conversion::onRemoteBrick(const FinishedBrick& brick) {
  // An entry that came with a piece is being read by the builder of the parent.
  if (std::exchange(known_[static_cast<std::size_t>(brick.key.level)][placeOf(brick.key)], 1) == 0)
    writer_.keep(brick.key, brick.entry);
  noteFinished(brick);
}

// Collects the results of all ranks. The bricks of a rank must be on its disk before the first rank finishes the store.
void Conversion::collectResults() {
  half_error_ = pyramid_.largestError();
  if (exchange_ && !ranks_.first()) {
    parts_.disk.syncAll(parts_.directory);
    report_.sent_bytes = ranks_.traffic().sent_bytes;
    std::vector<std::byte> results;
    appendValue(results, half_error_);
    appendValue(results, report_);
    // encoded as a record without a brick
    const std::vector<std::byte> counts = bytesOf(FinishedBrick{{}, {}, counters_[0].take()});
    results.insert(results.end(), counts.begin(), counts.end());
    exchange_->sendResults(results);
    return;
  }
  const std::vector<std::vector<std::byte>> all =
      exchange_ ? exchange_->awaitResults() : std::vector<std::vector<std::byte>>(1);
  report_.sent_bytes = ranks_.traffic().sent_bytes;
  reports_ = {report_};
  for (std::size_t rank = 1; rank < all.size(); ++rank) {
    ByteTaker taker{all[rank]};
    half_error_ = std::max(half_error_, taker.take<double>());
    reports_.push_back(taker.take<RankConversion>());
    if (const std::optional<FinishedBrick> counts = finishedBrickFrom(taker.left)) counters_[0].add(counts->counts);
  }
  // Ranks that finish early wait for the last rank.
  for (RankConversion& rank : reports_)
    rank.idle_s = std::max(static_cast<double>(rank.lanes) * secondsSince(began_) - rank.busy_s, 0.0);
}

}  // namespace kiln
