#include "companion/color_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <type_traits>
#include <utility>

#include "store/brick_index.h"
#include "store/codec/brick_codec.h"

namespace kiln {

ColorValues::ColorValues(std::unique_ptr<BrickedVolume> values, const Manifest& drawn)
    : values_(std::move(values)),
      most_read_(values_->largestReadBytes()),
      place_(drawn, values_->manifest()),
      nearest_(values_->manifest().volume_class == VolumeClass::kLabels),
      apron_(drawn.apron),
      kept_(kKept) {}

// Looks values up, brick after brick. A brick with its apron holds both voxels around each place in its core.
class ColorValues::Filling {
 public:
  Filling(const ColorValues& colors, const CompanionPlace::Map& map, BrickBlock& block)
      : colors_(colors), map_(map), size_(colors.values_->manifest().brick_size), block_(block) {}

  void run() {
    block_.color_values.assign(static_cast<std::size_t>(block_.extent.count()),
                               std::numeric_limits<float>::quiet_NaN());
    const auto inside = [&](std::int64_t i, int axis) { return std::clamp<std::int64_t>(i, 0, map_.drawn[axis] - 1); };
    // The brick in the middle serves most voxels.
    valueAt(map_.placeOf(middleVoxel(block_.core)));
    const VoxelBox read = dilated(block_.core, kReach);
    for (std::int64_t z = read.lo.z; z < read.hi.z; ++z) {
      for (std::int64_t y = read.lo.y; y < read.hi.y; ++y) {
        float* out = block_.color_values.data() + block_.offsetOf({read.lo.x, y, z});
        for (std::int64_t x = read.lo.x; x < read.hi.x; ++x)
          *out++ = valueAt(map_.placeOf({inside(x, 0), inside(y, 1), inside(z, 2)}));
      }
    }
  }

 private:
  float valueAt(const glm::dvec3& place) {
    const VoxelCoord nearest = nearestVoxel(place);
    if (!boxOf(map_.dims).contains(nearest)) return std::numeric_limits<float>::quiet_NaN();
    if (last_ == nullptr || !dilated(last_->extent, -1).contains(nearest)) last_ = &brickAround(nearest);
    return withVoxelType(last_->type, [&]<class T>(std::type_identity<T>) {
      const T* const voxels = last_->data<T>();
      if (colors_.nearest_) return static_cast<float>(voxels[last_->offsetOf(nearest)]);
      return static_cast<float>(interpolated(voxels, place));
    });
  }

  // Places beyond the middle of the outermost voxels have the value of these voxels.
  template <class T>
  double interpolated(const T* voxels, const glm::dvec3& place) const {
    VoxelCoord voxel;
    double part[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double at = std::clamp(place[axis], 0.0, static_cast<double>(map_.dims[axis] - 1));
      voxel[axis] = static_cast<std::int64_t>(at);
      part[axis] = at - static_cast<double>(voxel[axis]);
    }
    const T* const v = voxels + last_->offsetOf(voxel);
    const std::int64_t y = last_->strideY(), z = last_->strideZ();
    // A voxel of weight 0 may be NaN.
    const auto mixed = [](double a, double b, double t) { return t == 0 ? a : a + t * (b - a); };
    const auto row = [&](std::int64_t i) {
      return mixed(static_cast<double>(v[i]), static_cast<double>(v[i + 1]), part[0]);
    };
    return mixed(mixed(row(0), row(y), part[1]), mixed(row(z), row(z + y), part[1]), part[2]);
  }

  const BrickBlock& brickAround(const VoxelCoord& at) {
    const BrickKey key{map_.level, brickOf(at, size_)};
    auto [place, is_new] = bricks_.try_emplace(key);
    if (is_new) {
      place->second = colors_.kept_.get(key, [&] {
        const BrickEntry& entry = colors_.values_->index().at(key);
        block_.companion_reads += entry.constant ? 0 : 1;
        block_.companion_bytes += entry.file_bytes;
        return colors_.values_->read(key);
      });
    }
    return *place->second;
  }

  const ColorValues& colors_;
  const CompanionPlace::Map& map_;
  const std::int64_t size_;
  BrickBlock& block_;
  std::map<BrickKey, std::shared_ptr<const BrickBlock>> bricks_;
  const BrickBlock* last_ = nullptr;
};

bool ColorValues::addTo(BrickBlock& block) const {
  Filling(*this, place_.of(block.key.level), block).run();
  return true;
}

std::uint64_t ColorValues::workBytes(int level, const VoxelBox& extent) const {
  const CompanionPlace::Map& map = place_.of(level);
  const VoxelBox read = dilated(extent, kReach - apron_);
  const VoxelBox near = map.around(intersection(read, boxOf(map.drawn)));
  if (near.empty()) return 0;
  const Manifest& manifest = values_->manifest();
  const std::int64_t bricks = map.bricksFor(near, manifest.brick_size, manifest.apron - 1);
  return static_cast<std::uint64_t>(bricks) * values_->blockBytes({0, {0, 0, 0}}) + most_read_;
}

std::uint64_t ColorValues::heldBytes() const {
  return values_->heldBytes() + kKept * values_->blockBytes({0, {0, 0, 0}});
}

}  // namespace kiln
