#include "annotate/legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "annotate/font.h"
#include "annotate/round_numbers.h"

namespace kiln {
namespace {

// unit: the font's size.
constexpr double kBarWidth = 0.9, kBarHeight = 13, kTick = 0.3, kGap = 0.3, kPitch = 1.5, kSquare = 1, kNumbers = 0.9;
constexpr int kMostTicks = 7;

// The values that the function shows; where values are projected, all values between its ends.
ValueRange valuesOf(const AnnotatedPicture& picture) {
  const std::vector<TransferPoint>& points = picture.function.points;
  ValueRange out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool shown = picture.projected || points[i].opacity > 0 || (i > 0 && points[i - 1].opacity > 0) ||
                       (i + 1 < points.size() && points[i + 1].opacity > 0);
    if (shown) out.include(points[i].value);
  }
  if (!(out.lo < out.hi)) out.include(picture.values);
  if (!(out.lo < out.hi)) out = {out.empty() ? 0 : out.lo, out.empty() ? 1 : out.lo + 1};
  return out;
}

// Returns the width of the widest text. unit: pixels.
template <class Texts, class TextOf>
double widest(const Texts& texts, double size, const TextOf& text_of) {
  double out = 0;
  for (const auto& text : texts) out = std::max(out, lineOf(text_of(text), size).width);
  return out;
}

std::string tickText(const ColorBar& bar, double tick) {
  const double step = bar.ticks.size() > 1 ? bar.ticks[1] - bar.ticks[0] : std::abs(tick);
  return textOfNumber(tick, step);
}

void addTitle(const AnnotatedPicture& picture, double left, double top, Drawing& drawing) {
  const std::string& title = picture.annotations.legend_title;
  if (title.empty()) return;
  const Style& style = drawing.style();
  const double right = picture.view.size.width - style.margin;
  const bool fits = left + lineOf(title, style.em).width <= right;
  drawing.text(title, {fits ? left : right, top - 0.7 * style.em}, style.em,
               fits ? Drawing::Align::kLeft : Drawing::Align::kRight);
}

void addBar(const AnnotatedPicture& picture, Drawing& drawing) {
  const Style& style = drawing.style();
  const ColorBar bar = colorBarOf(picture, style);
  const auto at = [](int x, int y) { return glm::dvec2(x, y); };
  const double border = std::max(1.0, std::round(style.line));
  drawing.ink({rectangle(at(bar.at.x0, bar.at.y0) - border, at(bar.at.x1, bar.at.y1) + border)});
  for (int row = bar.at.y0; row < bar.at.y1; ++row)
    drawing.plain(
        {{rectangle(at(bar.at.x0, row), at(bar.at.x1, row + 1))}, picture.function.at(bar.valueOfRow(row)).color});
  for (const double tick : bar.ticks) {
    const double y = bar.heightOf(tick), x = bar.at.x1 + border;
    drawing.ink(stroke({x, y}, {x + kTick * style.em, y}, style.line));
    const double size = kNumbers * style.em;
    drawing.text(tickText(bar, tick), {x + (kTick + kGap) * style.em, y + 0.5 * kCapHeight * size}, size,
                 Drawing::Align::kLeft);
  }
  addTitle(picture, bar.at.x0, bar.at.y0, drawing);
}

void addSquares(const AnnotatedPicture& picture, const std::vector<LegendEntry>& entries, Drawing& drawing) {
  const Style& style = drawing.style();
  const ImageSize& size = picture.view.size;
  const double texts = widest(entries, style.em, [](const LegendEntry& entry) { return entry.text; });
  const double left = std::round(size.width - style.margin - texts - (kSquare + kGap) * style.em);
  const double square = std::round(kSquare * style.em);
  double top = (size.height - static_cast<double>(entries.size()) * kPitch * style.em) / 2;
  addTitle(picture, left, top, drawing);
  const double border = std::max(1.0, std::round(style.line));
  for (const LegendEntry& entry : entries) {
    const double y = std::round(top);
    if (entry.color.x >= 0) {
      drawing.ink({rectangle({left - border, y - border}, {left + square + border, y + square + border})});
      drawing.plain({{rectangle({left, y}, {left + square, y + square})}, entry.color});
    }
    drawing.text(entry.text, {left + square + kGap * style.em, y + 0.5 * (square + kCapHeight * style.em)}, style.em,
                 Drawing::Align::kLeft);
    top += kPitch * style.em;
  }
}

}  // namespace

ColorBar colorBarOf(const AnnotatedPicture& picture, const Style& style) {
  ColorBar out;
  const ValueRange values = valuesOf(picture);
  out.lo = values.lo, out.hi = values.hi;
  out.ticks = roundTicks(out.lo, out.hi, kMostTicks);
  const ImageSize& size = picture.view.size;
  const double numbers = widest(out.ticks, kNumbers * style.em, [&](double tick) { return tickText(out, tick); });
  const double right = size.width - style.margin - numbers - (kTick + kGap) * style.em;
  const int width = std::max(1, static_cast<int>(std::lround(kBarWidth * style.em)));
  const int height = std::max(2, static_cast<int>(std::lround(kBarHeight * style.em)));
  out.at.x1 = static_cast<int>(std::lround(right));
  out.at.x0 = out.at.x1 - width;
  out.at.y0 = (size.height - height) / 2;
  out.at.y1 = out.at.y0 + height;
  return out;
}

std::vector<LegendEntry> legendEntries(const TransferFunction& function) {
  std::vector<LegendEntry> out;
  for (auto surface = function.surfaces.rbegin(); surface != function.surfaces.rend(); ++surface) {
    if (surface->opacity > 0) out.push_back({surface->color, fmt::format("{:g}", surface->value)});
  }
  for (const LabelStyle& label : function.labels) {
    if (label.opacity > 0)
      out.push_back({label.color, label.name.empty() ? fmt::format("{:g}", label.label) : label.name});
  }
  if (out.size() > kMostEntries) {
    const std::size_t others = out.size() - (kMostEntries - 1);
    out.resize(kMostEntries - 1);
    out.push_back({glm::dvec3(-1), fmt::format("… {} more", others)});
  }
  return out;
}

void addLegend(const AnnotatedPicture& picture, Drawing& drawing) {
  const std::vector<LegendEntry> entries = legendEntries(picture.function);
  if (!entries.empty())
    addSquares(picture, entries, drawing);
  else if (!picture.function.points.empty())
    addBar(picture, drawing);
}

}  // namespace kiln
