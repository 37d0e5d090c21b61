#include "convert/slice_ring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "base/error.h"
#include "base/memory.h"
#include "ingest/gather_rows.h"

namespace kiln {
namespace {

std::uint64_t rowBytes(const SourceInfo& info) {
  return static_cast<std::uint64_t>(info.geometry.dims.x) * sizeOf(info.type);
}

// Where voxels are in the ring.
class RingShape {
 public:
  RingShape(const SourceInfo& info, std::int64_t slices)
      : slices_(static_cast<std::uint64_t>(slices)),
        slice_(sliceBytes(info)),
        row_(rowBytes(info)),
        voxel_(sizeOf(info.type)) {}
  std::int64_t slices() const { return static_cast<std::int64_t>(slices_); }
  std::uint64_t bytes() const { return slices_ * slice_; }
  std::uint64_t row() const { return row_; }
  std::uint64_t voxel() const { return voxel_; }
  std::uint64_t offsetOf(const VoxelCoord& at) const {
    return static_cast<std::uint64_t>(at.z) % slices_ * slice_ + static_cast<std::uint64_t>(at.y) * row_ +
           static_cast<std::uint64_t>(at.x) * voxel_;
  }

 private:
  std::uint64_t slices_, slice_, row_, voxel_;
};

class RingInMemory : public SliceRing {
 public:
  explicit RingInMemory(const RingShape& shape)
      : shape_(shape), slices_(std::make_unique_for_overwrite<std::byte[]>(shape.bytes())) {}

  std::int64_t slices() const override { return shape_.slices(); }

  void read(VolumeSource& source, const VoxelBox& rows) override {
    source.read(rows,
                {slices_.get() + shape_.offsetOf(rows.lo), static_cast<std::size_t>(rows.count()) * shape_.voxel()});
  }

  void copy(const VoxelBox& box, std::span<std::byte> out) const override {
    const std::size_t row = static_cast<std::size_t>(box.extent().x) * shape_.voxel();
    std::byte* to = out.data();
    for (VoxelCoord at = box.lo; at.z < box.hi.z; ++at.z) {
      for (at.y = box.lo.y; at.y < box.hi.y; ++at.y, to += row)
        std::memcpy(to, slices_.get() + shape_.offsetOf(at), row);
    }
  }

 private:
  RingShape shape_;
  std::unique_ptr<std::byte[]> slices_;
};

class RingOnDisk : public SliceRing {
 public:
  RingOnDisk(const RingShape& shape, std::uint64_t strip_bytes, const std::filesystem::path& directory,
             FileSystem& disk)
      : shape_(shape), disk_(disk), file_(disk.makeScratch(directory)), strip_(strip_bytes) {}

  std::int64_t slices() const override { return shape_.slices(); }

  void read(VolumeSource& source, const VoxelBox& rows) override {
    const std::span<std::byte> strip = std::span(strip_).first(static_cast<std::size_t>(rows.count()) * shape_.voxel());
    source.read(rows, strip);
    try {
      disk_.writeAt(file_, shape_.offsetOf(rows.lo), strip);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kNoSpace) throw;
      throw Error(ErrorCode::kNoSpace, file_.path(), "",
                  fmt::format("no space for the {} of slices that are kept beside the store while it is made; free "
                              "space, choose another place, or give --memory for them",
                              formatBytes(shape_.bytes())));
    }
  }

  void copy(const VoxelBox& box, std::span<std::byte> out) const override {
    const Extent3 n = box.extent();
    const std::uint64_t row = static_cast<std::uint64_t>(n.x) * shape_.voxel(), rows = static_cast<std::uint64_t>(n.y);
    std::byte* to = out.data();
    for (VoxelCoord at = box.lo; at.z < box.hi.z; ++at.z, to += rows * row) {
      gatherRows(file_, shape_.offsetOf(at), rows, row, shape_.row(), to);
    }
  }

 private:
  RingShape shape_;
  FileSystem& disk_;
  File file_;
  std::vector<std::byte> strip_;
};

}  // namespace

std::uint64_t sliceBytes(const SourceInfo& info) {
  return static_cast<std::uint64_t>(info.geometry.dims.y) * rowBytes(info);
}

std::int64_t stripRows(const SourceInfo& info) {
  constexpr std::uint64_t kStripBytes = 256 << 10;
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(kStripBytes / rowBytes(info)), 1, info.geometry.dims.y);
}

std::uint64_t stripBytes(const SourceInfo& info) {
  return static_cast<std::uint64_t>(stripRows(info)) * rowBytes(info);
}

std::unique_ptr<SliceRing> sliceRingInMemory(const SourceInfo& info, std::int64_t slices) {
  return std::make_unique<RingInMemory>(RingShape(info, slices));
}

std::unique_ptr<SliceRing> sliceRingOnDisk(const SourceInfo& info, std::int64_t slices,
                                           const std::filesystem::path& directory, FileSystem& disk) {
  return std::make_unique<RingOnDisk>(RingShape(info, slices), stripBytes(info), directory, disk);
}

}  // namespace kiln
