#include "frame/transfer_function_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/number_text.h"
#include "frame/histogram_bars.h"
#include "image/plot_image.h"

namespace kiln {
namespace {

constexpr int kWidth = 960, kHeight = 420;
// The plot and the band of colours below. unit: pixels.
constexpr int kLeft = 56, kRight = 936, kTop = 24, kBottom = 330, kBandTop = 342, kBandBottom = 374;
constexpr double kOpacityTick = 0.25;

const glm::dvec3 kPaper{0.97, 0.97, 0.96}, kGrid{0.88, 0.88, 0.87}, kBar{0.72, 0.76, 0.80}, kInk{0.12, 0.12, 0.13},
    kCurve{0.80, 0.20, 0.10};

double valueAt(const ValueRange& range, double x) {
  return std::lerp(range.lo, range.hi, (x - kLeft) / static_cast<double>(kRight - kLeft));
}

// The slack keeps an opacity midway between two rows, such as 0.9, in one of both, whatever its rounding error.
int rowOf(double opacity) {
  constexpr double kSlack = 1e-6;
  return static_cast<int>(std::floor(std::lerp(kBottom - 1.0, double{kTop}, opacity) + 0.5 - kSlack));
}

// Returns 1, 2 or 5 times a power of ten, for about eight steps over the range.
double tickStep(double range) {
  const double rough = range / 8;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  const double digit = rough / power;
  return power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}

void drawGrid(PlotImage& plot, const ValueRange& range) {
  const double step = tickStep(range.hi - range.lo);
  // Ticks are multiples: a sum of steps would stand still at values that are large beside the step.
  constexpr int kMostTicks = 32;
  const double first = std::ceil(range.lo / step);
  for (int i = 0; i < kMostTicks; ++i) {
    const double tick = (first + i) * step;
    if (tick > range.hi) break;
    const int x = kLeft + static_cast<int>(std::lround((tick - range.lo) / (range.hi - range.lo) * (kRight - kLeft)));
    plot.fill({x, kTop, x + 1, kBandBottom + 6}, kGrid);
    const std::string label = numberText(tick == 0 ? 0 : tick, step);  // not -0
    plot.text(x - PlotImage::textWidth(label) / 2, kBandBottom + 12, label, kInk);
  }
  for (double opacity = 0; opacity <= 1; opacity += kOpacityTick) {
    plot.fill({kLeft, rowOf(opacity), kRight, rowOf(opacity) + 1}, kGrid);
    const std::string label = fmt::format("{:g}", opacity);
    plot.text(kLeft - 8 - PlotImage::textWidth(label), rowOf(opacity) - 3, label, kInk);
  }
}

void drawHistogram(PlotImage& plot, const ValueHistogram& histogram, const ValueRange& range) {
  const HistogramBars bars(histogram);
  // The bar of a single value is wider than a line of the grid, which may hide its middle.
  const int beside = histogram.hi > histogram.lo ? 0 : 1;
  for (int x = kLeft; x < kRight; ++x) {
    const double bar = bars.over(valueAt(range, x - beside), valueAt(range, x + 1 + beside));
    const int height = static_cast<int>(bar * (kBottom - kTop));
    plot.fill({x, kBottom - height, x + 1, kBottom}, kBar);
  }
}

void drawOpacity(PlotImage& plot, const TransferFunction& function, const ValueRange& range) {
  int before = rowOf(function.at(valueAt(range, kLeft)).opacity);
  for (int x = kLeft; x < kRight; ++x) {
    const int row = rowOf(function.at(valueAt(range, x + 0.5)).opacity);
    plot.fill({x, std::min(row, before) - 1, x + 1, std::max(row, before) + 1}, kCurve);
    before = row;
  }
}

// A surface is a bar of its colour, as high as its opacity.
void drawSurfaces(PlotImage& plot, const TransferFunction& function, const ValueRange& range) {
  constexpr int kHalf = 2;
  for (const IsoSurface& surface : function.surfaces) {
    const double share = (surface.value - range.lo) / (range.hi - range.lo);
    const int x = kLeft + static_cast<int>(std::lround(share * (kRight - kLeft)));
    plot.fill({x - kHalf, rowOf(surface.opacity), x + kHalf, kBottom}, surface.color);
    plot.fill({x - kHalf, kBandTop, x + kHalf, kBandBottom}, surface.color);
  }
}

void drawBand(PlotImage& plot, const TransferFunction& function, const ValueRange& range) {
  for (int x = kLeft; x < kRight; ++x) {
    const Classified c = function.at(valueAt(range, x + 0.5));
    for (int channel = 0; channel < 3; ++channel) {
      for (int y = kBandTop; y < kBandBottom; ++y) {
        // The upper half shows the colour, the lower half the colour by its opacity over a checkerboard.
        const bool upper = 2 * y < kBandTop + kBandBottom;
        const double behind = (x / 8 + y / 8) % 2 == 0 ? 0.35 : 0.6;
        const double cover = upper ? 1 : c.opacity;
        plot.pixel(x, y)[channel] = static_cast<float>(std::lerp(behind, c.color[channel], cover));
      }
    }
  }
}

}  // namespace

ValueRange pictureRange(const TransferFunction& function, const ValueHistogram& histogram) {
  ValueRange out;
  for (const TransferPoint& point : function.points) out.include(point.value);
  for (const IsoSurface& surface : function.surfaces) out.include(surface.value);
  if (std::ranges::any_of(histogram.counts, [](std::uint64_t count) { return count > 0; })) {
    out.include(histogram.lo);
    out.include(histogram.hi);
  }
  if (out.empty()) return {0, 1};
  const double wider = out.hi > out.lo ? 0.02 * (out.hi - out.lo) : std::max(1.0, 0.01 * std::abs(out.lo));
  return {out.lo - wider, out.hi + wider};
}

Image transferFunctionPicture(const TransferFunction& function, const ValueHistogram& histogram) {
  const ValueRange range = pictureRange(function, histogram);
  PlotImage plot(kWidth, kHeight, kPaper);
  drawHistogram(plot, histogram, range);
  drawGrid(plot, range);
  if (function.surfaces.empty()) {
    drawBand(plot, function, range);
    drawOpacity(plot, function, range);
  } else {
    drawSurfaces(plot, function, range);
  }
  return std::move(plot).take();
}

}  // namespace kiln
