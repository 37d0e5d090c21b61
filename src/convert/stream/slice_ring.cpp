#include "convert/stream/slice_ring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "base/error.h"
#include "base/memory/large_pages.h"
#include "base/memory/memory.h"

namespace kiln {
namespace {

constexpr std::uint64_t kStripBytes = 256 << 10;
// A read costs about 1 µs beside its bytes, the time to inflate 1 KiB: smaller slices are read together.
constexpr std::uint64_t kThinBytes = 1 << 10;

std::uint64_t rowBytes(const SourceInfo& info) {
  return static_cast<std::uint64_t>(info.geometry.dims.x) * sizeOf(info.type);
}

class RingInMemory : public SliceRing {
 public:
  RingInMemory(const SourceInfo& info, std::int64_t slices)
      : dims_(info.geometry.dims),
        voxel_(sizeOf(info.type)),
        slices_(slices),
        bytes_(static_cast<std::size_t>(slices) * sliceBytes(info)) {}

  std::int64_t slices() const override { return slices_; }
  std::int64_t slicesAtOnce() const override {
    const auto slice = static_cast<std::uint64_t>(dims_.x * dims_.y) * voxel_;
    return slice < kThinBytes ? static_cast<std::int64_t>(kStripBytes / slice) : 1;
  }

  void read(VolumeSource& source, const VoxelBox& rows) override {
    source.read(rows, {bytes_.data() + offsetOf(rows.lo), static_cast<std::size_t>(rows.count()) * voxel_});
  }

  void copy(const VoxelBox& box, std::span<std::byte> out) const override {
    const std::size_t row = static_cast<std::size_t>(box.extent().x) * voxel_;
    std::byte* to = out.data();
    for (VoxelCoord from = box.lo; from.z < box.hi.z; ++from.z) {
      for (from.y = box.lo.y; from.y < box.hi.y; ++from.y, to += row)
        std::memcpy(to, bytes_.data() + offsetOf(from), row);
    }
  }

 private:
  std::size_t offsetOf(const VoxelCoord& v) const {
    return static_cast<std::size_t>((v.z % slices_ * dims_.y + v.y) * dims_.x + v.x) * voxel_;
  }

  const Extent3 dims_;
  const std::size_t voxel_;
  const std::int64_t slices_;
  UnsetBytes bytes_;
};

// In the file, a slice is stored in columns as wide as a usual brick, row after row. So a box is read in a few long
// runs; one read per short row would take longer than encoding.
class RingOnDisk : public SliceRing {
 public:
  RingOnDisk(const SourceInfo& info, std::int64_t slices, const std::filesystem::path& directory, FileSystem& disk)
      : dims_(info.geometry.dims),
        voxel_(sizeOf(info.type)),
        slices_(slices),
        slice_bytes_(sliceBytes(info)),
        disk_(disk),
        file_(disk.makeScratch(directory)),
        strip_(stripBytes(info)) {}

  std::int64_t slices() const override { return slices_; }

  void read(VolumeSource& source, const VoxelBox& rows) override {
    const std::span<std::byte> strip = std::span(strip_).first(static_cast<std::size_t>(rows.count()) * voxel_);
    source.read(rows, strip);
    std::vector<std::byte> run;
    forEachColumn(rows, [&](const VoxelBox& column) {
      const std::size_t row = static_cast<std::size_t>(column.extent().x) * voxel_;
      run.resize(static_cast<std::size_t>(rows.extent().y) * row);
      const std::byte* from = strip.data() + static_cast<std::size_t>(column.lo.x) * voxel_;
      for (std::size_t done = 0; done < run.size(); done += row, from += static_cast<std::size_t>(dims_.x) * voxel_) {
        std::memcpy(run.data() + done, from, row);
      }
      write(offsetOf(column.lo, column), run);
    });
  }

  void copy(const VoxelBox& box, std::span<std::byte> out) const override {
    const Extent3 n = box.extent();
    const std::size_t line = static_cast<std::size_t>(n.x) * voxel_;
    std::vector<std::byte> run;
    forEachColumn(box, [&](const VoxelBox& column) {
      const std::size_t stride = static_cast<std::size_t>(column.extent().x) * voxel_;
      const std::int64_t first = std::max(box.lo.x, column.lo.x), end = std::min(box.hi.x, column.hi.x);
      const std::size_t row = static_cast<std::size_t>(end - first) * voxel_;
      run.resize(static_cast<std::size_t>(n.y) * stride);
      std::byte* to = out.data() + static_cast<std::size_t>(first - box.lo.x) * voxel_;
      for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
        file_.readAt(offsetOf({column.lo.x, box.lo.y, z}, column), run);
        const std::byte* from = run.data() + static_cast<std::size_t>(first - column.lo.x) * voxel_;
        for (std::int64_t y = 0; y < n.y; ++y, from += stride, to += line) std::memcpy(to, from, row);
      }
    });
  }

 private:
  static constexpr std::int64_t kColumn = 128;  // voxels

  // Calls `body` for each column that `box` touches, over the column's whole width.
  template <class Body>
  void forEachColumn(const VoxelBox& box, Body&& body) const {
    for (std::int64_t x = box.lo.x / kColumn * kColumn; x < box.hi.x; x += kColumn) {
      body(VoxelBox{{x, box.lo.y, box.lo.z}, {std::min(x + kColumn, dims_.x), box.hi.y, box.hi.z}});
    }
  }
  // Returns the file position of a voxel row within the column. unit: bytes.
  std::uint64_t offsetOf(const VoxelCoord& at, const VoxelBox& column) const {
    const std::int64_t before = column.lo.x * dims_.y + at.y * column.extent().x;
    return static_cast<std::uint64_t>(at.z % slices_) * slice_bytes_ + static_cast<std::uint64_t>(before) * voxel_;
  }

  void write(std::uint64_t offset, std::span<const std::byte> run) {
    try {
      disk_.writeAt(file_, offset, run);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kNoSpace) throw;
      throw Error(ErrorCode::kNoSpace, file_.path(), "",
                  fmt::format("no space for the {} of slices that are kept beside the store while it is made; free "
                              "space, choose another place, or give --memory for them",
                              formatBytes(static_cast<std::uint64_t>(slices_) * slice_bytes_)));
    }
  }

  const Extent3 dims_;
  const std::size_t voxel_;
  const std::int64_t slices_;
  const std::uint64_t slice_bytes_;
  FileSystem& disk_;
  File file_;
  std::vector<std::byte> strip_;
};

}  // namespace

std::uint64_t sliceBytes(const SourceInfo& info) {
  return static_cast<std::uint64_t>(info.geometry.dims.y) * rowBytes(info);
}

std::int64_t stripRows(const SourceInfo& info) {
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(kStripBytes / rowBytes(info)), 1, info.geometry.dims.y);
}

std::uint64_t stripBytes(const SourceInfo& info) {
  return static_cast<std::uint64_t>(stripRows(info)) * rowBytes(info);
}

std::unique_ptr<SliceRing> sliceRingInMemory(const SourceInfo& info, std::int64_t slices) {
  return std::make_unique<RingInMemory>(info, slices);
}

std::unique_ptr<SliceRing> sliceRingOnDisk(const SourceInfo& info, std::int64_t slices,
                                           const std::filesystem::path& directory, FileSystem& disk) {
  return std::make_unique<RingOnDisk>(info, slices, directory, disk);
}

}  // namespace kiln
