// Numbers compare linear premultiplied values, as in an EXR. The difference picture compares display values: over
// black, sRGB, 8 bits.
#include "image/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.h"
#include "image/srgb.h"

namespace kiln {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void requireEqualSizes(const Image& a, const Image& b) {
  if (a.width == b.width && a.height == b.height) return;
  const auto size = [](const Image& i) { return std::to_string(i.width) + "x" + std::to_string(i.height); };
  throw Error(ErrorCode::kUsage,
              "the pictures have " + size(a) + " and " + size(b) + " pixels; only equal sizes can be compared");
}

// Equal infinities and two NaN differ by 0; a NaN and a number differ by infinity.
double distanceOf(float a, float b) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return 0;
  const double d = std::abs(static_cast<double>(a) - b);
  return std::isnan(d) ? kInfinity : d;
}

double decibel(double sum_of_squares, double count) {
  return sum_of_squares > 0 ? -10 * std::log10(sum_of_squares / count) : kInfinity;
}

// Lee and Ihm §3.3. A premultiplied colour equals the colour over black.
double displayDistance(const float* a, const float* b) {
  if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2]) return 0;
  const SrgbBytes& displayed = SrgbBytes::all();
  int squares = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const int d = displayed.of(a[c]) - displayed.of(b[c]);
    squares += d * d;
  }
  return std::sqrt(squares);
}

// Colour map of Lee and Ihm, Figure 11. unit: sRGB, 0..1.
std::array<double, 3> mapColor(double distance) {
  static constexpr std::array<std::array<double, 3>, 9> kMap = {
      {{1, 1, 1}, {1, 1, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}, {0.5, 0.5, 0.5}, {0, 0, 0}}};
  const auto below = static_cast<std::size_t>(std::min(distance, 7.0));
  const double t = std::min(distance - static_cast<double>(below), 1.0);
  std::array<double, 3> out;
  for (std::size_t c = 0; c < 3; ++c) out[c] = (1 - t) * kMap[below][c] + t * kMap[below + 1][c];
  return out;
}

}  // namespace

ImageDifference compareImages(const Image& a, const Image& b) {
  requireEqualSizes(a, b);
  ImageDifference out;
  double sum = 0, foreground_sum = 0, light_a = 0, light_b = 0;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    const bool foreground = a.rgba[i + 3] > 1.0f / 255 || b.rgba[i + 3] > 1.0f / 255;
    double color = 0, largest = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      const double d = distanceOf(a.rgba[i + c], b.rgba[i + c]);
      largest = std::max(largest, d);
      sum += d * d;
      if (c == 3) continue;
      color += d * d;
      light_a += a.rgba[i + c];
      light_b += b.rgba[i + c];
    }
    if (foreground) {
      ++out.foreground;
      foreground_sum += color;
    }
    if (largest > 0) ++out.differing;
    out.largest = std::max(out.largest, largest);
  }
  out.psnr_db = decibel(sum, static_cast<double>(a.rgba.size()));
  out.foreground_psnr_db = decibel(foreground_sum, 3 * static_cast<double>(out.foreground));
  out.mean_brightness_ratio = light_a == light_b || out.differing == 0 ? 1 : light_b / light_a;
  return out;
}

void DistanceHistogram::add(const DistanceHistogram& other) {
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] += other.pixels[i];
  largest = std::max(largest, other.largest);
}

DistanceHistogram distanceHistogram(const Image& a, const Image& b) {
  requireEqualSizes(a, b);
  DistanceHistogram out;
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    const double distance = displayDistance(&a.rgba[i], &b.rgba[i]);
    ++out.pixels[static_cast<std::size_t>(std::min(std::ceil(distance), 9.0))];
    out.largest = std::max(out.largest, distance);
  }
  return out;
}

Image differenceImage(const Image& a, const Image& b) {
  requireEqualSizes(a, b);
  Image out(a.width, a.height);
  for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
    const std::array<double, 3> color = mapColor(displayDistance(&a.rgba[i], &b.rgba[i]));
    for (std::size_t c = 0; c < 3; ++c) out.rgba[i + c] = static_cast<float>(linearFromSrgb(color[c]));
    out.rgba[i + 3] = 1;
  }
  return out;
}

}  // namespace kiln
