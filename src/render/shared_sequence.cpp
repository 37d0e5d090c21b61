#include "render/shared_sequence.h"

#include <chrono>
#include <map>
#include <thread>
#include <utility>

#include "cluster/parcel.h"
#include "cluster/work_ranges.h"
#include "render/aov_planes.h"
#include "render/brick_sequence.h"
#include "render/ranked_sequence.h"
#include "render/tile_plan.h"

namespace kiln {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kTileTag = 1, kShareTag = 2, kFrameTag = 3;

double secondsSince(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// Beside the image that a rank may put together: a tile of its own, one that it sends and one that it gets.
std::uint64_t tileBytes(const RenderJob& job) {
  const PixelRect crop = drawnPixels(job.picture.size, job.picture.crop);
  return 3 * (16 + aovBytes(drawnAovs(job))) * static_cast<std::uint64_t>(crop.width()) *
         static_cast<std::uint64_t>(crop.height()) / 16;
}

// A frame that this rank puts together.
struct Assembly {
  Image image;
  std::size_t tiles = 0;
  int shares = 0;
  FrameReport report;
};

class SharedSequence : public RankedSequence {
 public:
  SharedSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress, SequenceListener& listener)
      : RankedSequence(job, options, sharedStores(job, options), progress, listener, tileBytes(job)),
        crop_(drawnPixels(job.picture.size, job.picture.crop)) {}

 private:
  const char* sharedBy() const override { return plan_.whole_frames ? "frames" : "tiles"; }

  // One rank plans, so that all have the same plan.
  void makePlan() {
    ParcelWriter out;
    if (ranks_.first()) {
      const bool by_frames = isSeries(job_) && toDraw().size() > 1;
      plan_ = planTiles(frames_.openedFor(toDraw().front()), toDraw(), ranks_.count(),
                        by_frames ? Distribution::kFrames : job_.distribution);
      out.put(plan_.whole_frames);
      out.put(plan_.tiles);
      out.put(plan_.bounds);
    }
    std::vector<std::byte> bytes = out.take();
    ranks_.broadcast(bytes);
    ParcelReader in(bytes);
    plan_.whole_frames = in.get<bool>();
    plan_.tiles = in.getList<PixelRect>();
    plan_.bounds = in.getList<std::uint32_t>();
  }

  void share() override {
    makePlan();
    const std::size_t ranks = static_cast<std::size_t>(ranks_.count());
    counters_ = ranks_.makeCounters(1 + ranks * (plan_.whole_frames ? 1 : toDraw().size()));
    ranks_.barrier();
    begin_ = Clock::now();
    if (plan_.whole_frames)
      drawFrames();
    else
      for (std::uint32_t i = 0; i < toDraw().size(); ++i) drawTilesOf(i);
    while (!allDone()) serveOrWait();
    own_.busy_s = secondsSince(begin_) - own_.idle_s;
    ranks_.barrier();
    counters_.reset();
  }

  // The first rank has heard of every frame, the others' are counted.
  bool allDone() { return ranks_.first() ? heard_ == toDraw().size() : counters_->add(0, 0) == toDraw().size(); }

  void drawFrames() {
    std::vector<std::uint32_t> bounds;
    const auto ranks = static_cast<std::size_t>(ranks_.count());
    for (std::size_t i = 0; i <= ranks; ++i) bounds.push_back(static_cast<std::uint32_t>(i * toDraw().size() / ranks));
    WorkRanges work(*counters_, 1, bounds, ranks_.rank());
    while (const auto i = work.take()) {
      FrameReport report;
      report.frame = *i;
      attempt(report, [&] {
        OpenedJob& opened = frames_.openedFor(toDraw()[*i]);
        started(*i);
        DrawnFrame drawn = opened.draw(toDraw()[*i], progress_);
        own_.add(drawn.statistics);
        ++own_.tiles;
        write(opened, *i, drawn);
        report.statistics = std::move(drawn.statistics);
      });
      tellFirst(std::move(report));
      serve();
    }
  }

  void tellFirst(FrameReport report) {
    counters_->add(0, 1);
    report.statistics.contributing.clear();
    ranks_.send(0, kFrameTag, packed(report));
  }

  int ownerOf(std::uint32_t frame) const { return static_cast<int>(frame % static_cast<unsigned>(ranks_.count())); }

  void drawTilesOf(std::uint32_t i) {
    // Of the frames before it one may still be unfinished: images that wait for tiles are memory.
    while (counters_->add(0, 0) + 1 < i) serveOrWait();
    begun_[i] = Clock::now();
    started(i);
    const auto ranks = static_cast<std::size_t>(ranks_.count());
    WorkRanges work(*counters_, 1 + i * ranks, plan_.bounds, ranks_.rank());
    FrameReport report;
    report.frame = i;
    attempt(report, [&] { drawTiles(i, work, report.statistics); });
    if (report.failure) work.drop();
    own_.add(report.statistics);
    ranks_.send(ownerOf(i), kShareTag, packed(report));
    serve();
  }

  void drawTiles(std::uint32_t i, WorkRanges& work, FrameStatistics& statistics) {
    OpenedJob& opened = frames_.openedFor(toDraw()[i]);
    const FrameScene scene = opened.sceneAt(toDraw()[i]);
    std::unique_ptr<FramePainter> painter;
    while (const auto tile = work.take()) {
      if (!painter) painter = opened.painterFor(scene, progress_);
      ranks_.send(ownerOf(i), kTileTag, packed(TileMessage{i, *tile, painter->draw(plan_.tiles[*tile])}));
      ++own_.tiles;
      serve();
    }
    if (painter) statistics = opened.finish(*painter, toDraw()[i]);
  }

  // Takes in what others have sent. Returns whether there was anything.
  bool serve() {
    bool any = false;
    while (auto message = ranks_.poll(kTileTag)) {
      any = true;
      const TileMessage tile = tileFrom(message->bytes);
      Assembly& frame = assemblies_[tile.frame];
      if (frame.image.rgba.empty()) frame.image = Image(crop_.width(), crop_.height());
      putTile(tile.pixels, plan_.tiles[tile.tile], crop_, frame.image);
      ++frame.tiles;
      completed(tile.frame);
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
      hear(reportFrom(message->bytes));
    }
    return any;
  }

  void serveOrWait() {
    progress_.throwIfCancelled("rendering");
    if (serve()) return;
    const Clock::time_point begin = Clock::now();
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    own_.idle_s += secondsSince(begin);
  }

  // Writes the frame, if all of it is here.
  void completed(std::uint32_t i) {
    Assembly& frame = assemblies_[i];
    if (frame.shares < ranks_.count() || (!frame.report.failure && frame.tiles < plan_.tiles.size())) return;
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
    tellFirst(std::move(report));
  }

  const PixelRect crop_;
  TilePlan plan_;
  std::unique_ptr<SharedCounters> counters_;  // 0: frames that are finished; then those of the work
  std::map<std::uint32_t, Assembly> assemblies_;
  std::map<std::uint32_t, Clock::time_point> begun_;
  Clock::time_point begin_;
};

}  // namespace

SequenceResult shareSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                             SequenceListener& listener) {
  if (options.checkpoint)
    throw Error(ErrorCode::kUsage, "--checkpoint: is one process's; under mpirun a frame's tiles are not kept");
  if (job.distribution == Distribution::kBricks) return shareBricksOfSequence(job, options, progress, listener);
  return SharedSequence(job, options, progress, listener).run();
}

}  // namespace kiln
