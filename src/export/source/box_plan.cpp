// Shapes are tried from the best to the least. A row of bricks, or a layer for formats of whole slices, decodes each
// brick once. Thinner boxes decode a brick once for each of its parts.
#include "export/source/box_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "store/brick_index.h"

namespace kiln {
namespace {

// A box, and the threads below which a smaller box is better.
struct BoxShape {
  Extent3 step;
  unsigned least_threads = 1;
};

std::int64_t bricksAlong(std::int64_t voxels, std::int64_t brick) { return (voxels + brick - 1) / brick; }

void addThinner(std::vector<BoxShape>& out, Extent3 step) {
  while (step.z > 1) {
    step.z /= 2;
    out.push_back({step});
  }
}

// Rows of bricks, several beside each other where that keeps all threads busy.
std::vector<BoxShape> shapesOfRows(const Extent3& dims, std::int64_t brick, unsigned threads) {
  constexpr std::int64_t kBricksOfThread = 4;
  const std::int64_t wanted = kBricksOfThread * threads / bricksAlong(dims.x, brick);
  std::vector<BoxShape> out;
  for (std::int64_t rows = std::min(wanted, bricksAlong(dims.y, brick)); rows > 1; rows /= 2)
    out.push_back({{dims.x, rows * brick, brick}, threads});
  out.push_back({{dims.x, brick, brick}});
  addThinner(out, out.back().step);
  for (std::int64_t y = brick / 2; y > 0; y /= 2) out.push_back({{dims.x, y, 1}});
  return out;
}

std::vector<BoxShape> shapesOf(const BoxRule& rule, const Extent3& dims, std::int64_t brick, unsigned threads) {
  if (rule.kind == BoxRule::Kind::kGrid) return {{rule.grid}};
  if (rule.kind == BoxRule::Kind::kRows) return shapesOfRows(dims, brick, threads);
  std::vector<BoxShape> out = {{{dims.x, dims.y, brick}}};
  addThinner(out, out.back().step);
  return out;
}

std::int64_t floorOfQuotient(std::int64_t a, std::int64_t b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

}  // namespace

BoxPlan planBoxes(const StoreReader& store, const ExportedVolume& volume, const VolumeWriter& writer,
                  std::uint64_t memory_bytes, const std::filesystem::path& out) {
  const BoxRule rule = writer.boxes(volume);
  const Extent3& dims = volume.geometry.dims;
  const unsigned most_threads = ThreadLimit::active();
  const std::uint64_t read_bytes = store.largestReadBytes();
  const auto needed = [&](const Extent3& step, unsigned threads) {
    const VoxelBox box = intersection(boxOf(step), boxOf(dims));
    const std::uint64_t box_bytes = static_cast<std::uint64_t>(box.count()) * sizeOf(volume.type);
    return store.index().bytes() + box_bytes + writer.workBytes(box_bytes, threads) + threads * read_bytes;
  };
  const VoxelCoord& lo = volume.box.lo;
  // Bricks begin at multiples of their size; whole slices and grids begin where the part begins.
  const VoxelCoord anchor = {lo.x, rule.kind == BoxRule::Kind::kRows ? 0 : lo.y,
                             rule.kind == BoxRule::Kind::kGrid ? lo.z : 0};
  const std::vector<BoxShape> shapes = shapesOf(rule, dims, store.manifest().brick_size, most_threads);
  for (const BoxShape& shape : shapes)
    for (unsigned threads = most_threads; threads >= shape.least_threads; --threads)
      if (needed(shape.step, threads) <= memory_bytes) return {shape.step, anchor, threads};
  const std::uint64_t least = needed(shapes.back().step, 1);
  throw Error(ErrorCode::kBudget, out, "--memory",
              fmt::format("the index, a box of voxels and a brick take {} (allowed: {}); give --memory {}",
                          formatBytes(least), formatBytes(memory_bytes), roundedUpBytes(least)));
}

BoxList::BoxList(const VoxelBox& whole, const BoxPlan& plan) : whole_(whole), shape_(plan) {
  VoxelCoord counts;
  for (int axis = 0; axis < 3; ++axis) {
    first_[axis] = floorOfQuotient(whole.lo[axis] - plan.anchor[axis], plan.step[axis]);
    counts[axis] = floorOfQuotient(whole.hi[axis] - 1 - plan.anchor[axis], plan.step[axis]) + 1 - first_[axis];
  }
  counts_ = {counts.x, counts.y, counts.z};
}

VoxelBox BoxList::at(std::int64_t i) const {
  const VoxelCoord place = {i % counts_.x, i / counts_.x % counts_.y, i / counts_.x / counts_.y};
  VoxelBox out;
  for (int axis = 0; axis < 3; ++axis) {
    out.lo[axis] = shape_.anchor[axis] + (first_[axis] + place[axis]) * shape_.step[axis];
    out.hi[axis] = out.lo[axis] + shape_.step[axis];
  }
  return intersection(out, whole_);
}

}  // namespace kiln
