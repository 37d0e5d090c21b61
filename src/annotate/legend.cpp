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
constexpr double kTitle = 1.7, kBetween = 1.2, kOfScaleBar = 3, kLeastBar = 4;
constexpr int kMostTicks = 7;

// The values that the function shows; where values are projected, all values between its ends.
ValueRange valuesOf(const ShownFunction& of, bool projected) {
  const std::vector<TransferPoint>& points = of.function.points;
  ValueRange out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool shown = projected || points[i].opacity > 0 || (i > 0 && points[i - 1].opacity > 0) ||
                       (i + 1 < points.size() && points[i + 1].opacity > 0);
    if (shown) out.include(points[i].value);
  }
  if (!(out.lo < out.hi)) out.include(of.values);
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

LegendEntry countOfOthers(std::size_t others) { return {glm::dvec3(-1), fmt::format("… {} more", others)}; }

bool hasBar(const TransferFunction& function) {
  const auto colored = [](const GradientRegion& region) { return region.color.has_value(); };
  return !function.points.empty() &&
         (function.regions.empty() || !std::all_of(function.regions.begin(), function.regions.end(), colored));
}

// Leaves out the last parts where even short ones would not fit, and says so. unit: pixels.
void keepFitting(double room, double em, std::vector<LegendPart>& parts) {
  const auto most = static_cast<std::size_t>(std::max(2.0, room / ((kTitle + kBetween + kPitch) * em)));
  if (parts.size() <= most) return;
  const std::size_t others = parts.size() - (most - 1);
  parts.resize(most - 1);
  parts.push_back({nullptr, "", {countOfOthers(others)}, {}, {}});
}

// The parts of a function, without their places.
void addParts(const ShownFunction& shown, std::string title, std::vector<LegendPart>& out) {
  if (hasBar(shown.function)) out.push_back({&shown, std::exchange(title, {}), {}, {}, {}});
  std::vector<LegendEntry> entries = legendEntries(shown, kMostEntries);
  if (!entries.empty()) out.push_back({&shown, std::move(title), std::move(entries), {}, {}});
}

double heightOf(const LegendPart& part, double em) {
  return em * (part.entries.empty() ? kBarHeight : kPitch * static_cast<double>(part.entries.size()));
}

// Returns the room beside numbers or texts. unit: pixels from the left of the part to the end of its texts.
double widthOf(const LegendPart& part, double em) {
  if (!part.entries.empty())
    return std::round(kSquare * em) + kGap * em +
           widest(part.entries, em, [](const LegendEntry& entry) { return entry.text; });
  const double numbers = widest(part.bar.ticks, kNumbers * em, [&](double tick) { return tickText(part.bar, tick); });
  return static_cast<double>(std::max(1L, std::lround(kBarWidth * em))) + (kTick + kGap) * em + numbers;
}

// Shortens a part to a height. unit: pixels.
void shorten(LegendPart& part, double height, bool projected, double em) {
  if (!part.entries.empty()) {
    const auto most = static_cast<std::size_t>(std::max(1.0, height / (kPitch * em) + 1e-9));
    if (most < part.entries.size()) part.entries = legendEntries(*part.shown, most);
    return;
  }
  const ValueRange values = valuesOf(*part.shown, projected);
  part.bar.lo = values.lo, part.bar.hi = values.hi;
  part.bar.at.y1 = std::max(2, static_cast<int>(std::lround(height)));
  const int ticks = static_cast<int>(std::lround(kMostTicks * height / (kBarHeight * em)));
  part.bar.ticks = roundTicks(values.lo, values.hi, std::clamp(ticks, 2, kMostTicks));
}

void addTitle(const AnnotatedPicture& picture, const std::string& title, const PixelRect& below, Drawing& drawing) {
  if (title.empty()) return;
  const Style& style = drawing.style();
  const double left = below.x0, top = below.y0, right = picture.view.size.width - style.margin;
  const bool fits = left + lineOf(title, style.em).width <= right;
  drawing.text(title, {fits ? left : right, top - 0.7 * style.em}, style.em,
               fits ? Drawing::Align::kLeft : Drawing::Align::kRight);
}

void addBar(const LegendPart& part, Drawing& drawing) {
  const Style& style = drawing.style();
  const ColorBar& bar = part.bar;
  const auto at = [](int x, int y) { return glm::dvec2(x, y); };
  const double border = std::max(1.0, std::round(style.line));
  drawing.ink({rectangle(at(bar.at.x0, bar.at.y0) - border, at(bar.at.x1, bar.at.y1) + border)});
  for (int row = bar.at.y0; row < bar.at.y1; ++row)
    drawing.plain(
        {{rectangle(at(bar.at.x0, row), at(bar.at.x1, row + 1))}, part.shown->function.at(bar.valueOfRow(row)).color});
  for (const double tick : bar.ticks) {
    const double y = bar.heightOf(tick), x = bar.at.x1 + border;
    drawing.ink(stroke({x, y}, {x + kTick * style.em, y}, style.line));
    const double size = kNumbers * style.em;
    drawing.text(tickText(bar, tick), {x + (kTick + kGap) * style.em, y + 0.5 * kCapHeight * size}, size,
                 Drawing::Align::kLeft);
  }
}

