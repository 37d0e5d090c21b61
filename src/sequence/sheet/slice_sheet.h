// The first look at a volume: three slices through a point with a crosshair, the histogram, and the values there.
#pragma once

#include <optional>
#include <string>

#include "base/progress.h"
#include "frame/slice.h"
#include "grid/coords.h"
#include "image/image.h"
#include "store/bricked_volume.h"

namespace kiln {

struct SliceSheetRequest {
  std::optional<VoxelCoord> at;  // of level 0; else the middle
  std::optional<Window> window;
  std::string colormap = "gray";
  bool letters = true;             // draws letters of the patient's sides
  std::vector<LabelStyle> labels;  // as SliceRequest::labels
  std::uint64_t memory_bytes = std::uint64_t{2} << 30;
};

struct SliceSheet {
  Image image;
  VoxelCoord at;
  double value = 0;  // of the voxel `at`
  int level = 0;  // of the slices: the finest whose slices are at most kSheetSlice_px wide and high, else the coarsest
};

inline constexpr std::int64_t kSheetSlice_px = 512;

/// Draws the sheet. throws: as renderSlice; Error kUsage if `at` is outside the volume; kUnsupported for letters
/// without a font.
SliceSheet renderSliceSheet(const BrickedVolume& store, const SliceSheetRequest& request, Progress& progress);

}  // namespace kiln
