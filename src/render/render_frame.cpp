#include "render/render_frame.h"

#include <fmt/format.h>

#include <bit>
#include <chrono>
#include <cmath>

#include "render/frame_drawing.h"

namespace kiln {
namespace {

// `image` holds the rows from `first_row` on of a picture of `rows`.
void layOverBackground(Image& image, int first_row, int rows, const Background& background) {
  if (background == Background{}) return;
  for (int y = 0; y < image.height; ++y) {
    // From the middle of the first row to that of the last.
    const double t = rows > 1 ? static_cast<double>(first_row + y) / (rows - 1) : 0;
    float row[4];
    for (std::size_t channel = 0; channel < 4; ++channel)
      row[channel] = static_cast<float>(std::lerp(background.top[channel], background.bottom[channel], t));
    for (int x = 0; x < image.width; ++x) {
      float* pixel = image.pixel(x, y);
      const float open = 1.0f - pixel[3];
      for (int channel = 0; channel < 4; ++channel) pixel[channel] += open * row[channel];
    }
  }
}

void requireRequest(const StoreReader& store, const FrameRequest& request) {
  const int levels = store.index().levels();
  if (request.level && (*request.level < 0 || *request.level >= levels)) {
    throw Error(ErrorCode::kUsage, fmt::format("--level: there is no level {}; {} has {}, from 0 to {}", *request.level,
                                               store.path().string(),
                                               levels == 1 ? "1 level" : fmt::format("{} levels", levels), levels - 1));
  }
  const int tile_px = request.tile_px;
  if (tile_px != 0 && (tile_px < kVisibilityTile || !std::has_single_bit(static_cast<unsigned>(tile_px)))) {
    throw Error(ErrorCode::kUsage, fmt::format("a tile of {} pixels: expected a power of two from {} on, or 0 for the "
                                               "whole frame",
                                               tile_px, kVisibilityTile));
  }
}

}  // namespace

std::vector<BrickInView> bricksInView(const StoreReader& store, const FrameRequest& request, BrickWalkCounts& counts) {
  requireRequest(store, request);
  return FramePlan(store, request).bricks->inView(drawnPixels(request.view.size, request.crop), counts);
}

Image renderFrame(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress,
                  FrameStatistics& statistics) {
  const auto begin = std::chrono::steady_clock::now();
  requireRequest(store, request);
  const PixelRect pixels = drawnPixels(request.view.size, request.crop);
  FrameDrawing drawing(store, cache, request, progress);
  Image image = drawing.draw(pixels);
  statistics = drawing.finish();
  layOverBackground(image, pixels.y0, request.view.size.height, request.background);
  statistics.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return image;
}

}  // namespace kiln