void addSquares(const LegendPart& part, Drawing& drawing) {
  const Style& style = drawing.style();
  const double left = part.first_square.x0, square = part.first_square.width();
  const double border = std::max(1.0, std::round(style.line));
  for (std::size_t i = 0; i < part.entries.size(); ++i) {
    const LegendEntry& entry = part.entries[i];
    const double y = part.first_square.y0 + std::round(static_cast<double>(i) * kPitch * style.em);
    if (entry.color.x >= 0) {
      drawing.ink({rectangle({left - border, y - border}, {left + square + border, y + square + border})});
      drawing.plain({{rectangle({left, y}, {left + square, y + square})}, entry.color});
    }
    drawing.text(entry.text, {left + square + kGap * style.em, y + 0.5 * (square + kCapHeight * style.em)}, style.em,
                 Drawing::Align::kLeft);
  }
}

}  // namespace

std::vector<LegendPart> legendParts(const AnnotatedPicture& picture, const Style& style) {
  std::vector<LegendPart> out;
  const bool several = picture.shown.size() > 1;
  for (std::size_t i = 0; i < picture.shown.size(); ++i) {
    const std::string& given = picture.annotations.legend_title;
    addParts(picture.shown[i], i == 0 && !given.empty() ? given : several ? picture.shown[i].name : "", out);
  }
  if (out.empty()) return out;
  const double em = style.em;
  const double end = picture.view.size.height - style.margin - (picture.annotations.scale_bar ? kOfScaleBar * em : 0);
  keepFitting(end - style.margin, em, out);
  // Heights of titles and gaps, and of lists; number of bars.
  double beside = kBetween * em * static_cast<double>(out.size() - 1), lists = 0, bars = 0;
  for (const LegendPart& part : out) {
    beside += part.title.empty() ? 0 : kTitle * em;
    (part.entries.empty() ? bars : lists) += part.entries.empty() ? 1 : heightOf(part, em);
  }
  const double room = std::max(end - style.margin - beside, 0.0);
  // Bars are shortened before lists.
  const double least = std::min(kLeastBar * em, room / static_cast<double>(out.size()));
  const double bar = std::clamp((room - lists) / std::max(bars, 1.0), least, kBarHeight * em);
  const double share = lists > 0 ? std::clamp((room - bars * bar) / lists, 0.0, 1.0) : 1;
  for (LegendPart& part : out)
    shorten(part, part.entries.empty() ? bar : share * heightOf(part, em), picture.projected, em);
  double height = out.size() > 1 ? beside : 0, width = 0;
  for (const LegendPart& part : out) {
    height += part.entries.empty() ? part.bar.at.height() : heightOf(part, em);
    width = std::max(width, widthOf(part, em));
  }
  // A single legend is in the middle without its title.
  double top = (picture.view.size.height - height) / 2;
  if (out.size() > 1) top = std::max(std::min(top, end - height), 0.0);
  const int left = static_cast<int>(std::lround(picture.view.size.width - style.margin - width));
  for (LegendPart& part : out) {
    if (out.size() > 1 && !part.title.empty()) top += kTitle * em;
    const int first = static_cast<int>(std::lround(top));
    if (part.entries.empty()) {
      const int tall = part.bar.at.height();
      part.bar.at = {left, first, left + std::max(1, static_cast<int>(std::lround(kBarWidth * em))), first + tall};
      top += tall;
    } else {
      const int square = static_cast<int>(std::lround(kSquare * em));
      part.first_square = {left, first, left + square, first + square};
      top += heightOf(part, em);
    }
    top += kBetween * em;
  }
  return out;
}

std::vector<LegendEntry> legendEntries(const ShownFunction& shown, std::size_t most) {
  const TransferFunction& function = shown.function;
  std::vector<LegendEntry> out;
  for (auto surface = function.surfaces.rbegin(); surface != function.surfaces.rend(); ++surface) {
    if (surface->opacity > 0) out.push_back({surface->color, fmt::format("{:g}", surface->value)});
  }
  const auto exists = [&](double label) {
    return !shown.labels || std::binary_search(shown.labels->begin(), shown.labels->end(), label);
  };
  for (const LabelStyle& label : function.labels) {
    if (label.opacity > 0 && exists(label.label))
      out.push_back({label.color, label.name.empty() ? fmt::format("{:g}", label.label) : label.name});
  }
  for (const GradientRegion& region : function.regions) {
    if (region.color)
      out.push_back({*region.color, fmt::format("{:g} to {:g}, gradient {:g} to {:g}", region.values.x, region.values.y,
                                                region.gradients.x, region.gradients.y)});
  }
  if (out.size() > most) {
    const std::size_t others = out.size() - (most - 1);
    out.resize(most - 1);
    out.push_back(countOfOthers(others));
  }
  return out;
}

void addLegend(const AnnotatedPicture& picture, Drawing& drawing) {
  for (const LegendPart& part : legendParts(picture, drawing.style())) {
    if (part.entries.empty())
      addBar(part, drawing);
    else
      addSquares(part, drawing);
    addTitle(picture, part.title, part.entries.empty() ? part.bar.at : part.first_square, drawing);
  }
}

}  // namespace kiln
