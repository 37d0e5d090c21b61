#include "frame/transfer_function_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "image/srgb.h"

namespace kiln {
namespace {

constexpr int kWidth = 960, kHeight = 420;
// The plot and the band of colours below. unit: pixels.
constexpr int kLeft = 56, kRight = 936, kTop = 24, kBottom = 330, kBandTop = 342, kBandBottom = 374;
constexpr double kOpacityTick = 0.25;

const glm::dvec3 kPaper{0.97, 0.97, 0.96}, kGrid{0.88, 0.88, 0.87}, kBar{0.72, 0.76, 0.80}, kInk{0.12, 0.12, 0.13},
    kCurve{0.80, 0.20, 0.10};

// Glyphs of numbers: 3 × 5 pixels a character, rows from the top, the left pixel in the highest bit.
constexpr std::string_view kCharacters = "0123456789-+.e";
constexpr std::array<std::uint16_t, 14> kGlyphs = {
    0b111101101101111, 0b010110010010111, 0b111001111100111, 0b111001111001111, 0b101101111001001,
    0b111100111001111, 0b111100111101111, 0b111001001010010, 0b111101111101111, 0b111101111001111,
    0b000000111000000, 0b000010111010000, 0b000000000000010, 0b000111111100111};
constexpr int kPixel = 2;  // size of a glyph's pixel. unit: pixels of the picture

class Canvas {
 public:
  Canvas() : image(kWidth, kHeight) { fill(0, 0, kWidth, kHeight, kPaper); }

  void fill(int x0, int y0, int x1, int y1, const glm::dvec3& srgb) {
    for (int y = std::max(y0, 0); y < std::min(y1, kHeight); ++y) {
      for (int x = std::max(x0, 0); x < std::min(x1, kWidth); ++x) {
        for (int channel = 0; channel < 3; ++channel)
          image.pixel(x, y)[channel] = static_cast<float>(linearFromSrgb(srgb[channel]));
        image.pixel(x, y)[3] = 1;
      }
    }
  }

  static int widthOf(std::string_view text) { return static_cast<int>(text.size()) * 4 * kPixel - kPixel; }

  void text(int x, int y, std::string_view text) {
    for (const char c : text) {
      const std::size_t place = kCharacters.find(c);
      const std::uint16_t glyph = place == std::string_view::npos ? 0 : kGlyphs[place];
      for (int bit = 0; bit < 15; ++bit) {
        if ((glyph >> (14 - bit) & 1) == 0) continue;
        const int px = x + bit % 3 * kPixel, py = y + bit / 3 * kPixel;
        fill(px, py, px + kPixel, py + kPixel, kInk);
      }
      x += 4 * kPixel;
    }
  }

  Image image;
};

double valueAt(const ValueRange& range, double x) {
  return std::lerp(range.lo, range.hi, (x - kLeft) / static_cast<double>(kRight - kLeft));
}

int rowOf(double opacity) { return static_cast<int>(std::lround(std::lerp(kBottom - 1.0, double{kTop}, opacity))); }

// Returns 1, 2 or 5 times a power of ten, for about eight steps over the range.
double tickStep(double range) {
  const double rough = range / 8;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  const double digit = rough / power;
  return power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}

void drawGrid(Canvas& canvas, const ValueRange& range) {
  const double step = tickStep(range.hi - range.lo);
  for (double tick = std::ceil(range.lo / step) * step; tick <= range.hi; tick += step) {
    const int x = kLeft + static_cast<int>(std::lround((tick - range.lo) / (range.hi - range.lo) * (kRight - kLeft)));
    canvas.fill(x, kTop, x + 1, kBandBottom + 6, kGrid);
    // A sum of steps misses zero by rounding.
    const std::string label = fmt::format("{:.6g}", std::abs(tick) < 1e-9 * step ? 0 : tick);
    canvas.text(x - Canvas::widthOf(label) / 2, kBandBottom + 12, label);
  }
  for (double opacity = 0; opacity <= 1; opacity += kOpacityTick) {
    canvas.fill(kLeft, rowOf(opacity), kRight, rowOf(opacity) + 1, kGrid);
    const std::string label = fmt::format("{:g}", opacity);
    canvas.text(kLeft - 8 - Canvas::widthOf(label), rowOf(opacity) - 5, label);
  }
}

void drawHistogram(Canvas& canvas, const ValueHistogram& histogram, const ValueRange& range) {
  if (histogram.counts.empty() || !(histogram.hi > histogram.lo)) return;
  const double most = std::log1p(static_cast<double>(std::ranges::max(histogram.counts)));
  const auto bins = static_cast<double>(histogram.counts.size());
  for (int x = kLeft; x < kRight; ++x) {
    const double bin = (valueAt(range, x + 0.5) - histogram.lo) / (histogram.hi - histogram.lo) * bins;
    if (!(bin >= 0 && bin < bins) || !(most > 0)) continue;
    const double count = static_cast<double>(histogram.counts[static_cast<std::size_t>(bin)]);
    canvas.fill(x, kBottom - static_cast<int>(std::log1p(count) / most * (kBottom - kTop)), x + 1, kBottom, kBar);
  }
}

void drawOpacity(Canvas& canvas, const TransferFunction& function, const ValueRange& range) {
  int before = rowOf(function.at(valueAt(range, kLeft)).opacity);
  for (int x = kLeft; x < kRight; ++x) {
    const int row = rowOf(function.at(valueAt(range, x + 0.5)).opacity);
    canvas.fill(x, std::min(row, before) - 1, x + 1, std::max(row, before) + 1, kCurve);
    before = row;
  }
}

void drawBand(Canvas& canvas, const TransferFunction& function, const ValueRange& range) {
  for (int x = kLeft; x < kRight; ++x) {
    const Classified c = function.at(valueAt(range, x + 0.5));
    for (int channel = 0; channel < 3; ++channel) {
      for (int y = kBandTop; y < kBandBottom; ++y) {
        // The upper half shows the colour, the lower half the colour by its opacity over a checkerboard.
        const bool upper = 2 * y < kBandTop + kBandBottom;
        const double behind = (x / 8 + y / 8) % 2 == 0 ? 0.35 : 0.6;
        const double cover = upper ? 1 : c.opacity;
        canvas.image.pixel(x, y)[channel] = static_cast<float>(std::lerp(behind, c.color[channel], cover));
      }
    }
  }
}

}  // namespace

ValueRange pictureRange(const TransferFunction& function, const ValueHistogram& histogram) {
  ValueRange out;
  for (const TransferPoint& point : function.points) out.include(point.value);
  if (histogram.hi > histogram.lo) {
    out.include(histogram.lo);
    out.include(histogram.hi);
  }
  if (out.empty()) return {0, 1};
  const double wider = out.hi > out.lo ? 0.02 * (out.hi - out.lo) : std::max(1.0, 0.01 * std::abs(out.lo));
  return {out.lo - wider, out.hi + wider};
}

Image transferFunctionPicture(const TransferFunction& function, const ValueHistogram& histogram) {
  const ValueRange range = pictureRange(function, histogram);
  Canvas canvas;
  drawHistogram(canvas, histogram, range);
  drawGrid(canvas, range);
  drawBand(canvas, function, range);
  drawOpacity(canvas, function, range);
  return std::move(canvas.image);
}

}  // namespace kiln
