#include "frame/slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <vector>

#include "base/error.h"
#include "base/memory/memory.h"
#include "frame/slice_palette.h"
#include "scene/transfer/display_map.h"
#include "store/brick_index.h"
#include "store/codec/brick_block.h"

namespace kiln {
namespace {

// The pixels of a slice, and their axes of voxels.
struct SliceLayout {
  SliceView view;
  double voxels_per_column, voxels_per_row;
  std::int64_t width, height;
};

// Returns the pixels of a side, at least 1. The upper bound, far beyond the largest picture, keeps the rounding
// defined.
std::int64_t pixelsOf(double pixels) {
  constexpr double kMost = 1e8;
  return std::llround(std::clamp(pixels, 1.0, kMost));
}

SliceLayout layoutOf(const VolumeGeometry& volume, int axis) {
  SliceLayout out{};
  out.view = sliceViewAcross(volume, axis);
  const int right = out.view.right.index, down = out.view.down.index;
  const glm::dvec3 spacing = volume.spacing();
  const double pixel = std::min(spacing[right], spacing[down]);
  out.voxels_per_column = pixel / spacing[right];
  out.voxels_per_row = pixel / spacing[down];
  out.width = pixelsOf(static_cast<double>(volume.dims[right]) / out.voxels_per_column);
  out.height = pixelsOf(static_cast<double>(volume.dims[down]) / out.voxels_per_row);
  return out;
}

// The pixels of a line whose voxels are in a brick.
struct Pixels {
  std::int64_t begin, end;
};

// The voxel of each pixel along a side of the picture. Pixels of a mirrored axis count its voxels from the far end, so
// that rounding treats mirrored and unmirrored volumes alike.
class VoxelLine {
 public:
  VoxelLine(const NearestAxis& axis, std::int64_t pixels, double voxels_per_pixel, std::int64_t voxels)
      : axis_(axis), voxels_(voxels) {
    for (std::int64_t i = 0; i < pixels; ++i)
      // A side is rounded up, so the middle of the last pixel may lie outside.
      counted_.push_back(
          std::min(static_cast<std::int64_t>((static_cast<double>(i) + 0.5) * voxels_per_pixel), voxels - 1));
  }
  std::int64_t voxelOf(std::int64_t pixel) const {
    const std::int64_t counted = counted_[static_cast<std::size_t>(pixel)];
    return axis_.mirrored ? voxels_ - 1 - counted : counted;
  }
  Pixels pixelsIn(const VoxelBox& box) const {
    const std::int64_t lo = box.lo[axis_.index], hi = box.hi[axis_.index];
    return axis_.mirrored ? between(voxels_ - hi, voxels_ - lo) : between(lo, hi);
  }

 private:
  Pixels between(std::int64_t lo, std::int64_t hi) const {
    const auto at = [&](std::int64_t count) { return std::ranges::lower_bound(counted_, count) - counted_.begin(); };
    return {at(lo), at(hi)};
  }
  NearestAxis axis_;
  std::int64_t voxels_;
  std::vector<std::int64_t> counted_;
};

// Draws the pixels whose voxels are in the brick.
void drawBrick(const BrickBlock& block, const SliceView& view, const VoxelLine& columns, const VoxelLine& rows,
               std::int64_t index, const SliceColors& colors, Image& image) {
  const Pixels across = columns.pixelsIn(block.core), along = rows.pixelsIn(block.core);
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const T* const voxels = block.data<T>();
    VoxelCoord v;
    v[view.across.index] = index;
    for (std::int64_t row = along.begin; row < along.end; ++row) {
      v[view.down.index] = rows.voxelOf(row);
      const auto y = static_cast<int>(view.from_bottom ? image.height - 1 - row : row);
      for (std::int64_t x = across.begin; x < across.end; ++x) {
        v[view.right.index] = columns.voxelOf(x);
        if (!block.shown.shows(v)) continue;
        const glm::vec3* const color = colors.of(static_cast<double>(voxels[block.offsetOf(v)]));
        if (color == nullptr) continue;
        float* const pixel = image.pixel(static_cast<int>(x), y);
        for (int channel = 0; channel < 3; ++channel) pixel[channel] = (*color)[channel];
        pixel[3] = 1;
      }
    }
  });
}

}  // namespace

