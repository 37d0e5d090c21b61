#include "sequence/sheet/slice_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "annotate/edge_letters.h"
#include "base/error.h"
#include "base/memory/memory.h"
#include "base/number_text.h"
#include "frame/histogram_bars.h"
#include "frame/slice_palette.h"
#include "image/plot_image.h"
#include "scene/transfer/display_map.h"
#include "store/brick_index.h"
#include "store/codec/brick_block.h"
#include "store/manifest/store_name.h"

namespace kiln {
namespace {

// unit: pixels.
constexpr int kPanelGap = 8, kPanelCaption = 14, kTextLine = 12, kHistogramHeight = 140, kTextWidth = 420;

const glm::dvec3 kSheetBar{0.45, 0.50, 0.58}, kCrosshair{0.95, 0.60, 0.20};
constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};

struct Panel {
  Image image;
  std::string caption;
};

// Returns the longest side of a level's slices. unit: pixels.
std::int64_t longestSide(const VolumeGeometry& level) {
  std::int64_t longest = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [width, height] = sliceSize(level, axis);
    longest = std::max({longest, width, height});
  }
  return longest;
}

int levelOfSheet(const BrickedVolume& store) {
  const int levels = store.index().levels();
  for (int level = 0; level < levels; ++level) {
    if (longestSide(store.level(level).geometry) <= kSheetSlice_px) return level;
  }
  return levels - 1;
}

// Times that each pixel of small slices is repeated along both sides, equal for all slices of a sheet.
int enlargementOf(const VolumeGeometry& level) {
  constexpr std::int64_t kLeastSlice_px = 192;
  return static_cast<int>(std::max<std::int64_t>(kLeastSlice_px / longestSide(level), 1));
}

// Returns the memory of the sheet and of its three slices. unit: bytes.
std::uint64_t sheetBytes(const BrickedVolume& store, int level) {
  const int times = enlargementOf(store.level(level).geometry);
  std::uint64_t pixels = static_cast<std::uint64_t>(kTextWidth) * kTextWidth;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [width, height] = sliceSize(store.level(level).geometry, axis);
    pixels += 2 * static_cast<std::uint64_t>(width * height * times * times);
  }
  return 4 * sizeof(float) * pixels;
}

void requireSheetFits(const BrickedVolume& store, int level, std::uint64_t memory_bytes) {
  const std::uint64_t bytes = sheetBytes(store, level) + store.largestReadBytes() + store.index().bytes();
  if (bytes <= memory_bytes) return;
  throw Error(ErrorCode::kBudget, store.path(), "--memory",
              fmt::format("{} is too little: a sheet of three slices, a brick and the index take {}; give as much",
                          formatBytes(memory_bytes), formatBytes(bytes)));
}

std::int64_t onLevel(std::int64_t voxel, std::int64_t finest, std::int64_t coarse) {
  return std::min(coarse - 1, voxel * coarse / finest);
}

double valueOf(const BrickedVolume& store, const VoxelCoord& v) {
  const BrickBlock block = store.read({0, brickOf(v, store.manifest().brick_size)});
  return withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(block.data<T>()[block.offsetOf(v)]);
  });
}

// A slice with a crosshair that leaves its middle free, and so much at the edges.
Image withCrosshair(const Image& slice, int x, int y, int edge) {
  constexpr int kFree = 6;
  PlotImage out(slice.width, slice.height, kSheetPaper);
  out.draw(slice, 0, 0);
  out.fill({edge, y, x - kFree, y + 1}, kCrosshair);
  out.fill({x + kFree, y, slice.width - edge, y + 1}, kCrosshair);
  out.fill({x, edge, x + 1, y - kFree}, kCrosshair);
  out.fill({x, y + kFree, x + 1, slice.height - edge}, kCrosshair);
  return std::move(out).take();
}

Image enlarged(Image image, int times) {
  if (times == 1) return image;
  Image out(image.width * times, image.height * times);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) std::copy_n(image.pixel(x / times, y / times), 4, out.pixel(x, y));
  }
  return out;
}

