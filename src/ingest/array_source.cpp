// Voxels of an array in memory, in any order and with any distances between neighbours.
#include <cstring>

#include "base/error.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/open_source.h"

namespace kiln {
namespace {

using Strides = std::array<std::int64_t, 3>;  // along x, y and z. unit: bytes

Strides denseStrides(const Extent3& dims, VoxelType type) {
  const auto voxel = static_cast<std::int64_t>(sizeOf(type));
  return {voxel, voxel * dims.x, voxel * dims.x * dims.y};
}

// Copies a box of `n` voxels to `to`, x fastest, densely packed.
template <std::size_t kSize>
void gather(const std::byte* from, const Strides& strides, const Extent3& n, std::byte* to) noexcept {
  const auto bytes_of_row = static_cast<std::size_t>(n.x) * kSize;
  for (std::int64_t z = 0; z < n.z; ++z) {
    for (std::int64_t y = 0; y < n.y; ++y, to += bytes_of_row) {
      const std::byte* const row = from + z * strides[2] + y * strides[1];
      if (strides[0] == static_cast<std::int64_t>(kSize)) {
        std::memcpy(to, row, bytes_of_row);
        continue;
      }
      for (std::int64_t x = 0; x < n.x; ++x)
        std::memcpy(to + x * static_cast<std::int64_t>(kSize), row + x * strides[0], kSize);
    }
  }
}

class ArraySource : public VolumeSource {
 public:
  explicit ArraySource(const VoxelArray& array)
      : voxels_(static_cast<const std::byte*>(array.voxels)),
        strides_(array.strides.value_or(denseStrides(array.geometry.dims, array.type))) {
    info_.format = kArrayName;
    info_.geometry = array.geometry;
    info_.type = array.type;
    info_.volume_class = array.volume_class;
  }

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override {
    const std::byte* const from = voxels_ + box.lo.x * strides_[0] + box.lo.y * strides_[1] + box.lo.z * strides_[2];
    withVoxelType(info_.type,
                  [&]<class T>(std::type_identity<T>) { gather<sizeof(T)>(from, strides_, box.extent(), out.data()); });
  }

 private:
  const std::byte* const voxels_;
  const Strides strides_;
  SourceInfo info_;
};

}  // namespace

std::unique_ptr<VolumeSource> arraySource(const VoxelArray& array) {
  if (array.voxels == nullptr)
    throw Error(ErrorCode::kUsage, kArrayName, "voxels",
                "an array needs the address of its first voxel (found null); set it");
  checkedBytes(array.geometry.dims, array.type, kArrayName);
  requireInvertible(array.geometry.world_from_index, kArrayName);
  return std::make_unique<ArraySource>(array);
}

}  // namespace kiln