int sliceAxis(const VolumeGeometry& volume, std::string_view name) {
  constexpr std::string_view kAxes = "xyz";
  if (name.size() == 1 && kAxes.find(name) != std::string_view::npos) return static_cast<int>(kAxes.find(name));
  const bool is_plane = name == "axial" || name == "coronal" || name == "sagittal";
  for (const SliceView& view : sliceViews(volume)) {
    if (is_plane && view.plane == name) return view.across.index;
  }
  if (is_plane)
    throw Error(ErrorCode::kUsage,
                fmt::format("--axis: {} needs the patient's directions, which the volume does not state; give x, y or "
                            "z, or convert the volume with --orient",
                            name));
  throw Error(ErrorCode::kUsage,
              fmt::format("--axis: expected x, y, z, axial, coronal or sagittal (found '{}')", name));
}

std::pair<std::int64_t, std::int64_t> sliceSize(const VolumeGeometry& level, int axis) {
  const SliceLayout layout = layoutOf(level, axis);
  return {layout.width, layout.height};
}

void requireSliceFits(const BrickedVolume& store, std::int64_t width, std::int64_t height, std::uint64_t pixel_bytes,
                      std::uint64_t memory_bytes) {
  const std::uint64_t bytes =
      pixel_bytes * static_cast<std::uint64_t>(width * height) + store.largestReadBytes() + store.index().bytes();
  if (bytes <= memory_bytes) return;
  throw Error(ErrorCode::kBudget, store.path(), "--memory",
              fmt::format("{} is too little: a slice of {} x {} pixels, a brick and the index take {}; a coarser one "
                          "(--level) takes less",
                          formatBytes(memory_bytes), width, height, formatBytes(bytes)));
}

Image renderSlice(const BrickedVolume& store, const SliceRequest& request, Progress& progress) {
  const auto read = [&](const BrickKey& key) { return std::make_shared<const BrickBlock>(store.read(key)); };
  return renderSlice(store, request, read, progress);
}

Image renderSlice(const BrickedVolume& store, const SliceRequest& request, const BrickOf& brick_of,
                  Progress& progress) {
  if (request.axis < 0 || request.axis > 2) throw Error(ErrorCode::kUsage, "--axis: expected x, y or z");
  store.requireLevel(request.level);
  const VolumeGeometry& volume = store.level(request.level).geometry;
  const SliceLayout layout = layoutOf(volume, request.axis);
  const SliceView& view = layout.view;
  const std::int64_t count = volume.dims[request.axis];
  const std::int64_t index = request.index.value_or(SliceView::middle(view.across, volume.dims));
  if (index < 0 || index >= count)
    throw Error(ErrorCode::kUsage, fmt::format("--index: {} is not between 0 and {}", index, count - 1));
  const SliceColors colors(request.labels, request.colormap,
                           request.window.value_or(defaultWindow(store.manifest().histogram)));
  if (layout.width > kLargestSliceSide || layout.height > kLargestSliceSide) {
    throw Error(ErrorCode::kUsage, fmt::format("a slice of {} x {} pixels is larger than {}", layout.width,
                                               layout.height, kLargestSliceSide));
  }
  requireSliceFits(store, layout.width, layout.height, 4 * sizeof(float), request.memory_bytes);
  Image image(static_cast<int>(layout.width), static_cast<int>(layout.height));
  const auto lineOf = [&](const NearestAxis& axis, std::int64_t pixels, double voxels_per_pixel) {
    return VoxelLine(axis, pixels, voxels_per_pixel, volume.dims[axis.index]);
  };
  const VoxelLine columns = lineOf(view.right, layout.width, layout.voxels_per_column);
  const VoxelLine rows = lineOf(view.down, layout.height, layout.voxels_per_row);
  const Extent3& lattice = store.index().lattice(request.level);
  const std::int64_t row = index / store.manifest().brick_size;
  const std::int64_t bricks = lattice[view.right.index] * lattice[view.down.index];
  for (std::int64_t i = 0; i < bricks; ++i) {
    progress.throwIfCancelled("drawing a slice");
    VoxelCoord brick;
    brick[request.axis] = row;
    brick[view.right.index] = i % lattice[view.right.index];
    brick[view.down.index] = i / lattice[view.right.index];
    const BrickCoord coord{static_cast<std::int32_t>(brick.x), static_cast<std::int32_t>(brick.y),
                           static_cast<std::int32_t>(brick.z)};
    if (const auto block = brick_of({request.level, coord}))
      drawBrick(*block, view, columns, rows, index, colors, image);
    progress.advance("drawing", "bricks", static_cast<std::uint64_t>(i) + 1, static_cast<std::uint64_t>(bricks));
  }
  return image;
}

}  // namespace kiln