Panel panelOf(const BrickedVolume& store, const SliceSheetRequest& request, const SliceSheet& sheet,
              const SliceView& view, Progress& progress) {
  const int axis = view.across.index;
  const Extent3 finest = store.manifest().geometry().dims, dims = store.level(sheet.level).geometry.dims;
  SliceRequest slice;
  slice.axis = axis;
  slice.level = sheet.level;
  slice.index = onLevel(sheet.at[axis], finest[axis], dims[axis]);
  slice.window = request.window;
  slice.colormap = request.colormap;
  slice.labels = request.labels;
  slice.memory_bytes = request.memory_bytes;
  const Image image = enlarged(renderSlice(store, slice, progress), enlargementOf(store.level(sheet.level).geometry));
  // Returns the pixel of the voxel along a side of so many pixels, as `renderSlice` counts.
  const auto place = [&](const NearestAxis& along, int pixels) {
    const double part =
        (static_cast<double>(sheet.at[along.index]) + 0.5) / static_cast<double>(finest[along.index]) * pixels;
    return static_cast<int>(along.mirrored ? pixels - part : part);
  };
  const int row = place(view.down, image.height);
  const int column = place(view.right, image.width);
  const int edge = request.letters ? edgeLetterRoom({image.width, image.height}) : 0;
  Panel out{withCrosshair(image, column, view.from_bottom ? image.height - 1 - row : row, edge),
            fmt::format("{}{} = {}", *view.plane == 0 ? "" : fmt::format("{}, ", view.plane),
                        kAxes[static_cast<std::size_t>(axis)], sheet.at[axis])};
  if (request.letters) drawEdgeLetters(view.letters, out.image);
  return out;
}

// Draws a panel below its caption.
void draw(PlotImage& sheet, const Panel& panel, int x, int y) {
  sheet.text(x, y + 3, panel.caption, kSheetCaption);
  sheet.draw(panel.image, x, y + kPanelCaption);
}

std::string valueText(double value, const ValueRange& range) {
  constexpr double kSteps = 1000;
  return numberText(value, (range.hi - range.lo) / kSteps);
}

// Draws the bars, and the ends of the window. `window`: null where labels have colours of their own.
void drawHistogram(PlotImage& sheet, const Manifest& manifest, const Window* window, const PixelRect& rect) {
  const ValueHistogram& histogram = manifest.histogram;
  if (!(histogram.hi > histogram.lo)) return;
  const HistogramBars bars(histogram);
  const double width = rect.width();
  const auto valueAt = [&](int x) { return std::lerp(histogram.lo, histogram.hi, (x - rect.x0) / width); };
  for (int x = rect.x0; x < rect.x1; ++x) {
    const double height = bars.over(valueAt(x), valueAt(x + 1));
    sheet.fill({x, rect.y1 - static_cast<int>(height * rect.height()), x + 1, rect.y1}, kSheetBar);
  }
  if (window != nullptr) {
    for (const double end : {window->centre - 0.5 * window->width, window->centre + 0.5 * window->width}) {
      const int x = rect.x0 + static_cast<int>((end - histogram.lo) / (histogram.hi - histogram.lo) * width);
      if (x >= rect.x0 && x < rect.x1) sheet.fill({x, rect.y0, x + 1, rect.y1}, kCrosshair);
    }
  }
  // Bins of labels extend half a label beyond the range.
  const bool labels = manifest.volume_class == VolumeClass::kLabels;
  const ValueRange ends = labels ? manifest.range : ValueRange{histogram.lo, histogram.hi};
  const std::string lo = valueText(ends.lo, ends), hi = valueText(ends.hi, ends);
  sheet.text(rect.x0, rect.y1 + 4, lo, kSheetCaption);
  sheet.text(rect.x1 - PlotImage::textWidth(hi), rect.y1 + 4, hi, kSheetCaption);
}

std::string valuesText(const ValueRange& range) {
  if (range.empty()) return "no value is a number";
  return fmt::format("values {} to {}", valueText(range.lo, range), valueText(range.hi, range));
}

