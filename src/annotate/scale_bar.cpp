#include "annotate/scale_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "annotate/font.h"
#include "annotate/places.h"
#include "annotate/round_numbers.h"
#include "grid/length_unit.h"

namespace kiln {
namespace {

constexpr double kBarOfWidth = 0.22;

}  // namespace

ScaleBar scaleBarOf(const AnnotatedPicture& picture) {
  const View& view = picture.view;
  const double px_per_length =
      view.projection == Projection::kPerspective ? view.focal_px / picture.target_depth : view.focal_px;
  ScaleBar out;
  const std::optional<double>& given = picture.annotations.scale_bar_length;
  out.length = given.value_or(roundNumberBelow(kBarOfWidth * view.size.width / px_per_length));
  out.length_px = out.length * px_per_length;
  out.unit = shownUnit(picture.box.unit);
  if (out.unit.empty()) out.unit = "units";
  out.label = (given ? fmt::format("{}", out.length) : textOfNumber(out.length, out.length)) + " " + out.unit;
  return out;
}

std::optional<double> widthBelowScaleBar(const AnnotatedPicture& picture) {
  const Style style(picture);
  if (!picture.annotations.scale_bar || !scaleBarRoom(picture, style).empty()) return std::nullopt;
  const ScaleBar bar = scaleBarOf(picture);
  return bar.length / bar.length_px * std::max(0.0, picture.view.size.width - 2 * style.margin);
}

void addScaleBar(const AnnotatedPicture& picture, Drawing& drawing) {
  const Style& style = drawing.style();
  const ImageSize& size = picture.view.size;
  const ScaleBar bar = scaleBarOf(picture);
  const double right = size.width - style.margin, left = right - bar.length_px;
  if (scaleBarRoom(picture, style).empty()) return;
  const double thickness = std::max(1.0, std::round(0.22 * style.em));
  const double bottom = std::round(size.height - style.margin);
  drawing.ink({rectangle({left, bottom - thickness}, {right, bottom})});
  const double base = bottom - thickness - 0.45 * style.em;
  const double half = widthOf(bar.label, style.em) / 2;
  drawing.text(bar.label, {std::min((left + right) / 2, right - half), base}, style.em, Drawing::Align::kCentre);
}

}  // namespace kiln
