#include "companion/label_mask.h"

#include <algorithm>
#include <array>
#include <map>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "store/brick_index.h"
#include "store/codec/brick_codec.h"

namespace kiln {
LabelMask::LabelMask(std::unique_ptr<BrickedVolume> mask, std::vector<std::int64_t> labels, const Manifest& drawn)
    : mask_(std::move(mask)), most_read_(mask_->largestReadBytes()), place_(drawn, mask_->manifest()), kept_(kKept) {
  if (mask_->manifest().volume_class != VolumeClass::kLabels)
    throw Error(ErrorCode::kUsage, mask_->path(), "mask",
                "holds amounts, and a mask needs labels; convert its source with kiln convert --labels");
  for (const std::int64_t label : labels) labels_.push_back(static_cast<double>(label));
  std::sort(labels_.begin(), labels_.end());
}

bool LabelMask::holdsListed(const ValueRange& range) const {
  const auto first = std::lower_bound(labels_.begin(), labels_.end(), range.lo);
  return first != labels_.end() && *first <= range.hi;
}

bool LabelMask::isListed(double label) const { return std::binary_search(labels_.begin(), labels_.end(), label); }

VoxelBox LabelMask::coreOf(const BrickKey& key) const {
  return coreBox(key.brick, mask_->manifest().brick_size, mask_->level(key.level).geometry.dims);
}

bool LabelMask::holdsListed(const BrickKey& key, const VoxelBox& near) const {
  const BrickEntry& entry = mask_->index().at(key);
  if (!holdsListed(entry.core)) return false;
  if (!entry.sub_ranges) return true;
  const SubRanges& ranges = *entry.sub_ranges;
  return ranges.any(subBricksIn(near, coreOf(key), mask_->manifest().brick_size, ranges.along()),
                    [&](std::size_t i, const VoxelCoord&) { return holdsListed(ranges.at(i, entry.support)); });
}

bool LabelMask::hides(int level, const VoxelBox& box) const {
  const CompanionPlace::Map& map = place_.of(level);
  const VoxelBox near = map.around(box);
  if (near.empty()) return true;
  const std::int64_t size = mask_->manifest().brick_size;
  const VoxelBox bricks = coarseBox(near, size);
  for (std::int64_t z = bricks.lo.z; z < bricks.hi.z; ++z) {
    for (std::int64_t y = bricks.lo.y; y < bricks.hi.y; ++y) {
      for (std::int64_t x = bricks.lo.x; x < bricks.hi.x; ++x) {
        if (holdsListed({map.level, brickOf({x * size, y * size, z * size}, size)}, near)) return false;
      }
    }
  }
  return true;
}

// A brick whose only label is listed, or not, is known by the index.
LabelMask::Packed LabelMask::packedBrick(const BrickKey& key) const {
  const BrickBlock block = mask_->read(key);
  // Voxels outside the mask repeat its border, and are no labels of it.
  Packed out{intersection(block.extent, boxOf(mask_->level(key.level).geometry.dims)), ShownVoxels(block.extent)};
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const T* const voxels = block.data<T>();
    const std::int64_t count = block.extent.count();
    T last = voxels[0];
    bool listed = isListed(static_cast<double>(last));
    for (std::int64_t i = 0; i < count; ++i) {
      if (voxels[i] != last) last = voxels[i], listed = isListed(static_cast<double>(last));
      if (listed) out.listed.show(i);
    }
  });
  return out;
}

// Looks labels up, brick after brick of the mask. Neighbouring voxels mostly lie in one brick of the mask, whose apron
// is used as well.
class LabelMask::Filling {
 public:
  Filling(const LabelMask& mask, const CompanionPlace::Map& map, BrickBlock& block)
      : mask_(mask), map_(map), size_(mask.mask_->manifest().brick_size), block_(block) {}

  // Returns the number of shown voxels.
  std::int64_t run() {
    // The brick in the middle serves most voxels.
    isShown(nearestTo(middleVoxel(block_.core)));
    block_.shown = ShownVoxels(block_.extent);
    const std::array<std::vector<std::int64_t>, 3> voxels = voxelsOf(map_.drawn);
    if (map_.straight())
      fillRows(voxels);
    else
      fillVoxels(voxels);
    return shown_;
  }

 private:
  // A brick of the mask in use: a single label, or packed voxels.
  struct Brick {
    VoxelBox extent;  // the voxels of which the brick knows the label
    bool listed = false;
    std::shared_ptr<const Packed> packed;  // null: all labels are listed, or none
  };

  // The voxels of the block along each axis; a voxel outside the volume repeats the nearest voxel inside.
  std::array<std::vector<std::int64_t>, 3> voxelsOf(const Extent3& dims) const {
    std::array<std::vector<std::int64_t>, 3> out;
    for (int axis = 0; axis < 3; ++axis) {
      for (std::int64_t i = block_.extent.lo[axis]; i < block_.extent.hi[axis]; ++i)
        out[static_cast<std::size_t>(axis)].push_back(std::clamp<std::int64_t>(i, 0, dims[axis] - 1));
    }
    return out;
  }

  VoxelCoord nearestTo(const VoxelCoord& voxel) const { return nearestVoxel(map_.placeOf(voxel)); }

