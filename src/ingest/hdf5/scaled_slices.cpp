#include "ingest/hdf5/scaled_slices.h"

#include <cassert>
#include <utility>

#include "ingest/bytes/value_map.h"
#include "ingest/source/wrapped_source.h"

namespace kiln {
namespace {

class ScaledSlices : public WrappedSource {
 public:
  ScaledSlices(std::unique_ptr<VolumeSource> source, SliceScales scales)
      : WrappedSource(std::move(source)), stored_(info_.type), scales_(std::move(scales)) {
    assert(static_cast<std::int64_t>(scales_.slices.size()) == info_.geometry.dims[scales_.axis]);
    info_.type = VoxelType::f32;
  }

  void read(const VoxelBox& box, std::span<std::byte> out) override;
  std::uint64_t decodeBytes() const override {
    const Extent3& dims = info_.geometry.dims;
    return WrappedSource::decodeBytes() + static_cast<std::uint64_t>(dims.x * dims.y) * sizeOf(stored_);
  }

 private:
  // Maps numbers of one slice.
  void map(std::int64_t slice, const std::byte* from, std::size_t count, std::byte* to) const noexcept {
    const SliceScale& scale = scales_.slices[static_cast<std::size_t>(slice)];
    ValueMap{stored_, VoxelType::f32, false, scale.slope, scale.intercept}.apply(from, count, to);
  }

  VoxelType stored_;
  SliceScales scales_;
};

void ScaledSlices::read(const VoxelBox& box, std::span<std::byte> out) {
  const auto row = static_cast<std::size_t>(box.extent().x);
  std::vector<std::byte> plane(row * static_cast<std::size_t>(box.extent().y) * sizeOf(stored_));
  std::byte* to = out.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    WrappedSource::read({{box.lo.x, box.lo.y, z}, {box.hi.x, box.hi.y, z + 1}}, plane);
    const std::byte* from = plane.data();
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, from += row * sizeOf(stored_), to += row * sizeof(float)) {
      if (scales_.axis != 0) {
        map(scales_.axis == 1 ? y : z, from, row, to);
        continue;
      }
      for (std::size_t x = 0; x < row; ++x)
        map(box.lo.x + static_cast<std::int64_t>(x), from + x * sizeOf(stored_), 1, to + x * sizeof(float));
    }
  }
}

}  // namespace

std::unique_ptr<VolumeSource> scaledSlices(std::unique_ptr<VolumeSource> source, SliceScales scales) {
  return std::make_unique<ScaledSlices>(std::move(source), std::move(scales));
}

}  // namespace kiln
