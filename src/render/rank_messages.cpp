#include "render/rank_messages.h"

#include "cluster/parcel.h"

namespace kiln {
namespace {

// All of a frame's numbers, in one order for both ends.
template <class Statistics, class Do>
void eachNumber(Statistics& s, const Do& what) {
  what(s.frame);
  what(s.threads);
  what(s.busy);
  for (auto* seconds : {&s.wall_s, &s.load_s, &s.output_s}) what(*seconds);
  for (auto* count :
       {&s.voxels_visited, &s.voxels_splats, &s.nodes_tested, &s.nodes_hidden, &s.bricks_total, &s.bricks_interesting,
        &s.bricks_read, &s.bricks_hidden, &s.bricks_unused, &s.bricks_damaged, &s.bricks_read_bytes,
        &s.bricks_contributing, &s.bricks_contributing_bytes, &s.slab_bytes, &s.peak_cache_bytes, &s.peak_rss_bytes})
    what(*count);
}

struct ContributingBrick {
  StoredBrick key;
  std::uint64_t bytes;
};

}  // namespace

std::vector<std::byte> packed(const TileMessage& message) {
  ParcelWriter out;
  out.put(message.frame);
  out.put(message.tile);
  out.put(message.pixels.width);
  out.put(message.pixels.height);
  out.put(message.pixels.rgba);
  out.put(message.pixels.planes.size());
  for (const Plane& plane : message.pixels.planes) {
    out.put(plane.name);
    out.put(plane.values);
  }
  return out.take();
}

TileMessage tileFrom(const std::vector<std::byte>& bytes) {
  ParcelReader in(bytes);
  TileMessage out;
  out.frame = in.get<std::uint32_t>();
  out.tile = in.get<std::uint32_t>();
  out.pixels.width = in.get<int>();
  out.pixels.height = in.get<int>();
  out.pixels.rgba = in.getList<float>();
  out.pixels.planes.resize(in.get<std::size_t>());
  for (Plane& plane : out.pixels.planes) {
    plane.name = in.getText();
    plane.values = in.getList<float>();
  }
  return out;
}

std::vector<std::byte> packed(const FrameReport& report) {
  ParcelWriter out;
  out.put(report.frame);
  const FrameStatistics& s = report.statistics;
  eachNumber(s, [&](const auto& number) { out.put(number); });
  out.put(s.levels);
  std::vector<ContributingBrick> contributing;
  for (const auto& [key, file_bytes] : s.contributing) contributing.push_back({key, file_bytes});
  out.put(contributing);
  out.put(std::vector<StoredBrick>(s.damaged.begin(), s.damaged.end()));
  out.put(report.failure.has_value());
  if (report.failure) {
    out.put(report.failure->code());
    out.put(std::string(report.failure->what()));
  }
  return out.take();
}

FrameReport reportFrom(const std::vector<std::byte>& bytes) {
  ParcelReader in(bytes);
  FrameReport out;
  out.frame = in.get<std::uint32_t>();
  FrameStatistics& s = out.statistics;
  eachNumber(s, [&](auto& number) { number = in.get<std::remove_reference_t<decltype(number)>>(); });
  s.levels = in.getList<LevelStatistics>();
  for (const ContributingBrick& brick : in.getList<ContributingBrick>()) s.contributing[brick.key] = brick.bytes;
  for (const StoredBrick& key : in.getList<StoredBrick>()) s.damaged.insert(key);
  if (in.get<bool>()) {
    const auto code = in.get<ErrorCode>();
    out.failure = Error(code, in.getText());
  }
  return out;
}

std::vector<std::byte> packed(const RankStatistics& statistics) {
  ParcelWriter out;
  out.put(statistics);
  return out.take();
}

RankStatistics rankFrom(const std::vector<std::byte>& bytes) { return ParcelReader(bytes).get<RankStatistics>(); }

}  // namespace kiln
