#include "frame/slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/memory/memory.h"
#include "frame/slice_palette.h"
#include "scene/transfer/display_map.h"
#include "store/brick_index.h"
#include "store/codec/brick_block.h"

namespace kiln {
namespace {

// The axes of the volume along the picture's columns and rows.
struct SliceLayout {
  int axis, right, down;
  bool flip_rows;
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
  out.axis = axis;
  out.right = axis == 0 ? 1 : 0;
  out.down = axis == 2 ? 1 : 2;
  out.flip_rows = axis != 2;
  const glm::dvec3 spacing = volume.spacing();
  const double pixel = std::min(spacing[out.right], spacing[out.down]);
  out.voxels_per_column = pixel / spacing[out.right];
  out.voxels_per_row = pixel / spacing[out.down];
  out.width = pixelsOf(static_cast<double>(volume.dims[out.right]) / out.voxels_per_column);
  out.height = pixelsOf(static_cast<double>(volume.dims[out.down]) / out.voxels_per_row);
  return out;
}

// Returns the voxel of each pixel of a line.
std::vector<std::int64_t> voxelsAlong(std::int64_t pixels, double voxels_per_pixel, std::int64_t voxels) {
  std::vector<std::int64_t> out;
  for (std::int64_t i = 0; i < pixels; ++i)
    // A side is rounded up, so the middle of the last pixel may lie outside.
    out.push_back(std::min(static_cast<std::int64_t>((static_cast<double>(i) + 0.5) * voxels_per_pixel), voxels - 1));
  return out;
}

// The pixels of a line whose voxels are in [lo, hi).
struct Pixels {
  std::int64_t begin, end;
};
Pixels pixelsIn(const std::vector<std::int64_t>& voxels, std::int64_t lo, std::int64_t hi) {
  const auto at = [&](std::int64_t voxel) { return std::lower_bound(voxels.begin(), voxels.end(), voxel); };
  return {at(lo) - voxels.begin(), at(hi) - voxels.begin()};
}

// The colour of each value of a slice; null for values that are not drawn.
class SliceColors {
 public:
  SliceColors(const SliceRequest& request, const Manifest& manifest) {
    for (const LabelStyle& style : request.labels) {
      labels_.push_back(style.label);
      if (style.opacity > 0)
        colors_.emplace_back(glm::vec3(style.color));
      else
        colors_.emplace_back();
    }
    if (labels_.empty()) palette_.emplace(request.colormap, request.window.value_or(defaultWindow(manifest.histogram)));
  }
  const glm::vec3* of(double value) const {
    if (palette_) return std::isnan(value) ? nullptr : &palette_->of(value);
    const auto found = std::lower_bound(labels_.begin(), labels_.end(), value);
    if (found == labels_.end() || *found != value) return nullptr;
    const std::optional<glm::vec3>& color = colors_[static_cast<std::size_t>(found - labels_.begin())];
    return color ? &*color : nullptr;
  }

 private:
  std::optional<SlicePalette> palette_;
  std::vector<double> labels_;
  std::vector<std::optional<glm::vec3>> colors_;
};

// Draws the pixels whose voxels are in the brick; `columns` and `rows` are the voxels along the picture's sides.
void drawBrick(const BrickBlock& block, const SliceLayout& layout, const std::vector<std::int64_t>& columns,
               const std::vector<std::int64_t>& rows, std::int64_t index, const SliceColors& colors, Image& image) {
  const VoxelBox& core = block.core;
  const Pixels across = pixelsIn(columns, core.lo[layout.right], core.hi[layout.right]);
  const Pixels along = pixelsIn(rows, core.lo[layout.down], core.hi[layout.down]);
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const T* const voxels = block.data<T>();
    VoxelCoord v;
    v[layout.axis] = index;
    for (std::int64_t row = along.begin; row < along.end; ++row) {
      v[layout.down] = rows[static_cast<std::size_t>(row)];
      const auto y = static_cast<int>(layout.flip_rows ? image.height - 1 - row : row);
      for (std::int64_t x = across.begin; x < across.end; ++x) {
        v[layout.right] = columns[static_cast<std::size_t>(x)];
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
  const std::int64_t count = volume.dims[request.axis];
  const std::int64_t index = request.index.value_or(count / 2);
  if (index < 0 || index >= count)
    throw Error(ErrorCode::kUsage, fmt::format("--index: {} is not between 0 and {}", index, count - 1));
  const SliceColors colors(request, store.manifest());
  const SliceLayout layout = layoutOf(volume, request.axis);
  if (layout.width > kLargestSliceSide || layout.height > kLargestSliceSide) {
    throw Error(ErrorCode::kUsage, fmt::format("a slice of {} x {} pixels is larger than {}", layout.width,
                                               layout.height, kLargestSliceSide));
  }
  requireSliceFits(store, layout.width, layout.height, 4 * sizeof(float), request.memory_bytes);
  Image image(static_cast<int>(layout.width), static_cast<int>(layout.height));
  const std::vector<std::int64_t> columns =
      voxelsAlong(layout.width, layout.voxels_per_column, volume.dims[layout.right]);
  const std::vector<std::int64_t> rows = voxelsAlong(layout.height, layout.voxels_per_row, volume.dims[layout.down]);
  const Extent3& lattice = store.index().lattice(request.level);
  const std::int64_t row = index / store.manifest().brick_size;
  const std::int64_t bricks = lattice[layout.right] * lattice[layout.down];
  for (std::int64_t i = 0; i < bricks; ++i) {
    progress.throwIfCancelled("drawing a slice");
    VoxelCoord brick;
    brick[layout.axis] = row;
    brick[layout.right] = i % lattice[layout.right];
    brick[layout.down] = i / lattice[layout.right];
    const BrickCoord coord{static_cast<std::int32_t>(brick.x), static_cast<std::int32_t>(brick.y),
                           static_cast<std::int32_t>(brick.z)};
    if (const auto block = brick_of({request.level, coord}))
      drawBrick(*block, layout, columns, rows, index, colors, image);
    progress.advance("drawing", "bricks", static_cast<std::uint64_t>(i) + 1, static_cast<std::uint64_t>(bricks));
  }
  return image;
}

}  // namespace kiln
