#include "sequence/shared_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>
#include <utility>

#include "base/elapsed.h"
#include "cluster/shared_lists.h"
#include "cluster/work_ranges.h"
#include "frame/pass/aov_planes.h"
#include "frame/pass/frame_progress.h"
#include "job/job_facts.h"
#include "sequence/brick_sequence.h"
#include "sequence/ranked_sequence.h"
#include "sequence/tile_image.h"
#include "sequence/tile_plan.h"

namespace kiln {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kTileTag = 1, kShareTag = 2, kFrameTag = 3;

// A frame that this rank assembles.
struct Assembly {
  Image image;
  std::size_t tiles = 0;
  int shares = 0;
  FrameReport report;
};

class SharedSequence : public RankedSequence {
 public:
  SharedSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress, SequenceListener& listener)
      : RankedSequence(job, options, sharedStores(job, options), progress, listener, std::nullopt,
                       job.share_reads && !isSeries(job)),
        crop_(drawnPixels(job.picture.size, job.picture.crop)) {}

 private:
  const char* sharedBy() const override { return split_.wholeFrames() ? "frames" : "tiles"; }

  // Rank 0 plans for all ranks.
  void makePlan() {
    if (ranks_.first()) {
      const bool by_frames = job_.distribution == Distribution::kFrames || viewWithoutTiles(job_) != nullptr ||
                             (isSeries(job_) && toDraw().size() > 1);
      if (!by_frames) planTilesOfVolume();
    }
    broadcastList(ranks_, split_.tiles);
    broadcastList(ranks_, split_.bounds);
    broadcastList(ranks_, split_.homes);
    if (shared_reads_) shared_reads_->settle(split_.homes);
  }

  // The frames have one volume. A frame of a series that cannot be opened is handed out whole, and fails when drawn.
  void planTilesOfVolume() {
    try {
      split_ = planTiles(frames_.openedFor(toDraw().front()), toDraw(), ranks_.count(), job_.distribution);
    } catch (const Error& error) {
      if (single() || !isSeries(job_) || error.code() == ErrorCode::kCancelled) throw;
    }
  }

  void share() override {
    makePlan();
    const std::size_t ranks = static_cast<std::size_t>(ranks_.count());
    counters_ = ranks_.makeCounters(1 + ranks * (split_.wholeFrames() ? 1 : toDraw().size()));
    ranks_.barrier();
    begin_ = Clock::now();
    if (split_.wholeFrames())
      drawFrames();
    else
      for (std::uint32_t i = 0; i < toDraw().size(); ++i) drawTilesOf(i);
    while (!allDone()) serveOrWait();
    own_.busy_s = secondsSince(begin_) - own_.idle_s;
    ranks_.barrier();
    // Tiles of a frame that failed: their senders wait until all are received.
    while (serve()) {
    }
    counters_.reset();
  }

  // Rank 0 has reports of all frames; other ranks read the shared counter.
  bool allDone() { return ranks_.first() ? recorded_ == toDraw().size() : counters_->add(0, 0) == toDraw().size(); }

  void drawFrames() {
    const auto ranks = static_cast<std::size_t>(ranks_.count());
    WorkRanges work(*counters_, 1, WorkRanges::evenBounds(toDraw().size(), ranks),
                    static_cast<std::size_t>(ranks_.rank()));
    while (const auto units = work.take(1)) {
      const std::uint32_t i = units->begin;
      FrameReport report;
      report.frame = i;
      attempt(report, [&] {
        requirePlaces(job_, toDraw()[i]);
        OpenedJob& opened = frames_.openedFor(toDraw()[i]);
        started(i);
        DrawnFrame drawn = opened.draw(toDraw()[i], progress_);
        own_.add(drawn.statistics);
        ++own_.tiles;
        write(opened, i, drawn);
        report.statistics = std::move(drawn.statistics);
      });
      sendReport(std::move(report));
      serve();
    }
  }

  void sendReport(FrameReport report) {
    counters_->add(0, 1);
    report.statistics.contributing.clear();
    ranks_.send(0, kFrameTag, packed(report));
  }

  int ownerOf(std::uint32_t frame) const { return static_cast<int>(frame % static_cast<unsigned>(ranks_.count())); }

  void drawTilesOf(std::uint32_t i) {
    // At most one earlier frame may be unfinished, because each unfinished frame holds an image.
    while (counters_->add(0, 0) + 1 < i) serveOrWait();
    begun_[i] = Clock::now();
    started(i);
    const auto ranks = static_cast<std::size_t>(ranks_.count());
    WorkRanges work(*counters_, 1 + i * ranks, split_.bounds, static_cast<std::size_t>(ranks_.rank()),
                    TilePlan::kSpared);
    FrameReport report;
    report.frame = i;
    attempt(report, [&] {
      if (ownerOf(i) == ranks_.rank()) requirePlaces(job_, toDraw()[i]);
      drawTiles(i, work, report.statistics);
    });
    if (report.failure) work.drop();
    own_.add(report.statistics);
    ranks_.send(ownerOf(i), kShareTag, packed(report));
    serve();
  }

