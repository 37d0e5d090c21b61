#include "render/statistics.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace kiln {
namespace {

nlohmann::ordered_json levelsOf(const FrameStatistics& frame) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (std::size_t level = 0; level < frame.levels.size(); ++level) {
    const LevelStatistics& drawn = frame.levels[level];
    out.push_back({{"level", level},
                   {"bricks", drawn.bricks},
                   {"visited", drawn.voxels_visited},
                   {"splats", drawn.voxels_splats}});
  }
  return out;
}

// 1 is a frame from nothing that reads what it draws; null where nothing was drawn from a file.
nlohmann::ordered_json readToContributing(const FrameStatistics& frame) {
  if (frame.bricks_contributing_bytes == 0) return nullptr;
  return static_cast<double>(frame.bricks_read_bytes) / static_cast<double>(frame.bricks_contributing_bytes);
}

nlohmann::ordered_json threadsOf(const FrameStatistics& frame) {
  const BusyTimes& busy = frame.busy;
  const double rest = busy.of(Activity::kPlan) + busy.of(Activity::kFinish);
  return {{"threads", frame.threads},
          {"utilisation", frame.utilisation()},
          {"busy",
           {{"read_s", busy.of(Activity::kRead)},
            {"decode_s", busy.of(Activity::kDecode)},
            {"walk_s", busy.of(Activity::kWalk) + busy.of(Activity::kCells)},
            {"draw_s", busy.of(Activity::kTile)},
            {"other_s", rest}}}};
}

nlohmann::ordered_json countsOf(const FrameStatistics& frame) {
  return {{"voxels", {{"visited", frame.voxels_visited}, {"splats", frame.voxels_splats}}},
          {"nodes", {{"tested", frame.nodes_tested}, {"hidden", frame.nodes_hidden}}},
          {"bricks",
           {{"total", frame.bricks_total},
            {"interesting", frame.bricks_interesting},
            {"read", frame.bricks_read},
            {"hidden", frame.bricks_hidden},
            {"unused", frame.bricks_unused},
            {"damaged", frame.bricks_damaged},
            {"read_bytes", frame.bricks_read_bytes},
            {"contributing", frame.bricks_contributing},
            {"contributing_bytes", frame.bricks_contributing_bytes},
            {"read_to_contributing", readToContributing(frame)}}},
          {"levels", levelsOf(frame)}};
}

}  // namespace

void FrameStatistics::addView(const FrameStatistics& view) {
  wall_s += view.wall_s, load_s += view.load_s, output_s += view.output_s;
  voxels_visited += view.voxels_visited, voxels_splats += view.voxels_splats;
  nodes_tested += view.nodes_tested, nodes_hidden += view.nodes_hidden;
  bricks_total = std::max(bricks_total, view.bricks_total);
  bricks_damaged = std::max(bricks_damaged, view.bricks_damaged);
  bricks_interesting += view.bricks_interesting, bricks_read += view.bricks_read;
  bricks_hidden += view.bricks_hidden, bricks_unused += view.bricks_unused, bricks_read_bytes += view.bricks_read_bytes;
  bricks_contributing += view.bricks_contributing, bricks_contributing_bytes += view.bricks_contributing_bytes;
  slab_bytes = std::max(slab_bytes, view.slab_bytes);
  threads = view.threads;
  busy.add(view.busy);
  levels.resize(std::max(levels.size(), view.levels.size()));
  for (std::size_t i = 0; i < view.levels.size(); ++i) {
    levels[i].bricks += view.levels[i].bricks;
    levels[i].voxels_visited += view.levels[i].voxels_visited;
    levels[i].voxels_splats += view.levels[i].voxels_splats;
  }
}

void RenderStatistics::add(const FrameStatistics& frame) {
  frames.push_back(frame);
  load_s += frame.load_s;
  render_s += frame.wall_s - frame.load_s;
  output_s += frame.output_s;
  peak_slabs_bytes = std::max(peak_slabs_bytes, frame.slab_bytes);
}

std::string statisticsText(const RenderStatistics& s) {
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (const FrameStatistics& frame : s.frames) {
    nlohmann::ordered_json entry = {
        {"frame", frame.frame}, {"wall_s", frame.wall_s}, {"load_s", frame.load_s}, {"output_s", frame.output_s}};
    entry.update(threadsOf(frame));
    entry.update(countsOf(frame));
    entry["memory"] = {{"peak_cache_bytes", frame.peak_cache_bytes}, {"peak_rss_bytes", frame.peak_rss_bytes}};
    frames.push_back(entry);
  }
  nlohmann::ordered_json out = {{"frames", frames}};
  if (!s.kept.empty()) out["kept"] = s.kept;
  if (!s.failed.empty()) out["failed"] = s.failed;
  if (!s.frames.empty()) out.update(threadsOf(s.frames.back()));
  if (!s.frames.empty()) out.update(countsOf(s.frames.back()));
  out["memory"] = {{"budget_bytes", s.budget_bytes},         {"cache_bytes", s.cache_bytes},
                   {"peak_cache_bytes", s.peak_cache_bytes}, {"framebuffer_bytes", s.framebuffer_bytes},
                   {"visibility_bytes", s.visibility_bytes}, {"index_bytes", s.index_bytes},
                   {"slabs_bytes", s.slabs_bytes},           {"peak_slabs_bytes", s.peak_slabs_bytes},
                   {"trace_bytes", s.trace_bytes},           {"peak_rss_bytes", s.peak_rss_bytes}};
  out["time"] = {{"load_s", s.load_s}, {"render_s", s.render_s}, {"output_s", s.output_s}};
  return out.dump(1) + "\n";
}

}  // namespace kiln
