#include "annotate/scale_bar.h"

#include <algorithm>
#include <cmath>

#include "annotate/font.h"
#include "annotate/round_numbers.h"
#include "grid/length_unit.h"

namespace kiln {
namespace {

constexpr double kMostOfWidth = 0.22;

}  // namespace

ScaleBar scaleBarOf(const AnnotatedPicture& picture) {
  const View& view = picture.view;
  const double px_per_length =
      view.projection == Projection::kPerspective ? view.focal_px / picture.target_depth : view.focal_px;
  ScaleBar out;
  out.length = roundNumberBelow(kMostOfWidth * view.size.width / px_per_length);
  out.length_px = out.length * px_per_length;
  const std::string unit = shownUnit(picture.box.unit);
  out.label = textOfNumber(out.length, out.length) + " " + (unit.empty() ? "units" : unit);
  return out;
}

void addScaleBar(const AnnotatedPicture& picture, Drawing& drawing) {
  const Style& style = drawing.style();
  const ImageSize& size = picture.view.size;
  const ScaleBar bar = scaleBarOf(picture);
  const double right = size.width - style.margin, left = right - bar.length_px;
  const double thickness = std::max(1.0, std::round(0.22 * style.em));
  const double bottom = std::round(size.height - style.margin);
  drawing.ink({rectangle({left, bottom - thickness}, {right, bottom})});
  const double base = bottom - thickness - 0.45 * style.em;
  const double half = lineOf(bar.label, style.em).width / 2;
  drawing.text(bar.label, {std::min((left + right) / 2, right - half), base}, style.em, Drawing::Align::kCentre);
}

}  // namespace kiln
