#include "annotate/legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "annotate/font.h"
#include "annotate/places.h"
#include "annotate/round_numbers.h"
#include "base/number_text.h"

namespace kiln {
namespace {

// unit: the font's size.
constexpr double kBarWidth = 0.9, kBarHeight = 13, kTick = 0.3, kGap = 0.3, kPitch = 1.5, kSquare = 1, kNumbers = 0.9;
constexpr double kTitle = 1.7, kBetween = 1.2, kLeastBar = 4, kColumnGap = 1;
constexpr int kMostTicks = 7;

// The values that the function shows; where values are projected, all values between its ends.
ValueRange valuesOf(const ShownFunction& of, bool projected) {
  const std::vector<TransferPoint>& points = of.function.points;
  ValueRange out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool shown = projected || of.colors_only || points[i].opacity > 0 || (i > 0 && points[i - 1].opacity > 0) ||
                       (i + 1 < points.size() && points[i + 1].opacity > 0);
    if (shown) out.include(points[i].value);
  }
  if (!(out.lo < out.hi)) out.include(of.values);
  if (!(out.lo < out.hi)) out = {out.empty() ? 0 : out.lo, out.empty() ? 1 : out.lo + 1};
  return out;
}

std::string tickText(const ColorBar& bar, double tick) {
  const double step = bar.ticks.size() > 1 ? bar.ticks[1] - bar.ticks[0] : std::abs(tick);
  return textOfNumber(tick, step);
}

// The least distance between two surfaces; 0 if there are fewer. requires: sorted by value.
double leastStepOf(const std::vector<IsoSurface>& surfaces) {
  double out = 0;
  for (std::size_t i = 1; i < surfaces.size(); ++i) {
    const double step = surfaces[i].value - surfaces[i - 1].value;
    if (step > 0 && (out == 0 || step < out)) out = step;
  }
  return out;
}

// All digits of a whole number, else as many as tell surfaces apart that are `step` apart.
std::string surfaceText(double value, double step) { return numberText(value, value == std::floor(value) ? 1 : step); }

LegendEntry countOfOthers(std::size_t others) { return {glm::dvec3(-1), fmt::format("+{} more", others)}; }

bool hasBar(const TransferFunction& function) {
  const auto colored = [](const GradientRegion& region) { return region.color.has_value(); };
  return !function.points.empty() &&
         (function.regions.empty() || !std::all_of(function.regions.begin(), function.regions.end(), colored));
}

// The parts of a function, without their places.
void addParts(const ShownFunction& shown, std::string title, std::vector<LegendPart>& out) {
  if (hasBar(shown.function)) out.push_back({&shown, std::exchange(title, {})});
  std::vector<LegendEntry> entries = legendEntries(shown, kMostEntries);
  if (!entries.empty()) out.push_back({&shown, std::move(title), std::move(entries)});
}

double squareWidth(double em) { return std::round(kSquare * em) + kGap * em; }

// The height at which nothing is shortened. unit: pixels.
double fullHeight(const LegendPart& part, double em) {
  return em * (part.entries.empty() ? kBarHeight : kPitch * static_cast<double>(part.entries.size()));
}

double heightOf(const LegendPart& part, double em) {
  return part.entries.empty() ? part.bar.at.height() : kPitch * em * static_cast<double>(part.rows);
}

// Divides the entries into columns of `rows`. Returns the width of all columns. unit: pixels.
double divide(LegendPart& part, std::size_t rows, double em) {
  part.rows = rows;
  part.columns.clear();
  double end = 0;
  for (std::size_t first = 0; first < part.entries.size(); first += rows) {
    part.columns.push_back(first == 0 ? 0 : end + kColumnGap * em);
    double widest = 0;
    for (std::size_t i = first; i < std::min(first + rows, part.entries.size()); ++i)
      widest = std::max(widest, widthOf(part.entries[i].text, em));
    end = part.columns.back() + squareWidth(em) + widest;
  }
  return end;
}

// Lays the entries out below each other, or in columns of equal length, and leaves out what does not fit. unit: pixels.
void fitEntries(LegendPart& part, double height, double most_width, double em) {
  const auto most_rows = static_cast<std::size_t>(std::max(1.0, height / (kPitch * em) + 1e-9));
  const auto cutTexts = [&] {
    for (LegendEntry& entry : part.entries) {
      const bool counts = entry.color.x < 0;
      if (!counts) entry.text = cutToWidth(entry.text, em, most_width - squareWidth(em));
    }
  };
  cutTexts();
  for (std::size_t columns = (part.entries.size() + most_rows - 1) / most_rows;; --columns) {
    if (part.shown != nullptr && columns * most_rows < part.entries.size()) {
      part.entries = legendEntries(*part.shown, columns * most_rows);
      cutTexts();
    }
    const std::size_t rows = (part.entries.size() + columns - 1) / columns;
    part.width = divide(part, rows, em);
    if (columns == 1 || part.width <= most_width) return;
  }
}

void fitBar(LegendPart& part, double height, bool projected, double em) {
  const ValueRange values = valuesOf(*part.shown, projected);
  part.bar.lo = values.lo, part.bar.hi = values.hi;
  part.bar.at.y1 = std::max(2, static_cast<int>(std::lround(height)));
  const int ticks = static_cast<int>(std::lround(kMostTicks * height / (kBarHeight * em)));
  part.bar.ticks = roundTicks(values.lo, values.hi, std::clamp(ticks, 2, kMostTicks));
  double numbers = 0;
  for (const double tick : part.bar.ticks)
    numbers = std::max(numbers, widthOf(tickText(part.bar, tick), kNumbers * em));
  part.width = static_cast<double>(std::max(1L, std::lround(kBarWidth * em))) + (kTick + kGap) * em + numbers;
}

// Height of titles and of the gaps between parts. unit: pixels.
double heightBeside(const std::vector<LegendPart>& parts, double em) {
  double out = kBetween * em * static_cast<double>(parts.size() - 1);
  for (const LegendPart& part : parts) out += part.title.empty() ? 0 : kTitle * em;
  return out;
}

// Leaves out the last parts where even short ones would not fit, and says so. unit: pixels.
void keepFitting(double room, double em, std::vector<LegendPart>& parts) {
  const auto most = static_cast<std::size_t>(std::max(2.0, room / ((kTitle + kBetween + kPitch) * em)));
  if (parts.size() <= most) return;
  const std::size_t others = parts.size() - (most - 1);
  parts.resize(most - 1);
  parts.push_back({nullptr, "", {countOfOthers(others)}});
}

// Fits all parts into a height. Returns the width, without titles. unit: pixels.
double fitParts(const AnnotatedPicture& picture, double height, double em, std::vector<LegendPart>& parts) {
  keepFitting(height, em, parts);
  double lists = 0, bars = 0;  // heights of lists, number of bars
  for (const LegendPart& part : parts)
    (part.entries.empty() ? bars : lists) += part.entries.empty() ? 1 : fullHeight(part, em);
  const double room = std::max(height - heightBeside(parts, em), 0.0);
  // Bars are shortened before lists.
  const double least = std::min(kLeastBar * em, room / static_cast<double>(parts.size()));
  const double bar = std::clamp((room - lists) / std::max(bars, 1.0), least, kBarHeight * em);
  const double share = lists > 0 ? std::clamp((room - bars * bar) / lists, 0.0, 1.0) : 1;
  double width = 0;
  for (LegendPart& part : parts) {
    if (part.entries.empty())
      fitBar(part, bar, picture.projected, em);
    else
      fitEntries(part, share * fullHeight(part, em), kMostOfWidth * picture.view.size.width, em);
    width = std::max(width, part.width);
  }
  return width;
}

std::vector<LegendPart> partsOf(const AnnotatedPicture& picture) {
  std::vector<LegendPart> out;
  const bool several = picture.shown.size() > 1;
  for (std::size_t i = 0; i < picture.shown.size(); ++i) {
    const std::string& given = picture.annotations.legend_title;
    addParts(picture.shown[i], i == 0 && !given.empty() ? given : several ? picture.shown[i].name : "", out);
  }
  return out;
}

// Places the parts below each other from a height on, which is that of the first title if there are several parts.
void place(double left, double top, double em, std::vector<LegendPart>& parts) {
  const int column = static_cast<int>(std::lround(left));
  for (LegendPart& part : parts) {
    if (parts.size() > 1 && !part.title.empty()) top += kTitle * em;
    const int first = static_cast<int>(std::lround(top));
    if (part.entries.empty()) {
      const int wide = std::max(1, static_cast<int>(std::lround(kBarWidth * em)));
      part.bar.at = {column, first, column + wide, first + part.bar.at.height()};
    } else {
      const int square = static_cast<int>(std::lround(kSquare * em));
      part.first_square = {column, first, column + square, first + square};
    }
    top += heightOf(part, em) + kBetween * em;
  }
}

const PixelRect& firstOf(const LegendPart& part) { return part.entries.empty() ? part.bar.at : part.first_square; }

// A title above its part, to the right unless that would leave the picture.
struct Title {
  std::string text;
  double left = 0, width = 0;  // unit: pixels
};

Title titleOf(const AnnotatedPicture& picture, const LegendPart& part, const Style& style) {
  const double left = firstOf(part).x0, right = picture.view.size.width - style.margin;
  Title out{cutToWidth(part.title, style.em, right - style.margin), left, 0};
  out.width = widthOf(out.text, style.em);
  if (left + out.width > right) out.left = right - out.width;
  return out;
}

void addTitle(const AnnotatedPicture& picture, const LegendPart& part, Drawing& drawing) {
  if (part.title.empty()) return;
  const Style& style = drawing.style();
  const Title title = titleOf(picture, part, style);
  drawing.text(title.text, {title.left, firstOf(part).y0 - 0.7 * style.em}, style.em, Drawing::Align::kLeft);
}

// The room of all parts and titles; empty without parts.
Room roomOf(const std::vector<LegendPart>& parts, const AnnotatedPicture& picture, const Style& style) {
  const double most_title = kMostOfWidth * picture.view.size.width;
  Room out{INFINITY, INFINITY, -INFINITY, -INFINITY};
  for (const LegendPart& part : parts) {
    const PixelRect& first = firstOf(part);
    const double left = first.x0, top = first.y0, right = left + part.width;
    out = {std::min(out.x0, left), std::min(out.y0, top), std::max(out.x1, right),
           std::max(out.y1, top + heightOf(part, style.em))};
    if (part.title.empty()) continue;
    const Title title = titleOf(picture, part, style);
    const double beyond = std::max(title.width - most_title, 0.0);
    const bool at_left = standsLeft(legendPlaceOf(picture));
    out.x0 = std::min(out.x0, title.left + (at_left ? 0 : beyond));
    out.x1 = std::max(out.x1, title.left + title.width - (at_left ? beyond : 0));
    out.y0 = std::min(out.y0, top - kTitle * style.em);
  }
  return out;
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
  const double square = part.first_square.width();
  const double border = std::max(1.0, std::round(style.line));
  for (std::size_t i = 0; i < part.entries.size(); ++i) {
    const LegendEntry& entry = part.entries[i];
    const double y = part.first_square.y0 + std::round(static_cast<double>(i % part.rows) * kPitch * style.em);
    const double left = part.first_square.x0 + std::round(part.columns[i / part.rows]);
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
  const double em = style.em;
  const std::vector<LegendPart> all = partsOf(picture);
  if (all.empty()) return all;
  // The room depends on the width, which depends on the room: columns are chosen for the room of a first choice.
  double width = 0, wide = 0;
  for (const LegendPart& part : all) wide = std::max(wide, widthOf(part.title, em));
  std::vector<LegendPart> out;
  Room room;
  for (int attempt = 0; attempt < 2; ++attempt) {
    room = legendRoom(picture, style, wide);
    out = all;
    width = fitParts(picture, room.y1 - room.y0, em, out);
    wide = std::max(wide, width);
  }
  double height = out.size() > 1 ? heightBeside(out, em) : 0;
  for (const LegendPart& part : out) height += heightOf(part, em);
  // A single legend is placed without its title, which stands above.
  const double first = room.y0 + (out.size() == 1 && !out.front().title.empty() ? kTitle * em : 0);
  const double last = std::max(room.y1 - height, first);
  const LegendPlace at = legendPlaceOf(picture);
  const bool top = at == LegendPlace::kTopRight || at == LegendPlace::kTopLeft;
  const bool bottom = at == LegendPlace::kBottomRight || at == LegendPlace::kBottomLeft;
  const double middle = std::clamp((picture.view.size.height - height) / 2, first, last);
  place(standsLeft(at) ? room.x0 : room.x1 - width, top ? first : bottom ? last : middle, em, out);
  return out;
}

std::vector<FreeEdges> legendEdges(AnnotatedPicture picture) {
  const ImageSize size = picture.view.size;
  picture.view = {};
  picture.view.size = size;
  picture.annotations.scale_bar_length.reset();
  const Style style(picture);
  if (!picture.annotations.legend || !style.legible) return {};
  const Room room = roomOf(legendParts(picture, style), picture, style);
  if (room.empty()) return {};
  const double gap = kApart * style.em;
  const double most_x = (1 - kLeastBeside) * size.width, most_y = (1 - kLeastBeside) * size.height;
  const LegendPlace at = legendPlaceOf(picture);
  std::vector<FreeEdges> out;
  const double columns = (standsLeft(at) ? room.x1 : size.width - room.x0) + gap;
  const auto beside = [&](double edge) { return standsLeft(at) ? FreeEdges{.left = edge} : FreeEdges{.right = edge}; };
  if (columns <= most_x) out.push_back(beside(columns));
  const bool top = at == LegendPlace::kTopLeft || at == LegendPlace::kTopRight;
  const bool bottom = at == LegendPlace::kBottomLeft || at == LegendPlace::kBottomRight;
  if (top && room.y1 + gap <= most_y) out.push_back({.top = room.y1 + gap});
  if (bottom && size.height - room.y0 + gap <= most_y) out.push_back({.bottom = size.height - room.y0 + gap});
  if (out.empty()) out.push_back(beside(most_x));
  return out;
}

std::vector<LegendEntry> legendEntries(const ShownFunction& shown, std::size_t most) {
  const TransferFunction& function = shown.function;
  std::vector<LegendEntry> out;
  const double step = leastStepOf(function.surfaces);
  for (auto surface = function.surfaces.rbegin(); surface != function.surfaces.rend(); ++surface) {
    if (surface->opacity > 0) out.push_back({surface->color, surfaceText(surface->value, step)});
  }
  const auto exists = [&](double label) {
    return !shown.labels || std::binary_search(shown.labels->begin(), shown.labels->end(), label);
  };
  for (const LabelStyle& label : function.labels) {
    if (label.opacity > 0 && exists(label.label))
      out.push_back({label.color, label.name.empty() ? fmt::format("{:.0f}", label.label) : label.name});
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
    addTitle(picture, part, drawing);
  }
}

}  // namespace kiln
