#include "scene/transfer/color_space.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "image/srgb.h"

namespace kiln {
namespace {

constexpr double kPi = std::numbers::pi;
const glm::dvec3 kWhitePoint{0.9505, 1.0, 1.089};  // D65, 2°

// Hue in turns, [0, 1).
glm::dvec3 hsvFrom(const glm::dvec3& rgb) {
  const double most = std::max({rgb.r, rgb.g, rgb.b}), least = std::min({rgb.r, rgb.g, rgb.b});
  const double chroma = most - least;
  if (!(chroma > 0)) return {0, 0, most};
  double sixths = 0;
  if (rgb.r == most)
    sixths = (rgb.g - rgb.b) / chroma;
  else if (rgb.g == most)
    sixths = 2 + (rgb.b - rgb.r) / chroma;
  else
    sixths = 4 + (rgb.r - rgb.g) / chroma;
  return {(sixths < 0 ? sixths + 6 : sixths) / 6, chroma / most, most};
}

glm::dvec3 rgbFromHsv(const glm::dvec3& hsv) {
  glm::dvec3 out;
  for (int channel = 0; channel < 3; ++channel) {
    // Distance from the hue of the full channel: red at 0, green at 1/3, blue at 2/3 of a turn.
    double away = std::abs(hsv.x - channel / 3.0);
    away = std::min(away, 1 - away);
    const double pure = std::clamp(2 - 6 * away, 0.0, 1.0);
    out[channel] = hsv.z * (1 - hsv.y * (1 - pure));
  }
  return out;
}

double cubeRoot(double v) { return v > 0.008856 ? std::cbrt(v) : 7.787 * v + 16.0 / 116; }
double cube(double v) { return v * v * v > 0.008856 ? v * v * v : (v - 16.0 / 116) / 7.787; }

glm::dvec3 labFrom(const glm::dvec3& rgb) {
  const double r = linearFromSrgb(rgb.r), g = linearFromSrgb(rgb.g), b = linearFromSrgb(rgb.b);
  const double x = cubeRoot((0.4124 * r + 0.3576 * g + 0.1805 * b) / kWhitePoint.x);
  const double y = cubeRoot((0.2126 * r + 0.7152 * g + 0.0722 * b) / kWhitePoint.y);
  const double z = cubeRoot((0.0193 * r + 0.1192 * g + 0.9505 * b) / kWhitePoint.z);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

// Clips colours outside the gamut: scales all channels down if too bright, raises each channel to 0 if too dark.
glm::dvec3 rgbFromLab(const glm::dvec3& lab) {
  const double v = (lab.x + 16) / 116;
  const double x = kWhitePoint.x * cube(v + lab.y / 500);
  const double y = kWhitePoint.y * cube(v);
  const double z = kWhitePoint.z * cube(v - lab.z / 200);
  glm::dvec3 rgb(srgbFromLinear(3.2406 * x - 1.5372 * y - 0.4986 * z),
                 srgbFromLinear(-0.9689 * x + 1.8758 * y + 0.0415 * z),
                 srgbFromLinear(0.0557 * x - 0.2040 * y + 1.0570 * z));
  rgb /= std::max({1.0, rgb.r, rgb.g, rgb.b});
  return glm::max(rgb, glm::dvec3(0));
}

struct Msh {
  double magnitude, saturation, hue;
};

Msh mshFrom(const glm::dvec3& rgb) {
  const glm::dvec3 lab = labFrom(rgb);
  Msh out{glm::length(lab), 0, 0};
  if (out.magnitude > 0.001) out.saturation = std::acos(std::clamp(lab.x / out.magnitude, -1.0, 1.0));
  if (out.saturation > 0.001) out.hue = std::atan2(lab.z, lab.y);
  return out;
}

glm::dvec3 rgbFromMsh(const Msh& msh) {
  return rgbFromLab({msh.magnitude * std::cos(msh.saturation),
                     msh.magnitude * std::sin(msh.saturation) * std::cos(msh.hue),
                     msh.magnitude * std::sin(msh.saturation) * std::sin(msh.hue)});
}

double angleBetween(double a, double b) {
  const double turned = std::fmod(std::abs(a - b), 2 * kPi);
  return std::min(turned, 2 * kPi - turned);
}

// Returns the hue of an unsaturated end beside a saturated end, so that the change looks even (Moreland, AdjustHue).
double hueBeside(const Msh& saturated, double magnitude) {
  if (saturated.magnitude >= magnitude - 0.1) return saturated.hue;
  const double spin = saturated.saturation *
                      std::sqrt(magnitude * magnitude - saturated.magnitude * saturated.magnitude) /
                      (saturated.magnitude * std::sin(saturated.saturation));
  return saturated.hue > -0.3 * kPi ? saturated.hue + spin : saturated.hue - spin;
}

glm::dvec3 diverging(const glm::dvec3& from, const glm::dvec3& to, double s) {
  constexpr double kGrey = 0.05, kWhitest = 88;
  Msh a = mshFrom(from), b = mshFrom(to);
  // White lies between two distinct hues.
  if (a.saturation > kGrey && b.saturation > kGrey && angleBetween(a.hue, b.hue) > 0.33 * kPi) {
    const Msh white{std::max({a.magnitude, b.magnitude, kWhitest}), 0, 0};
    (s < 0.5 ? b : a) = white;
    s = s < 0.5 ? 2 * s : 2 * s - 1;
  }
  if (a.saturation < kGrey && b.saturation > kGrey)
    a.hue = hueBeside(b, a.magnitude);
  else if (b.saturation < kGrey && a.saturation > kGrey)
    b.hue = hueBeside(a, b.magnitude);
  return rgbFromMsh(
      {std::lerp(a.magnitude, b.magnitude, s), std::lerp(a.saturation, b.saturation, s), std::lerp(a.hue, b.hue, s)});
}

}  // namespace

glm::dvec3 interpolated(ColorSpace space, const glm::dvec3& a, const glm::dvec3& b, double s) {
  switch (space) {
    case ColorSpace::kRgb:
      return glm::mix(a, b, s);
    case ColorSpace::kHsv:
    case ColorSpace::kHsvWrapped: {
      glm::dvec3 from = hsvFrom(a), to = hsvFrom(b);
      if (space == ColorSpace::kHsvWrapped && std::abs(from.x - to.x) > 0.5) (from.x > to.x ? from : to).x -= 1;
      glm::dvec3 between = glm::mix(from, to, s);
      if (between.x < 0) between.x += 1;
      return rgbFromHsv(between);
    }
    case ColorSpace::kLab:
      return rgbFromLab(glm::mix(labFrom(a), labFrom(b), s));
    case ColorSpace::kDiverging:
      return diverging(a, b, s);
    case ColorSpace::kStep:
      break;
  }
  return s > 0 ? b : a;
}

}  // namespace kiln
