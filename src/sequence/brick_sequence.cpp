#include "sequence/brick_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "base/elapsed.h"
#include "cluster/shared_lists.h"
#include "composite/part_order.h"
#include "frame/background.h"
#include "frame/empty_frame.h"
#include "frame/part_image.h"
#include "frame/pass/aov_planes.h"
#include "job/frame/frame_scene.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "ranks/composite_ranks.h"
#include "ranks/rank_boxes.h"
#include "ranks/split_store.h"
#include "sequence/ranked_sequence.h"
#include "sequence/sequence_frames.h"
#include "store/manifest/read_manifest.h"

namespace kiln {
namespace {

using Clock = std::chrono::steady_clock;

void requireParts(const RenderJob& job) {
  const auto refuse = [](const char* what) {
    throw Error(ErrorCode::kUsage, std::string("--distribute bricks: ") + what + "; use --distribute tiles");
  };
  if (drawsPart(job.picture)) refuse("a partial image (--part) is one rank's already");
  requireCapability(engineOf(job), &EngineCapabilities::parts, "--distribute bricks: needs", "use --distribute tiles");
  if (const char* const view = viewWithoutTiles(job)) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--distribute bricks: needs a view of parts (found {}); use --distribute frames", view));
  }
  if (isSeries(job)) refuse("a volume for each frame has other bricks each time");
}

// Cuts by the first frame's transfer function, so that a rank keeps its bricks. Rank 0 cuts for all.
std::vector<VoxelBox> boxesOfRanks(const RenderJob& job, const StoreFor& stores, Ranks& ranks) {
  std::vector<VoxelBox> boxes;
  if (ranks.first()) {
    const StoreReader store(stores(job.volume), job.speed.memory_bytes);
    const FrameScene scene = SceneOfJob(job, store.manifest()).at(framesOf(job).front());
    boxes = boxesForRanks(store, scene.transfer_function, ranks.count());
  }
  broadcastList(ranks, boxes);
  return boxes;
}

// Returns the checksum of a store's index; nothing for an unreadable store.
std::optional<Hash128> indexOf(const std::filesystem::path& store) {
  try {
    return readManifest(store).index_checksum;
  } catch (const Error&) {
    return std::nullopt;
  }
}

// Returns the box on each rank's own disk. Headers name the `whole` store.
std::vector<VoxelBox> boxesOnDisks(const std::filesystem::path& part, const std::filesystem::path& whole,
                                   Ranks& ranks) {
  const Manifest manifest = readManifest(part);
  std::vector<VoxelBox> boxes = gatherLists(ranks, std::vector<VoxelBox>{boxOfStorePart(part)});
  const std::vector<Hash128> indexes = gatherLists(ranks, std::vector<Hash128>{manifest.index_checksum});
  if (ranks.first()) {
    const auto other = std::find_if(indexes.begin(), indexes.end(), [&](const Hash128& i) { return i != indexes[0]; });
    if (other != indexes.end())
      throw Error(ErrorCode::kUsage, fmt::format("--store-local: rank {} holds a part of another store than rank 0",
                                                 other - indexes.begin()));
    if (indexOf(whole).value_or(indexes[0]) != indexes[0])
      throw Error(ErrorCode::kUsage, part, "", "--store-local: holds a part of another store than " + whole.string());
    requireWhole(boxes, manifest.geometry().dims);
  }
  broadcastList(ranks, boxes);
  return boxes;
}

struct Plan {
  StoreFor stores;
  std::vector<VoxelBox> boxes;
};

Plan planFor(const RenderJob& job, const SequenceOptions& options) {
  requireParts(job);
  if (!options.store_local.empty()) {
    if (isShaded(shadingOf(job)))
      throw Error(
          ErrorCode::kUsage,
          "--store-local: shadows and ambient occlusion fall from parts that other ranks hold (found a part for each "
          "rank); leave out --shadows and --ambient-occlusion, or --store-local on a disk that all ranks see");
    const std::filesystem::path part = pathOfFrame(options.store_local, options.ranks->rank() + 1);
    const std::vector<std::filesystem::path> inputs = inputVolumesOf(job);
    if (std::count(inputs.begin(), inputs.end(), job.volume) > 1)
      throw Error(
          ErrorCode::kUsage,
          "--store-local: a mask or colours of the drawn volume itself need bricks that other ranks hold (found " +
              job.volume.string() + " as both); leave out --store-local");
    const auto store_for = [part, drawn = job.volume, shared = sharedStores(job, options)](
                               const std::filesystem::path& volume) { return volume == drawn ? part : shared(volume); };
    return {store_for, boxesOnDisks(part, job.volume, *options.ranks)};
  }
  Plan out{sharedStores(job, options), {}};
  out.boxes = boxesOfRanks(job, out.stores, *options.ranks);
  return out;
}

class BrickSequence : public RankedSequence {
 public:
  BrickSequence(const RenderJob& job, const SequenceOptions& options, const Plan& plan, Progress& progress,
                SequenceListener& listener)
      : RankedSequence(job, options, plan.stores, progress, listener,
                       plan.boxes[static_cast<std::size_t>(options.ranks->rank())]),
        boxes_(plan.boxes) {}

