#include "ingest/chunks/chunked_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>

#include "ingest/bytes/linear_source.h"
#include "ingest/source/brick_order.h"

namespace kiln {
namespace {

// Voxels in a chunk or box. unit: voxels.
struct Strides {
  std::int64_t x = 0, y = 0, z = 0;
  std::int64_t of(const VoxelCoord& v) const { return v.x * x + v.y * y + v.z * z; }
};

// Copies a box of `n` voxels of kSize bytes; rows of x are dense in `to`.
template <std::size_t kSize>
void copyBox(const std::byte* from, const Strides& in, const Extent3& n, std::byte* to, const Strides& out) noexcept {
  constexpr auto kStep = static_cast<std::int64_t>(kSize);
  for (std::int64_t z = 0; z < n.z; ++z) {
    for (std::int64_t y = 0; y < n.y; ++y) {
      const std::byte* const row = from + in.of({0, y, z}) * kStep;
      std::byte* const to_row = to + out.of({0, y, z}) * kStep;
      if (in.x == 1)
        std::memcpy(to_row, row, static_cast<std::size_t>(n.x) * kSize);
      else
        for (std::int64_t x = 0; x < n.x; ++x) std::memcpy(to_row + x * kStep, row + x * in.x * kStep, kSize);
    }
  }
}

class ChunkedSource : public VolumeSource {
 public:
  ChunkedSource(SourceInfo info, const ArrayVolume& volume, std::unique_ptr<ChunkedArray> array);

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  void finish() override;
  std::uint64_t decodeBytes() const override { return array_->decodeBytes(); }
  std::uint64_t heldBytes() const override { return array_->heldBytes(); }
  Extent3 cheapBox() const override { return chunk_; }
  std::optional<DecodedBlocks> decodedBlocks() const override {
    const ChunkLayout& layout = array_->layout();
    return DecodedBlocks{chunk_, productOf(layout.chunk_shape) * sizeOf(info_.type), array_->decodings()};
  }
  void willRead(const BrickOrder& order) override { array_->setOrder(order); }
  void keepDecoded(std::uint64_t bytes) override { array_->setCapacity(bytes); }

 private:
  void copy(const BlockCache::Bytes& chunk, const VoxelBox& whole, const VoxelBox& part, const VoxelBox& box,
            std::byte* out) const;

  SourceInfo info_;
  std::array<int, 3> axis_of_;
  AxisNumbers fixed_;
  std::unique_ptr<ChunkedArray> array_;
  Extent3 chunk_;
  Strides strides_;                // steps between voxels of a chunk
  std::int64_t fixed_offset_ = 0;  // place of the fixed indices in a chunk. unit: voxels
};

ChunkedSource::ChunkedSource(SourceInfo info, const ArrayVolume& volume, std::unique_ptr<ChunkedArray> chunks)
    : info_(std::move(info)), axis_of_(volume.axis_of), fixed_(volume.fixed), array_(std::move(chunks)) {
  const ChunkLayout& array = array_->layout();
  AxisNumbers stride(array.shape.size());
  std::int64_t step = 1;
  for (std::size_t i = array.stored_axes.size(); i-- > 0;) {
    const auto axis = static_cast<std::size_t>(array.stored_axes[i]);
    stride[axis] = step;
    step *= array.chunk_shape[axis];
    fixed_offset_ += fixed_[axis] % array.chunk_shape[axis] * stride[axis];
  }
  const auto along = [&](int axis, const AxisNumbers& numbers, std::int64_t missing) {
    return axis < 0 ? missing : numbers[static_cast<std::size_t>(axis)];
  };
  chunk_ = {along(axis_of_[0], array.chunk_shape, 1), along(axis_of_[1], array.chunk_shape, 1),
            along(axis_of_[2], array.chunk_shape, 1)};
  strides_ = {along(axis_of_[0], stride, 0), along(axis_of_[1], stride, 0), along(axis_of_[2], stride, 0)};
}

void ChunkedSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  assert(out.size() == static_cast<std::size_t>(box.count()) * sizeOf(info_.type));
  if (box.empty()) return;
  AxisNumbers index = fixed_;
  for (std::size_t axis = 0; axis < index.size(); ++axis) index[axis] /= array_->layout().chunk_shape[axis];
  const auto setIndex = [&](int axis, std::int64_t at) {
    if (axis_of_[axis] >= 0) index[static_cast<std::size_t>(axis_of_[axis])] = at;
  };
  const VoxelCoord first = {box.lo.x / chunk_.x, box.lo.y / chunk_.y, box.lo.z / chunk_.z};
  for (std::int64_t k = first.z; k * chunk_.z < box.hi.z; ++k) {
    setIndex(2, k);
    for (std::int64_t j = first.y; j * chunk_.y < box.hi.y; ++j) {
      setIndex(1, j);
      for (std::int64_t i = first.x; i * chunk_.x < box.hi.x; ++i) {
        setIndex(0, i);
        const VoxelCoord lo = {i * chunk_.x, j * chunk_.y, k * chunk_.z};
        const VoxelBox whole = {lo, {lo.x + chunk_.x, lo.y + chunk_.y, lo.z + chunk_.z}};
        copy(*array_->chunk(index, {whole, box.lo}), whole, intersection(whole, box), box, out.data());
      }
    }
  }
}

// Copies `part` of a chunk that covers `whole` into the rows of `box`.
void ChunkedSource::copy(const BlockCache::Bytes& chunk, const VoxelBox& whole, const VoxelBox& part,
                         const VoxelBox& box, std::byte* out) const {
  const Extent3 row = box.extent();
  const Strides to = {1, row.x, row.x * row.y};
  const auto size = static_cast<std::int64_t>(sizeOf(info_.type));
  const auto between = [](const VoxelCoord& a, const VoxelCoord& b) {
    return VoxelCoord{a.x - b.x, a.y - b.y, a.z - b.z};
  };
  std::byte* const target = out + to.of(between(part.lo, box.lo)) * size;
  const bool absent = chunk.empty();
  const std::byte* const from = absent
                                    ? array_->layout().fill.data()
                                    : chunk.data() + (fixed_offset_ + strides_.of(between(part.lo, whole.lo))) * size;
  withVoxelType(info_.type, [&]<class T>(std::type_identity<T>) {
    copyBox<sizeof(T)>(from, absent ? Strides{} : strides_, part.extent(), target, to);
  });
}

void ChunkedSource::finish() {
  if (!array_->isAllAbsent()) return;
  withVoxelType(info_.type, [&]<class T>(std::type_identity<T>) {
    T fill;
    std::memcpy(&fill, array_->layout().fill.data(), sizeof fill);
    info_.notes.push_back(
        fmt::format("no chunk of the array exists; all voxels are its fill value, {}", static_cast<double>(fill)));
  });
}

}  // namespace

std::unique_ptr<VolumeSource> openChunked(SourceInfo info, const ArrayVolume& volume,
                                          std::unique_ptr<ChunkedArray> array) {
  describe(volume, array->layout().number.voxelType(), info);
  checkedBytes(info.geometry.dims, info.type, info.files.front());
  return std::make_unique<ChunkedSource>(std::move(info), volume, std::move(array));
}

}  // namespace kiln
