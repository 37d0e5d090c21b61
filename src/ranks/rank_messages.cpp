#include "ranks/rank_messages.h"

#include <algorithm>

#include "base/byte_record.h"

namespace kiln {
namespace {

// Calls `what` for each number of a frame's statistics, in the same order for sender and receiver.
template <class Statistics, class Do>
void eachNumber(Statistics& s, const Do& what) {
  what(s.frame);
  what(s.samples);
  what(s.empty);
  what(s.visible);
  what(s.one_colour);
  what(s.threads);
  what(s.busy);
  for (auto* seconds : {&s.wall_s, &s.load_s, &s.output_s}) what(*seconds);
  for (auto* count : {&s.voxels_visited,
                      &s.voxels_splats,
                      &s.nodes_tested,
                      &s.nodes_hidden,
                      &s.bricks_total,
                      &s.bricks_interesting,
                      &s.bricks_masked,
                      &s.bricks_emptied,
                      &s.companion_reads,
                      &s.companion_bytes,
                      &s.bricks_read,
                      &s.bricks_hidden,
                      &s.bricks_unused,
                      &s.bricks_damaged,
                      &s.bricks_read_bytes,
                      &s.bricks_shared,
                      &s.bricks_shared_bytes,
                      &s.bricks_contributing,
                      &s.bricks_contributing_bytes,
                      &s.slab_bytes,
                      &s.peak_cache_bytes,
                      &s.peak_rss_bytes})
    what(*count);
}

}  // namespace

std::vector<std::byte> packed(const FrameReport& report) {
  std::vector<std::byte> out;
  appendValue(out, report.frame);
  const FrameStatistics& s = report.statistics;
  eachNumber(s, [&](const auto& number) { appendValue(out, number); });
  appendList(out, s.levels);
  std::vector<StoredBrick> bricks;
  std::vector<std::uint64_t> file_bytes;
  for (const auto& [brick, size] : s.contributing) {
    bricks.push_back(brick);
    file_bytes.push_back(size);
  }
  appendList(out, bricks);
  appendList(out, file_bytes);
  appendList(out, std::vector<StoredBrick>(s.damaged.begin(), s.damaged.end()));
  appendValue(out, report.failure.has_value());
  if (report.failure) {
    appendValue(out, report.failure->code());
    appendText(out, report.failure->what());
  }
  return out;
}

FrameReport reportFrom(const std::vector<std::byte>& bytes) {
  ByteTaker in{bytes};
  FrameReport out;
  out.frame = in.take<std::uint32_t>();
  FrameStatistics& s = out.statistics;
  eachNumber(s, [&](auto& number) { number = in.take<std::remove_reference_t<decltype(number)>>(); });
  s.levels = in.takeList<LevelStatistics>();
  const auto bricks = in.takeList<StoredBrick>();
  const auto file_bytes = in.takeList<std::uint64_t>();
  for (std::size_t i = 0; i < std::min(bricks.size(), file_bytes.size()); ++i)
    s.contributing[bricks[i]] = file_bytes[i];
  for (const StoredBrick& brick : in.takeList<StoredBrick>()) s.damaged.insert(brick);
  if (in.take<bool>()) {
    const auto code = in.take<ErrorCode>();
    out.failure = Error(code, in.takeText());
  }
  requireTaken(in);
  return out;
}

void requireTaken(const ByteTaker& taker) {
  if (!taker.ok || !taker.left.empty())
    throw Error(ErrorCode::kIo, "a message between ranks is cut short; run the same version of Kiln on all ranks");
}

}  // namespace kiln
