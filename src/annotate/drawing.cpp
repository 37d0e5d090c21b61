#include "annotate/drawing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <iterator>
#include <string>
#include <utility>

#include "annotate/font.h"
#include "annotate/places.h"

namespace kiln {
namespace {

constexpr double kTextsOfSide = 36;  // lines of text, without gaps, along the shorter side
constexpr double kLeastLines = 6;    // lines of the least text along the shorter side; smaller pictures have no letters
constexpr double kDarkInk = 0.005, kLightInk = 1;
constexpr double kRimOpacity = 0.5;

// Lightness of what is behind the volume; transparent counts as paper.
double lightnessOf(const Background& background) {
  double sum = 0;
  for (const auto* const end : {&background.top, &background.bottom}) {
    const auto& color = *end;
    sum += lightness({color[0], color[1], color[2]}) + (1 - color[3]);
  }
  return sum / 2;
}

int shorterSide(const AnnotatedPicture& picture) { return std::min(picture.view.size.width, picture.view.size.height); }

glm::dvec3 inkOf(const AnnotatedPicture& picture) {
  const bool light = lightnessOf(picture.background) > kMiddleGrey;
  return picture.annotations.color.value_or(glm::dvec3(light ? kDarkInk : kLightInk));
}

}  // namespace

double lightness(const glm::dvec3& color) { return glm::dot(color, glm::dvec3(0.2126, 0.7152, 0.0722)); }

bool DepthTest::shows(const glm::dvec2& pixel, float depth) const {
  const glm::dvec2 along = b_px - a_px;
  const double length2 = glm::dot(along, along);
  const double t = length2 > 0 ? std::clamp(glm::dot(pixel - a_px, along) / length2, 0.0, 1.0) : 0;
  const double at = perspective ? 1 / ((1 - t) / a_depth + t / b_depth) : (1 - t) * a_depth + t * b_depth;
  return (at > static_cast<double>(depth) + slack) == shows_hidden;
}

Style::Style(const AnnotatedPicture& picture)
    : Style(std::max(picture.annotations.size * shorterSide(picture) / kTextsOfSide, kLeastText), inkOf(picture)) {
  legible = shorterSide(picture) >= kLeastLines * kLeastText;
}

Style::Style(double font_size, const glm::dvec3& color)
    : em(font_size),
      margin(1.2 * em),
      line(0.09 * em),
      halo(0.11 * em),
      ink(color),
      rim(lightness(color) > kMiddleGrey ? 0 : 1) {}

void Drawing::ink(const Outline& outline, double opacity) { fill(outline, style_.ink, opacity); }

void Drawing::fill(const Outline& outline, const glm::dvec3& color, double opacity) {
  append(rim_, grown(outline, style_.halo));
  shapes_.push_back({outline, color, opacity});
}

double Drawing::text(std::string_view utf8, const glm::dvec2& base, double size, Align align, double opacity) {
  TextLine line = lineOf(utf8, size);
  const double shift = align == Align::kLeft ? 0 : align == Align::kCentre ? line.width / 2 : line.width;
  ink(moved(std::move(line.outline), {base.x - shift, std::round(base.y)}), opacity);
  return line.width;
}

std::vector<Shape> Drawing::take() && {
  std::vector<Shape> out;
  out.push_back({std::move(rim_), style_.rim, kRimOpacity});
  std::ranges::move(shapes_, std::back_inserter(out));
  return out;
}

void addText(const AnnotatedPicture& picture, Drawing& drawing) {
  const Style& style = drawing.style();
  const CornerText text = cornerText(picture, style);
  double base = style.margin + kCapHeight * text.size;
  for (const std::string& line : text.lines) {
    drawing.text(line, {style.margin, base}, text.size, Drawing::Align::kLeft);
    base += kTextPitch * text.size;
  }
}

}  // namespace kiln
