// Draws one slice of the volume in grey or in the colours of a map, from the bricks that the slice crosses.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/progress.h"
#include "grid/slice_view.h"
#include "image/image.h"
#include "job/transfer_function_choice.h"
#include "scene/transfer/transfer_function.h"
#include "store/bricked_volume.h"

namespace kiln {

/// Longest side of a slice. unit: pixels.
inline constexpr std::int64_t kLargestSliceSide = 65535;

struct SliceRequest {
  int axis = 2;                       // 0 x, 1 y, 2 z
  int level = 0;                      // 0 is finest
  std::optional<std::int64_t> index;  // in voxels of the level; else the middle
  std::optional<Window> window;       // from the first to the last colour; else the middle 99 % of the values
  std::string colormap = "gray";      // one of displayMapNames()
  std::vector<LabelStyle> labels;     // sorted; if there are any, their colours replace window and map
  std::uint64_t memory_bytes = std::uint64_t{2} << 30;
};

/// Returns the axis of voxels across the slices that `name` asks for: x, y or z, or the axis nearest to the patient's
/// for axial, coronal or sagittal. throws: Error kUsage naming --axis.
int sliceAxis(const VolumeGeometry& volume, std::string_view name);

/// Returns the size of a slice along `axis` on a level. shape: columns and rows. unit: pixels.
std::pair<std::int64_t, std::int64_t> sliceSize(const VolumeGeometry& level, int axis);

/// Requires a slice of so many pixels, a brick and the index to fit. throws: Error kBudget.
void requireSliceFits(const BrickedVolume& store, std::int64_t width, std::int64_t height, std::uint64_t pixel_bytes,
                      std::uint64_t memory_bytes);

/// Draws a slice with the sides of its SliceView. A pixel is as wide as the smaller of the two spacings, so the picture
/// has the world's proportions. NaN, and a label without opacity or style, is transparent. memory: 16 bytes a pixel and
/// one brick. throws: Error kUsage (axis, level, index, window, colour map), kBudget; as
/// BrickedVolume::read.
Image renderSlice(const BrickedVolume& store, const SliceRequest& request, Progress& progress);

/// Returns a brick of the volume. A null brick is drawn as nothing.
using BrickOf = std::function<std::shared_ptr<const BrickBlock>(const BrickKey&)>;
/// Draws a slice from bricks that the caller has, such as those of a cache.
Image renderSlice(const BrickedVolume& store, const SliceRequest& request, const BrickOf& brick_of, Progress& progress);

}  // namespace kiln
