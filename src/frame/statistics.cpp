#include "frame/statistics.h"

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

// Returns bytes read over bytes of contributing bricks: 1 is ideal for a cold frame; null where no file contributed.
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
            {"masked", frame.bricks_masked},
            {"emptied", frame.bricks_emptied},
            {"read", frame.bricks_read},
            {"hidden", frame.bricks_hidden},
            {"unused", frame.bricks_unused},
            {"damaged", frame.bricks_damaged},
            {"read_bytes", frame.bricks_read_bytes},
            {"shared", frame.bricks_shared},
            {"shared_bytes", frame.bricks_shared_bytes},
            {"contributing", frame.bricks_contributing},
            {"contributing_bytes", frame.bricks_contributing_bytes},
            {"read_to_contributing", readToContributing(frame)}}},
          {"companions", {{"read", frame.companion_reads}, {"read_bytes", frame.companion_bytes}}},
          {"levels", levelsOf(frame)}};
}

nlohmann::ordered_json ranksOf(const RenderStatistics& s) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const RankStatistics& rank : s.ranks)
    out.push_back({{"rank", rank.rank},
                   {"busy_s", rank.busy_s},
                   {"idle_s", rank.idle_s},
                   {"tiles", rank.tiles},
                   {"frames_written", rank.frames_written},
                   {"sent_bytes", rank.sent_bytes},
                   {"received_bytes", rank.received_bytes},
                   {"bricks",
                    {{"read", rank.bricks_read},
                     {"read_bytes", rank.bricks_read_bytes},
                     {"received", rank.bricks_received},
                     {"received_bytes", rank.bricks_received_bytes},
                     {"sent", rank.bricks_sent},
                     {"sent_bytes", rank.bricks_sent_bytes}}},
                   {"voxels", {{"visited", rank.voxels_visited}, {"splats", rank.voxels_splats}}},
                   {"memory", {{"peak_cache_bytes", rank.peak_cache_bytes}, {"peak_rss_bytes", rank.peak_rss_bytes}}}});
  return out;
}

// Returns the greatest busy time over the mean: 1 is even.
double imbalanceOf(const std::vector<RankStatistics>& ranks) {
  double sum = 0, greatest = 0;
  for (const RankStatistics& rank : ranks) {
    sum += rank.busy_s;
    greatest = std::max(greatest, rank.busy_s);
  }
  return sum > 0 ? greatest * static_cast<double>(ranks.size()) / sum : 1;
}

}  // namespace

void RankStatistics::add(const FrameStatistics& share) {
  bricks_read += share.bricks_read;
  bricks_read_bytes += share.bricks_read_bytes;
  voxels_visited += share.voxels_visited;
  voxels_splats += share.voxels_splats;
  peak_cache_bytes = std::max(peak_cache_bytes, share.peak_cache_bytes);
  peak_rss_bytes = std::max(peak_rss_bytes, share.peak_rss_bytes);
}

void RankStatistics::setReads(const SharedReadCounts& shared) {
  if (shared.read + shared.received == 0) return;
  bricks_read = shared.read;
  bricks_read_bytes = shared.read_bytes;
  bricks_received = shared.received;
  bricks_received_bytes = shared.received_bytes;
  bricks_sent = shared.sent;
  bricks_sent_bytes = shared.sent_bytes;
}

void RenderStatistics::add(const FrameStatistics& frame) {
  frames.push_back(frame);
  frames.back().contributing = {};
  frames.back().damaged = {};
  load_s += frame.load_s;
  render_s += frame.wall_s - frame.load_s;
  output_s += frame.output_s;
  peak_slabs_bytes = std::max(peak_slabs_bytes, frame.slab_bytes);
}

std::string statisticsText(const RenderStatistics& s) {
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (const FrameStatistics& frame : s.frames) {
    nlohmann::ordered_json entry = {{"frame", frame.frame},
                                    {"samples", frame.samples},
                                    {"wall_s", frame.wall_s},
                                    {"load_s", frame.load_s},
                                    {"output_s", frame.output_s}};
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
                   {"files_bytes", s.files_bytes},           {"threads_bytes", s.threads_bytes},
                   {"shadows_bytes", s.shadows_bytes},       {"slabs_bytes", s.slabs_bytes},
                   {"peak_slabs_bytes", s.peak_slabs_bytes}, {"shared_reads_bytes", s.shared_reads_bytes},
                   {"trace_bytes", s.trace_bytes},           {"functions_bytes", s.functions_bytes},
                   {"peak_rss_bytes", s.peak_rss_bytes}};
  out["fit"] = {{"files_read", s.fit.files}, {"read_bytes", s.fit.bytes}};
  out["time"] = {{"load_s", s.load_s}, {"render_s", s.render_s}, {"output_s", s.output_s}};
  if (!s.ranks.empty()) {
    out["shared_by"] = s.shared_by;
    out["ranks"] = ranksOf(s);
    out["imbalance"] = imbalanceOf(s.ranks);
  }
  return out.dump(1) + "\n";
}

}  // namespace kiln