// `window`: null where labels have colours of their own.
std::vector<std::string> linesOf(const BrickedVolume& store, const SliceSheet& sheet, const Window* window) {
  const Manifest& manifest = store.manifest();
  const VolumeGeometry& volume = manifest.geometry();
  const glm::dvec3 spacing = volume.spacing();
  const glm::dvec3 world = volume.worldOf(glm::dvec3(sheet.at.x, sheet.at.y, sheet.at.z));
  const std::string unit = volume.unit.empty() ? "world units" : volume.unit;
  return {volumeNameOf(store.path()),
          fmt::format("{} x {} x {} voxels, {}", volume.dims.x, volume.dims.y, volume.dims.z, nameOf(manifest.type)),
          fmt::format("spacing {:.6g} x {:.6g} x {:.6g} {}", spacing.x, spacing.y, spacing.z, unit),
          fmt::format("{}, {}", valuesText(manifest.range),
                      window == nullptr ? "in colours of labels" : "window " + windowText(*window)),
          fmt::format("voxel {},{},{}: {:.9g}", sheet.at.x, sheet.at.y, sheet.at.z, sheet.value),
          fmt::format("world {:.6g},{:.6g},{:.6g}", world.x, world.y, world.z)};
}

}  // namespace

SliceSheet renderSliceSheet(const BrickedVolume& store, const SliceSheetRequest& request, Progress& progress) {
  const Manifest& manifest = store.manifest();
  const Extent3 dims = manifest.geometry().dims;
  SliceSheet out;
  out.at = request.at.value_or(middleVoxel(manifest.geometry()));
  if (!boxOf(dims).contains(out.at))
    throw Error(ErrorCode::kUsage, fmt::format("--at: expected a voxel from 0,0,0 to {},{},{} (found {},{},{})",
                                               dims.x - 1, dims.y - 1, dims.z - 1, out.at.x, out.at.y, out.at.z));
  out.level = levelOfSheet(store);
  requireSheetFits(store, out.level, request.memory_bytes);
  out.value = valueOf(store, out.at);
  const Window window = request.window.value_or(defaultWindow(manifest.histogram));
  const std::array<SliceView, 3> views = sliceViews(manifest.geometry());
  const auto panel = [&](const SliceView& view) { return panelOf(store, request, out, view, progress); };
  const std::array<Panel, 3> panels = {panel(views[0]), panel(views[1]), panel(views[2])};
  const Window* const shown = request.labels.empty() ? &window : nullptr;
  const std::vector<std::string> lines = linesOf(store, out, shown);
  // Two rows: the axial and the sagittal slice, the coronal slice and the texts. Slices of a column have the same
  // width.
  const auto widthOf = [](const Panel& one) { return std::max(one.image.width, PlotImage::textWidth(one.caption)); };
  const int left = std::max(widthOf(panels[0]), widthOf(panels[1]));
  const int right = std::max(widthOf(panels[2]), kTextWidth);
  const int text_height = static_cast<int>(lines.size()) * kTextLine + kHistogramHeight + 2 * kTextLine;
  const int upper = kPanelCaption + std::max(panels[0].image.height, panels[2].image.height);
  const int lower = std::max(kPanelCaption + panels[1].image.height, text_height);
  PlotImage sheet(left + right + 3 * kPanelGap, upper + lower + 3 * kPanelGap, kSheetPaper);
  const int second_x = 2 * kPanelGap + left, second_y = 2 * kPanelGap + upper;
  draw(sheet, panels[0], kPanelGap, kPanelGap);
  draw(sheet, panels[1], kPanelGap, second_y);
  draw(sheet, panels[2], second_x, kPanelGap);
  int y = second_y;
  for (const std::string& line : lines) {
    sheet.text(second_x, y, line, kSheetInk);
    y += kTextLine;
  }
  drawHistogram(sheet, manifest, shown,
                {second_x, y + kTextLine, second_x + right, y + kTextLine + kHistogramHeight - kTextLine});
  out.image = std::move(sheet).take();
  return out;
}

}  // namespace kiln