  void show(std::int64_t offset, std::int64_t count) {
    block_.shown.show(offset, count);
    shown_ += count;
  }

  void fillVoxels(const std::array<std::vector<std::int64_t>, 3>& voxels) {
    std::int64_t offset = 0;
    for (const std::int64_t z : voxels[2]) {
      for (const std::int64_t y : voxels[1]) {
        for (const std::int64_t x : voxels[0]) {
          if (isShown(nearestTo({x, y, z}))) show(offset, 1);
          ++offset;
        }
      }
    }
  }

  // As fillVoxels, if each axis of the volume runs along the mask's own.
  void fillRows(std::array<std::vector<std::int64_t>, 3> voxels) {
    for (int axis = 0; axis < 3; ++axis) {
      for (std::int64_t& i : voxels[static_cast<std::size_t>(axis)]) {
        VoxelCoord voxel{};
        voxel[axis] = i;
        i = nearestTo(voxel)[axis];
      }
    }
    const auto count = static_cast<std::int64_t>(voxels[0].size());
    std::int64_t offset = 0;
    for (const std::int64_t z : voxels[2]) {
      for (const std::int64_t y : voxels[1]) {
        fillRow(voxels[0], y, z, offset);
        offset += count;
      }
    }
  }

  void fillRow(const std::vector<std::int64_t>& row, std::int64_t y, std::int64_t z, std::int64_t offset) {
    const auto count = static_cast<std::int64_t>(row.size());
    const bool in_last =
        last_ != nullptr && last_->extent.contains({row.front(), y, z}) && last_->extent.contains({row.back(), y, z});
    if (in_last && !last_->packed) {
      if (last_->listed) show(offset, count);
      return;
    }
    if (!in_last) {
      for (std::int64_t x = 0; x < count; ++x) {
        if (isShown({row[static_cast<std::size_t>(x)], y, z})) show(offset + x, 1);
      }
      return;
    }
    const ShownVoxels& listed = last_->packed->listed;
    const std::int64_t first = listed.offsetOf({0, y, z});
    for (std::int64_t x = 0; x < count; ++x) {
      if (listed.at(first + row[static_cast<std::size_t>(x)])) show(offset + x, 1);
    }
  }

  // Returns whether the label of a voxel of the mask is listed; false outside the mask.
  bool isShown(const VoxelCoord& at) {
    if (last_ == nullptr || !last_->extent.contains(at)) {
      if (!boxOf(map_.dims).contains(at)) return false;
      last_ = &brickAround(at);
    }
    if (!last_->packed) return last_->listed;
    return last_->packed->listed.at(last_->packed->listed.offsetOf(at));
  }

  const Brick& brickAround(const VoxelCoord& at) {
    const BrickKey key{map_.level, brickOf(at, size_)};
    const auto [place, is_new] = bricks_.try_emplace(key);
    if (is_new) place->second = brickOfMask(key);
    return place->second;
  }

  Brick brickOfMask(const BrickKey& key) {
    const BrickEntry& entry = mask_.mask_->index().at(key);
    const bool none = !mask_.holdsListed(entry.core);
    if (none || entry.constant) return {mask_.coreOf(key), !none, nullptr};
    const auto packed = mask_.kept_.get(key, [&] {
      ++block_.companion_reads;
      block_.companion_bytes += entry.file_bytes;
      return mask_.packedBrick(key);
    });
    return {packed->extent, false, packed};
  }

  const LabelMask& mask_;
  const CompanionPlace::Map& map_;
  const std::int64_t size_;
  BrickBlock& block_;
  std::map<BrickKey, Brick> bricks_;
  const Brick* last_ = nullptr;
  std::int64_t shown_ = 0;
};

// Samples of a brick interpolate the voxels of its core and their neighbours. The rest of the apron serves normals.
bool LabelMask::addTo(BrickBlock& block) const {
  const std::int64_t shown = Filling(*this, place_.of(block.key.level), block).run();
  const bool shows = block.shown.any(dilated(block.core, 1));
  if (shown == block.extent.count()) block.shown = {};
  return shows;
}

std::uint64_t LabelMask::packedBytes() const {
  const Manifest& manifest = mask_->manifest();
  const std::int64_t edge = manifest.brick_size + 2 * manifest.apron;
  return sizeof(Packed) + 64 + ShownVoxels::bytesFor({{0, 0, 0}, {edge, edge, edge}});
}

// The bricks in use, and the decoding of the last. Bricks are charged that the extent touches, unless a single brick
// with its apron holds the extent.
std::uint64_t LabelMask::workBytes(int level, const VoxelBox& extent) const {
  const CompanionPlace::Map& map = place_.of(level);
  const VoxelBox near = map.around(intersection(extent, boxOf(map.drawn)));
  if (near.empty()) return 0;
  const Manifest& manifest = mask_->manifest();
  const std::int64_t bricks = map.bricksFor(near, manifest.brick_size, manifest.apron);
  return static_cast<std::uint64_t>(bricks) * packedBytes() + most_read_;
}

std::uint64_t LabelMask::heldBytes() const { return mask_->heldBytes() + kKept * packedBytes(); }

}  // namespace kiln
