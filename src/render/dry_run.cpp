#include "render/dry_run.h"

#include <nlohmann/json.hpp>

#include "base/parallel.h"
#include "frame/brick_walk.h"
#include "render/opened_job.h"
#include "render/render_job_run.h"
#include "render/sequence.h"
#include "scene/frame_scene.h"

namespace kiln {
namespace {

// A decoded brick with its apron, as the cache keeps it.
std::uint64_t decodedBytes(const BrickFrame& brick) {
  const std::int64_t edge = brick.brick_size / kCellSize;
  const std::uint64_t octree = static_cast<std::uint64_t>(edge * edge * edge * 8 / 7) * sizeof(ValueRange);
  return static_cast<std::uint64_t>(dilated(brick.core(), brick.apron).count()) * sizeOf(brick.type) + octree +
         CellSupports::bytesFor(edge);
}

}  // namespace

DryRun dryRun(const RenderJob& given) {
  RenderJob job = jobAtFrame(given, framesOf(given).front());
  job.picture.aovs = drawnAovs(job);
  const ThreadLimit threads(job.speed.threads);
  const StoreReader store(job.volume);
  const FrameScene scene = SceneOfJob(job, store.manifest()).at(framesOf(job).front());
  const FrameRequest request = frameRequest(scene.picture, job.speed, scene.camera, scene.transfer_function);
  DryRun out;
  out.memory = frameMemory(store, job);
  out.budget_bytes = job.speed.memory_bytes;
  BrickWalkCounts counts;
  for (const BrickInView& seen : bricksInView(store, request, counts)) {
    const BrickEntry& entry = store.index().at(seen.key);
    ++out.bricks_in_view;
    out.files_in_view += entry.constant ? 0 : 1;
    out.file_bytes_in_view += entry.file_bytes;
    out.decoded_bytes_in_view += decodedBytes(store.frame(seen.key));
  }
  out.bricks_interesting = counts.interesting;
  out.bricks_total = counts.bricks;
  return out;
}

std::string dryRunText(const DryRun& run) {
  const nlohmann::ordered_json out = {{"dry_run", true},
                                      {"bricks",
                                       {{"total", run.bricks_total},
                                        {"interesting", run.bricks_interesting},
                                        {"in_view", run.bricks_in_view},
                                        {"files_in_view", run.files_in_view},
                                        {"file_bytes_in_view", run.file_bytes_in_view},
                                        {"decoded_bytes_in_view", run.decoded_bytes_in_view}}},
                                      {"memory",
                                       {{"budget_bytes", run.budget_bytes},
                                        {"smallest_bytes", run.memory.smallest()},
                                        {"framebuffer_bytes", run.memory.image + run.memory.band},
                                        {"visibility_bytes", run.memory.visibility},
                                        {"slabs_bytes", run.memory.slabs},
                                        {"trace_bytes", run.memory.trace},
                                        {"index_bytes", run.memory.index},
                                        {"brick_bytes", run.memory.brick}}}};
  return out.dump(1) + "\n";
}

}  // namespace kiln
