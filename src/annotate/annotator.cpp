#include "annotate/annotator.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "base/thread/parallel.h"

namespace kiln {
namespace {

// Rows of AnnotatedRows at a time.
constexpr int kBandRows = 16;

std::vector<Shape> shapesOf(const AnnotatedPicture& picture) {
  const Annotations& annotations = picture.annotations;
  const Style style(picture);
  std::vector<Shape> out;
  if (annotations.box) out = outlineOfVolume(picture, style);
  if (!annotations.letters() || !style.legible) return out;
  Drawing drawing(style);
  if (annotations.axes) addAxes(picture, drawing);
  if (annotations.scale_bar) addScaleBar(picture, drawing);
  if (annotations.legend) addLegend(picture, drawing);
  if (!annotations.text.empty()) addText(picture, drawing);
  std::ranges::move(std::move(drawing).take(), std::back_inserter(out));
  return out;
}

}  // namespace

Annotator::Annotator(const AnnotatedPicture& picture) : Annotator(shapesOf(picture), picture.pixels) {}

Annotator::Annotator(std::vector<Shape> shapes, const PixelRect& pixels) : pixels_(pixels) {
  for (Shape& shape : shapes) {
    Coverage coverage(shape.outline);
    shape.outline.clear();
    if (coverage.firstRow() < coverage.endRow()) layers_.push_back({std::move(shape), std::move(coverage)});
  }
}

void Annotator::drawRow(int row, const float* depth, std::vector<float>& rgba) const {
  const auto width = static_cast<std::size_t>(pixels_.width());
  rgba.assign(4 * width, 0.0f);
  std::vector<std::int32_t> sums(width);
  for (const auto& [shape, coverage] : layers_) {
    if (row < coverage.firstRow() || row >= coverage.endRow()) continue;
    const bool darkens = lightness(shape.color) < kMiddleGrey;
    std::ranges::fill(sums, 0);
    coverage.addRow(row, pixels_.x0, sums);
    for (std::size_t x = 0; x < width; ++x) {
      if (sums[x] == 0) continue;
      const float behind = depth == nullptr ? std::numeric_limits<float>::infinity() : depth[x];
      if (shape.depth && !shape.depth->shows({pixels_.x0 + static_cast<double>(x) + 0.5, row + 0.5}, behind)) continue;
      const double covered = static_cast<double>(sums[x]) / Coverage::kFull;
      // Light adds up: a thin dark line over light is lighter to the eye than its share of the pixel.
      const double alpha = shape.opacity * (darkens ? covered * (2 - covered) : covered);
      float* const pixel = rgba.data() + 4 * x;
      for (int channel = 0; channel < 4; ++channel) {
        const double light = channel < 3 ? shape.color[channel] : 1;
        pixel[channel] = static_cast<float>(alpha * light + (1 - alpha) * pixel[channel]);
      }
    }
  }
}

void Annotator::over(Image& image, int column, int first_row, const float* depth) const {
  const auto width = static_cast<std::size_t>(pixels_.width());
  parallelFor(static_cast<std::size_t>(image.height), [&](std::size_t y) {
    std::vector<float> layer;
    drawRow(first_row + static_cast<int>(y), depth == nullptr ? nullptr : depth + y * width, layer);
    float* pixel = image.pixel(column, static_cast<int>(y));
    for (std::size_t x = 0; x < width; ++x, pixel += 4) {
      const float* const top = layer.data() + 4 * x;
      if (top[3] == 0) continue;
      for (int channel = 0; channel < 4; ++channel) pixel[channel] = top[channel] + (1 - top[3]) * pixel[channel];
    }
  });
}

void Annotator::addPlanes(Image& image, int first_row, const float* depth) const {
  const auto width = static_cast<std::size_t>(pixels_.width());
  const std::size_t count = width * static_cast<std::size_t>(image.height);
  std::array<ZeroPages<float>, 4> values;
  for (ZeroPages<float>& of_channel : values) of_channel = ZeroPages<float>(count);
  parallelFor(static_cast<std::size_t>(image.height), [&](std::size_t y) {
    std::vector<float> layer;
    drawRow(first_row + static_cast<int>(y), depth == nullptr ? nullptr : depth + y * width, layer);
    for (std::size_t x = 0; x < width; ++x) {
      if (layer[4 * x + 3] == 0) continue;  // pages without ink cost no memory
      for (std::size_t channel = 0; channel < 4; ++channel) values[channel][y * width + x] = layer[4 * x + channel];
    }
  });
  for (std::size_t channel = 0; channel < 4; ++channel)
    image.planes.push_back({kAnnotationPlanes + std::string(1, "RGBA"[channel]), std::move(values[channel])});
}

const float* depthOf(const Image& image) {
  const auto plane = std::ranges::find(image.planes, "Z", &Plane::name);
  return plane == image.planes.end() ? nullptr : plane->values.data();
}

AnnotatedRows::AnnotatedRows(ImageRows& rows, const Annotator& annotator, const float* depth)
    : ImageRows(rows.width, rows.height), rows_(rows), annotator_(annotator), depth_(depth) {}

std::uint64_t AnnotatedRows::bytesFor(int width) {
  return 4 * sizeof(float) * kBandRows * static_cast<std::uint64_t>(width);
}

ImageRows::Band AnnotatedRows::bandAt(int row) {
  if (band_.height == 0 || row < band_row_ || row >= band_row_ + band_.height) {
    const Band below = rows_.bandAt(row);
    const int rows = std::min({kBandRows, height - row, below.end() - row});
    if (band_.height != rows) band_ = Image(width, rows);
    std::copy_n(below.image->pixel(0, row - below.first_row), band_.rgba.size(), band_.rgba.data());
    band_row_ = row;
    const float* const depth =
        depth_ == nullptr ? nullptr : depth_ + static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
    annotator_.over(band_, 0, annotator_.pixels().y0 + row, depth);
  }
  return {&band_, band_row_};
}

}  // namespace kiln
