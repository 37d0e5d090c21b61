#include "frame/pass/frame_statistics.h"

#include <algorithm>

namespace kiln {

void FrameStatistics::addView(const FrameStatistics& view) {
  merge(view);
  wall_s += view.wall_s, output_s += view.output_s;
}

void FrameStatistics::addLights(const FrameStatistics& lights) {
  FrameStatistics cost = lights;
  cost.bricks_total = cost.bricks_interesting = cost.bricks_masked = cost.bricks_hidden = 0;
  cost.levels.clear();
  addView(cost);
}

bool FrameStatistics::draws() const {
  return std::ranges::any_of(levels, [](const LevelStatistics& level) { return level.voxels_splats > 0; });
}

void FrameStatistics::addContributing(const StoredBrick& brick, std::uint64_t file_bytes) {
  if (!contributing.emplace(brick, file_bytes).second) return;
  ++bricks_contributing;
  bricks_contributing_bytes += file_bytes;
}

void FrameStatistics::merge(const FrameStatistics& other) {
  load_s += other.load_s;
  visible = visible || other.visible;
  voxels_visited += other.voxels_visited;
  voxels_splats += other.voxels_splats;
  nodes_tested += other.nodes_tested;
  nodes_hidden += other.nodes_hidden;
  bricks_read += other.bricks_read;
  bricks_read_bytes += other.bricks_read_bytes;
  bricks_emptied += other.bricks_emptied;
  companion_reads += other.companion_reads;
  companion_bytes += other.companion_bytes;
  bricks_shared += other.bricks_shared;
  bricks_shared_bytes += other.bricks_shared_bytes;
  bricks_hidden += other.bricks_hidden;
  bricks_unused += other.bricks_unused;
  bricks_total = std::max(bricks_total, other.bricks_total);
  bricks_interesting = std::max(bricks_interesting, other.bricks_interesting);
  bricks_masked = std::max(bricks_masked, other.bricks_masked);
  slab_bytes = std::max(slab_bytes, other.slab_bytes);
  busy.add(other.busy);
  threads = std::max(threads, other.threads);
  samples = std::max(samples, other.samples);
  peak_cache_bytes = std::max(peak_cache_bytes, other.peak_cache_bytes);
  peak_rss_bytes = std::max(peak_rss_bytes, other.peak_rss_bytes);
  levels.resize(std::max(levels.size(), other.levels.size()));
  for (std::size_t i = 0; i < other.levels.size(); ++i) {
    levels[i].bricks += other.levels[i].bricks;
    levels[i].voxels_visited += other.levels[i].voxels_visited;
    levels[i].voxels_splats += other.levels[i].voxels_splats;
  }
  for (const auto& [brick, file_bytes] : other.contributing) addContributing(brick, file_bytes);
  damaged.insert(other.damaged.begin(), other.damaged.end());
  bricks_damaged = damaged.size();
}

}  // namespace kiln