 private:
  const char* sharedBy() const override { return "bricks"; }

  void share() override {
    ranks_.barrier();
    const Clock::time_point begin = Clock::now();
    const double waited_before = ranks_.traffic().waited_s;
    for (std::uint32_t i = 0; i < toDraw().size(); ++i) drawFrame(i);
    own_.idle_s = ranks_.traffic().waited_s - waited_before;
    own_.busy_s = secondsSince(begin) - own_.idle_s;
  }

  void drawFrame(std::uint32_t i) {
    const Clock::time_point begin = Clock::now();
    started(i);
    FrameReport report;
    report.frame = i;
    attempt(report, [&] {
      if (ranks_.first()) requirePlaces(job_, toDraw()[i]);
    });
    DrawnFrame drawn;
    // No rank draws a frame that rank 0 cannot write.
    if (!isSoundOnFirst(report) || !drawPart(report, drawn)) {
      if (ranks_.first()) record(report);
      return;
    }
    composite(drawn, report.statistics);
    if (!ranks_.first()) return;
    attempt(report, [&] {
      OpenedJob& opened = frames_.openedFor(toDraw()[i]);
      drawn.scene = frames_.sceneToWrite(opened, toDraw()[i]);
      report.statistics.wall_s = secondsSince(begin);
      drawn.statistics = std::move(report.statistics);
      write(opened, i, drawn);
      report.statistics = std::move(drawn.statistics);
    });
    record(report);
  }

  // Collective. Draws this rank's bricks. Returns, on all ranks, whether no rank failed.
  bool drawPart(FrameReport& report, DrawnFrame& drawn) {
    const int frame = toDraw()[report.frame];
    attempt(report, [&] {
      drawn = frames_.openedFor(frame).draw(frame, progress_);
      report.statistics = std::move(drawn.statistics);
    });
    own_.add(report.statistics);
    ++own_.tiles;
    return collect(report);
  }

  // Collective. Returns, on all ranks, whether rank 0's report has no failure.
  bool isSoundOnFirst(const FrameReport& report) {
    std::vector<char> failed(1, report.failure ? 1 : 0);
    broadcastList(ranks_, failed);
    return failed[0] == 0;
  }

  // Collective. Adds all ranks' reports on rank 0. Returns, on all ranks, whether none failed.
  bool collect(FrameReport& report) {
    const auto reports = ranks_.gather(packed(report));
    if (ranks_.first()) {
      for (std::size_t rank = 1; rank < reports.size(); ++rank) {
        const FrameReport other = reportFrom(reports[rank]);
        // Each rank has the bricks of its box alone; a brick across two boxes counts twice.
        const std::uint64_t interesting = report.statistics.bricks_interesting + other.statistics.bricks_interesting;
        report.statistics.merge(other.statistics);
        report.statistics.bricks_interesting = std::min(interesting, report.statistics.bricks_total);
        if (other.failure && !report.failure) report.failure = other.failure;
      }
    }
    return isSoundOnFirst(report);
  }

  void composite(DrawnFrame& drawn, FrameStatistics& statistics) {
    auto& [image, view] = drawn.views.front();
    const VolumeGeometry& volume = frames_.openedFor(toDraw().front()).firstVolume().manifest().geometry();
    const std::vector<int> order = requiredOrder(boxes_, view, volume, job_.volume);
    const Aovs aovs = drawnAovs(job_);
    Image made = compositeDirectly(ranks_, image, aovs, order, static_cast<float>(job_.picture.opacity_threshold));
    if (!ranks_.first()) return;
    image = pixelsOf(made, drawn.scene.picture, aovs);
    statistics.visible = isVisible(image);
    const PixelRect crop = drawnPixels(job_.picture.size, job_.picture.crop);
    PictureOptions whole = drawn.scene.picture;
    whole.part.reset(), whole.clipping.part.reset();
    layOverBackground(image, crop.y0, job_.picture.size.height, drawnBackground(whole, drawn.scene.transfer_function));
  }

  const std::vector<VoxelBox> boxes_;
};

}  // namespace

std::uint64_t partBytes(const RenderJob& job) {
  const std::uint64_t sample_bytes = 4 * sizeof(float) + aovBytes(drawnAovs(job));
  return 3 * sample_bytes * sampleWindowOf(job.picture).samples.count();
}

SequenceResult shareBricksOfSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                                     SequenceListener& listener) {
  return BrickSequence(job, options, planFor(job, options), progress, listener).run();
}

}  // namespace kiln
