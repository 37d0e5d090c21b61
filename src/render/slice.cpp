#include "render/slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/srgb.h"

namespace kiln {
namespace {

constexpr std::int64_t kLargestSide = 65535;

// The value below which `part` of all voxels lie.
double quantile(const ValueHistogram& histogram, double part) {
  double total = 0;
  for (const std::uint64_t count : histogram.counts) total += static_cast<double>(count);
  double below = 0;
  for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
    below += static_cast<double>(histogram.counts[bin]);
    if (below >= part * total) {
      return histogram.lo + (histogram.hi - histogram.lo) * (static_cast<double>(bin) + 0.5) /
                                static_cast<double>(histogram.counts.size());
    }
  }
  return histogram.hi;
}

Window defaultWindow(const ValueHistogram& histogram) {
  const double lo = quantile(histogram, 0.005);
  const double hi = quantile(histogram, 0.995);
  return {(lo + hi) / 2, hi > lo ? hi - lo : 1};
}

// Which axes of the volume run along the picture's columns and rows, and how many pixels a voxel takes.
struct Layout {
  int axis, right, down;
  bool flip_rows;
  std::int64_t width, height;
  double voxels_per_column, voxels_per_row;
};

Layout layoutOf(const VolumeGeometry& volume, int axis) {
  Layout out{};
  out.axis = axis;
  out.right = axis == 0 ? 1 : 0;
  out.down = axis == 2 ? 1 : 2;
  out.flip_rows = axis != 2;
  const glm::dvec3 spacing = volume.spacing();
  const double pixel = std::min(spacing[out.right], spacing[out.down]);
  out.voxels_per_column = pixel / spacing[out.right];
  out.voxels_per_row = pixel / spacing[out.down];
  out.width =
      std::max<std::int64_t>(std::llround(static_cast<double>(volume.dims[out.right]) / out.voxels_per_column), 1);
  out.height = std::max<std::int64_t>(std::llround(static_cast<double>(volume.dims[out.down]) / out.voxels_per_row), 1);
  return out;
}

// Draws the pixels whose voxels are in the brick.
void drawBrick(const BrickBlock& block, const Layout& layout, std::int64_t index, const Window& window, Image& image) {
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const T* const voxels = block.data<T>();
    const auto voxelAt = [](std::int64_t pixel, double step) {
      return static_cast<std::int64_t>((static_cast<double>(pixel) + 0.5) * step);
    };
    for (int y = 0; y < image.height; ++y) {
      VoxelCoord v;
      v[layout.axis] = index;
      v[layout.down] = voxelAt(layout.flip_rows ? image.height - 1 - y : y, layout.voxels_per_row);
      if (v[layout.down] < block.core.lo[layout.down] || v[layout.down] >= block.core.hi[layout.down]) continue;
      for (int x = 0; x < image.width; ++x) {
        v[layout.right] = voxelAt(x, layout.voxels_per_column);
        if (!block.core.contains(v)) continue;
        const double value = static_cast<double>(voxels[block.offsetOf(v)]);
        if (std::isnan(value)) continue;
        const double grey = std::clamp((value - window.centre) / window.width + 0.5, 0.0, 1.0);
        float* const pixel = image.pixel(x, y);
        // The grey is meant as display value; pictures in memory are linear light.
        pixel[0] = pixel[1] = pixel[2] = static_cast<float>(linearFromSrgb(grey));
        pixel[3] = 1;
      }
    }
  });
}

}  // namespace

Image renderSlice(const StoreReader& store, const SliceRequest& request, Progress& progress) {
  const VolumeGeometry& volume = store.manifest().geometry();
  if (request.axis < 0 || request.axis > 2) throw Error(ErrorCode::kUsage, "--axis: expected x, y or z");
  const std::int64_t count = volume.dims[request.axis];
  const std::int64_t index = request.index.value_or(count / 2);
  if (index < 0 || index >= count)
    throw Error(ErrorCode::kUsage, fmt::format("--index: {} is not between 0 and {}", index, count - 1));
  const Window window = request.window.value_or(defaultWindow(store.manifest().histogram));
  if (!(window.width > 0) || !std::isfinite(window.centre))
    throw Error(ErrorCode::kUsage, "--window: the width must be positive");
  const Layout layout = layoutOf(volume, request.axis);
  if (layout.width > kLargestSide || layout.height > kLargestSide) {
    throw Error(ErrorCode::kUsage,
                fmt::format("a slice of {} x {} pixels is larger than {}", layout.width, layout.height, kLargestSide));
  }
  Image image(static_cast<int>(layout.width), static_cast<int>(layout.height));
  const Extent3& lattice = store.index().lattice(0);
  const std::int64_t row = index / store.manifest().brick_size;
  const std::int64_t bricks = lattice[layout.right] * lattice[layout.down];
  for (std::int64_t i = 0; i < bricks; ++i) {
    progress.throwIfCancelled("drawing a slice");
    VoxelCoord brick;
    brick[layout.axis] = row;
    brick[layout.right] = i % lattice[layout.right];
    brick[layout.down] = i / lattice[layout.right];
    drawBrick(store.read({0,
                          {static_cast<std::int32_t>(brick.x), static_cast<std::int32_t>(brick.y),
                           static_cast<std::int32_t>(brick.z)}}),
              layout, index, window, image);
    progress.advance("drawing", "bricks", static_cast<std::uint64_t>(i) + 1, static_cast<std::uint64_t>(bricks));
  }
  return image;
}

}  // namespace kiln
