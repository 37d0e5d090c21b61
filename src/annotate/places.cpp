#include "annotate/places.h"

#include <algorithm>
#include <cmath>

#include "annotate/font.h"
#include "annotate/orientation.h"
#include "annotate/scale_bar.h"
#include "base/text.h"
#include "scene/annotation_text.h"

namespace kiln {
namespace {

// unit: the font's size.
constexpr double kSmallestText = 0.5;  // text in the corner, relative to other text
// Height to width of a picture beyond which a fitted volume leaves room above itself: a legend goes there.
constexpr double kTall = 1.2;

std::vector<std::string> linesOf(std::string_view text) {
  std::vector<std::string> out;
  for (const std::string_view line : splitAt(text, '\n')) out.emplace_back(line);
  return out;
}

bool meet(const Room& a, double x0, double x1) { return !a.empty() && a.x0 < x1 && x0 < a.x1; }

}  // namespace

std::string cutToWidth(std::string_view utf8, double size, double width) {
  if (widthOf(utf8, size) <= width) return std::string(utf8);
  // The beginnings of characters.
  std::vector<std::size_t> ends = {0};
  while (ends.back() < utf8.size())
    ends.push_back(ends.back() + std::max<std::size_t>(bytesOfCharacter(utf8.substr(ends.back())), 1));
  const auto beginning = [&](std::size_t characters) {
    return std::string(utf8.substr(0, std::min(ends[characters], utf8.size()))) + "…";
  };
  const auto fits = [&](std::size_t characters) { return widthOf(beginning(characters), size) <= width; };
  std::size_t most = 0, beyond = ends.size();
  while (beyond - most > 1) {
    const std::size_t middle = most + (beyond - most) / 2;
    (fits(middle) ? most : beyond) = middle;
  }
  return beginning(most);
}

CornerText cornerText(const AnnotatedPicture& picture, const Style& style) {
  CornerText out;
  if (picture.annotations.text.empty()) return out;
  out.lines = linesOf(withSingleBraces(picture.annotations.text));
  const double width = picture.view.size.width - 2 * style.margin;
  double widest = 0;
  for (const std::string& line : out.lines) widest = std::max(widest, widthOf(line, style.em));
  const double least = std::min(style.em, std::max(kSmallestText * style.em, kLeastText));
  out.size = widest > width ? std::max(style.em * width / widest, least) : style.em;
  const Room below = directionsRoom(picture, style);
  const double end = below.empty() ? picture.view.size.height - style.margin : below.y0 - kApart * style.em;
  const auto most = static_cast<std::size_t>(std::max(1.0, (end - style.margin) / (kTextPitch * out.size)));
  if (out.lines.size() > most) {
    out.lines.resize(most);
    out.lines.back() = "…";
  }
  out.room = {style.margin, style.margin, style.margin,
              style.margin + kTextPitch * out.size * static_cast<double>(out.lines.size())};
  for (std::string& line : out.lines) {
    line = cutToWidth(line, out.size, width);
    out.room.x1 = std::max(out.room.x1, style.margin + widthOf(line, out.size));
  }
  return out;
}

Room scaleBarRoom(const AnnotatedPicture& picture, const Style& style) {
  if (!picture.annotations.scale_bar) return {};
  const ScaleBar bar = scaleBarOf(picture);
  const double right = picture.view.size.width - style.margin, bottom = picture.view.size.height - style.margin;
  if (right - bar.length_px < style.margin) return {};
  return {right - std::max(bar.length_px, widthOf(bar.label, style.em)), bottom - 1.5 * style.em, right, bottom};
}

Room directionsRoom(const AnnotatedPicture& picture, const Style& style) {
  return picture.annotations.axes ? placeOfDirections(picture, style) : Room{};
}

Room placeOfDirections(const AnnotatedPicture& picture, const Style& style) {
  const double across = 2 * (kArmLength + kLetterGap + 0.5) * style.em;
  const double left = style.margin, right = left + across;
  const Room bar = scaleBarRoom(picture, style);
  const double bottom =
      meet(bar, left, right + kApart * style.em) ? bar.y0 - kApart * style.em : picture.view.size.height - style.margin;
  return {left, bottom - across, right, bottom};
}

bool standsLeft(LegendPlace place) {
  return place == LegendPlace::kLeft || place == LegendPlace::kTopLeft || place == LegendPlace::kBottomLeft;
}

LegendPlace legendPlaceOf(const AnnotatedPicture& picture) {
  const ImageSize& size = picture.view.size;
  return picture.annotations.legend_place.value_or(size.height > kTall * size.width ? LegendPlace::kTopRight
                                                                                    : LegendPlace::kRight);
}

Room legendRoom(const AnnotatedPicture& picture, const Style& style, double width) {
  const ImageSize& size = picture.view.size;
  Room out{style.margin, style.margin, size.width - style.margin, size.height - style.margin};
  if (standsLeft(legendPlaceOf(picture)))
    out.x1 = std::min(out.x0 + width, out.x1);
  else
    out.x0 = std::max(out.x1 - width, 0.0);
  const double gap = kApart * style.em;
  const Room text = cornerText(picture, style).room;
  if (meet(text, out.x0 - gap, out.x1 + gap)) out.y0 = text.y1 + gap;
  for (const Room& below : {scaleBarRoom(picture, style), directionsRoom(picture, style)}) {
    if (meet(below, out.x0 - gap, out.x1 + gap)) out.y1 = std::min(out.y1, below.y0 - gap);
  }
  return out;
}

}  // namespace kiln