  void drawTiles(std::uint32_t i, WorkRanges& work, FrameStatistics& statistics) {
    OpenedJob& opened = frames_.openedFor(toDraw()[i]);
    const FrameScene scene = opened.sceneAt(toDraw()[i]);
    UncountedProgress of_tiles(progress_);
    std::unique_ptr<FramePainter> painter;
    while (const auto units = work.take(1)) {
      if (ranks_.first()) showTiles(toDraw()[i], work);
      if (!painter) painter = opened.painterFor(scene, of_tiles);
      const PixelRect& tile = split_.tiles[units->begin];
      std::vector<std::byte> message;
      appendValue(message, i);
      appendTile(message, tile, painter->draw(tile));
      ranks_.send(ownerOf(i), kTileTag, std::move(message));
      ++own_.tiles;
      serve();
    }
    if (painter) statistics = opened.finish(*painter, toDraw()[i]);
  }

  // Reports progress over all ranks: tiles handed out, less one tile per rank in progress.
  void showTiles(int frame, WorkRanges& work) {
    const std::uint64_t given = work.handedOut(), drawing = static_cast<std::uint64_t>(ranks_.count());
    progress_.advance(stepOfFrame(frame).c_str(), "tiles", given - std::min(given, drawing), split_.tiles.size());
  }

  // Handles messages of other ranks. Returns true if there was a message.
  bool serve() {
    bool any = false;
    while (auto message = ranks_.poll(kTileTag)) {
      any = true;
      putTogether(message->bytes);
    }
    while (auto message = ranks_.poll(kShareTag)) {
      any = true;
      FrameReport share = reportFrom(message->bytes);
      Assembly& frame = assemblies_[share.frame];
      frame.report.statistics.merge(share.statistics);
      if (share.failure && !frame.report.failure) frame.report.failure = std::move(share.failure);
      ++frame.shares;
      completed(share.frame);
    }
    while (auto message = ranks_.poll(kFrameTag)) {
      any = true;
      record(reportFrom(message->bytes));
    }
    return any;
  }

  void putTogether(const std::vector<std::byte>& tile) {
    ByteTaker taker{tile};
    const auto i = taker.take<std::uint32_t>();
    const auto at = taker.take<PixelRect>();
    const std::optional<Image> pixels = takeTile(taker, at);
    requireTaken(taker);
    // A tile of a frame that failed may arrive after the last report.
    if (ended_.contains(i)) return;
    Assembly& frame = assemblies_[i];
    if (frame.image.rgba.empty()) frame.image = Image(crop_.width(), crop_.height());
    putTile(*pixels, at, crop_, frame.image);
    ++frame.tiles;
    completed(i);
  }

  void serveOrWait() {
    progress_.throwIfCancelled("rendering");
    if (serve()) return;
    const Clock::time_point begin = Clock::now();
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    own_.idle_s += secondsSince(begin);
  }

  // Writes the frame once all its tiles have arrived.
  void completed(std::uint32_t i) {
    Assembly& frame = assemblies_[i];
    if (frame.shares < ranks_.count() || (!frame.report.failure && frame.tiles < split_.tiles.size())) return;
    FrameReport report = std::move(frame.report);
    report.frame = i;
    if (!report.failure) {
      attempt(report, [&] {
        OpenedJob& opened = frames_.openedFor(toDraw()[i]);
        DrawnFrame drawn;
        drawn.scene = opened.sceneAt(toDraw()[i]);
        drawn.views.push_back({std::move(frame.image), opened.requestFor(drawn.scene).view});
        report.statistics.frame = toDraw()[i];
        report.statistics.wall_s = secondsSince(begun_[i]);
        drawn.statistics = std::move(report.statistics);
        write(opened, i, drawn);
        report.statistics = std::move(drawn.statistics);
      });
    }
    assemblies_.erase(i);
    ended_.insert(i);
    sendReport(std::move(report));
  }

  const PixelRect crop_;
  TilePlan split_;
  std::unique_ptr<SharedCounters> counters_;  // counter 0: finished frames; then the counters of WorkRanges
  std::map<std::uint32_t, Assembly> assemblies_;
  std::set<std::uint32_t> ended_;  // frames that are written or failed
  std::map<std::uint32_t, Clock::time_point> begun_;
  Clock::time_point begin_;
};

}  // namespace

std::uint64_t sharedTileBytes(const RenderJob& job) {
  return 4 * (16 + aovBytes(drawnAovs(job))) * drawnPixels(job.picture.size, job.picture.crop).count() / 16;
}

SequenceResult shareSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                             SequenceListener& listener) {
  if (options.checkpoint)
    throw Error(ErrorCode::kUsage, "--checkpoint: is one process's; under mpirun a frame's tiles are not kept");
  if (const char* const view = viewWithoutTiles(job); view != nullptr && job.distribution == Distribution::kTiles)
    throw Error(ErrorCode::kUsage,
                fmt::format("--distribute tiles: needs a view of tiles (found {}); use --distribute frames", view));
  if (job.distribution == Distribution::kBricks) return shareBricksOfSequence(job, options, progress, listener);
  return SharedSequence(job, options, progress, listener).run();
}

}  // namespace kiln
