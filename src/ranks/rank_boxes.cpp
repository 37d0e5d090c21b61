#include "ranks/rank_boxes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "store/brick_index.h"

namespace kiln {
namespace {

// Weight of an invisible brick: testing the brick costs a little. unit: whole visible bricks.
constexpr double kLeastShare = 0.001;

// Returns the share of a brick that may be visible, from 0 to 1.
double interestingPart(const BrickEntry& entry, const Classifier& classifier) {
  if (!classifier.interesting(entry.core)) return 0;
  if (!entry.sub_ranges) return 1;
  int parts = 0;
  for (std::size_t i = 0; i < entry.sub_ranges->count(); ++i) {
    const ValueRange range = entry.sub_ranges->at(i, entry.support);
    parts += !range.empty() && classifier.interesting(range) ? 1 : 0;
  }
  return static_cast<double>(parts) / static_cast<double>(entry.sub_ranges->count());
}

class VolumeCutter {
 public:
  VolumeCutter(const StoreReader& store, const Classifier& classifier)
      : lattice_(store.index().lattice(0)), brick_size_(store.manifest().brick_size) {
    weights_.reserve(static_cast<std::size_t>(lattice_.count()));
    for (std::int32_t z = 0; z < lattice_.z; ++z) {
      for (std::int32_t y = 0; y < lattice_.y; ++y) {
        for (std::int32_t x = 0; x < lattice_.x; ++x) {
          const BrickEntry& entry = store.index().at({0, {x, y, z}});
          weights_.push_back(static_cast<float>(kLeastShare + interestingPart(entry, classifier)));
        }
      }
    }
  }

  // requires: at least as many voxels as ranks.
  void cut(const VoxelBox& box, int ranks, std::vector<VoxelBox>& out) const {
    if (ranks == 1) {
      out.push_back(box);
      return;
    }
    const Extent3 n = box.extent();
    const int axis = n.x >= n.y && n.x >= n.z ? 0 : n.y >= n.z ? 1 : 2;
    const std::int64_t layer = box.count() / n[axis];
    // Each side needs a voxel for each of its ranks.
    int before = ranks / 2;
    std::int64_t least = box.lo[axis] + (before + layer - 1) / layer;
    std::int64_t most = box.hi[axis] - (ranks - before + layer - 1) / layer;
    if (least > most) {
      least = most = box.lo[axis] + n[axis] / 2;
      before = static_cast<int>(std::min<std::int64_t>(ranks - 1, layer * (n[axis] / 2)));
    }
    VoxelBox first = box, second = box;
    first.hi[axis] = second.lo[axis] = std::clamp(cutAt(box, axis, static_cast<double>(before) / ranks), least, most);
    cut(first, before, out);
    cut(second, ranks - before, out);
  }

 private:
  // Returns the coordinate below which `share` of the box's weight lies: a border of bricks, or the middle of a single
  // brick.
  std::int64_t cutAt(const VoxelBox& box, int axis, double share) const {
    const std::int64_t first = box.lo[axis] / brick_size_, last = (box.hi[axis] - 1) / brick_size_;
    if (first == last) return (box.lo[axis] + box.hi[axis]) / 2;
    std::vector<double> layers(static_cast<std::size_t>(last - first + 1));
    VoxelCoord lo, hi;
    for (int i = 0; i < 3; ++i) {
      lo[i] = box.lo[i] / brick_size_;
      hi[i] = (box.hi[i] - 1) / brick_size_;
    }
    VoxelCoord at;
    for (at.z = lo.z; at.z <= hi.z; ++at.z) {
      for (at.y = lo.y; at.y <= hi.y; ++at.y) {
        for (at.x = lo.x; at.x <= hi.x; ++at.x)
          layers[static_cast<std::size_t>(at[axis] - first)] +=
              weights_[static_cast<std::size_t>((at.z * lattice_.y + at.y) * lattice_.x + at.x)];
      }
    }
    double all = 0, sum = 0, nearest = 0;
    for (const double layer : layers) all += layer;
    std::int64_t best = 0;
    for (std::int64_t i = first; i < last; ++i) {
      sum += layers[static_cast<std::size_t>(i - first)];
      const double off = std::abs(sum - share * all);
      if (best > 0 && off >= nearest) continue;
      nearest = off;
      best = (i + 1) * brick_size_;
    }
    return best;
  }

  const Extent3 lattice_;
  const std::int64_t brick_size_;
  std::vector<float> weights_;
};

}  // namespace

std::vector<VoxelBox> boxesForRanks(const StoreReader& store, const TransferFunction& function, int ranks) {
  const Manifest& volume = store.manifest();
  const Classifier classifier(function, function.unitIn(volume.geometry().meanSpacing()), volume.type, volume.range);
  const VoxelBox whole = boxOf(volume.geometry().dims);
  if (whole.count() < ranks)
    throw Error(ErrorCode::kUsage, store.path(), "",
                fmt::format("has {} voxels, too few for {} parts; use fewer ranks or parts", whole.count(), ranks));
  std::vector<VoxelBox> out;
  VolumeCutter(store, classifier).cut(whole, ranks, out);
  return out;
}

}  // namespace kiln
