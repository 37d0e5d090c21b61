// The look that the author of a source gave the volume, which the default transfer function follows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// A colour as screens show it (sRGB), and its opacity. unit: 255ths.
struct DisplayColor {
  std::uint8_t red = 255, green = 255, blue = 255, alpha = 255;
  bool operator==(const DisplayColor&) const = default;
};

/// "#rrggbb", or "#rrggbbaa" unless the colour is opaque.
std::string textOf(const DisplayColor& color);
/// Parses these texts, with or without the mark in front; nothing for other texts.
std::optional<DisplayColor> displayColorOf(std::string_view text);

struct DeclaredLook {
  /// Values from black to a colour, linear on a screen.
  struct Ramp {
    double begin = 0, end = 1;
    DisplayColor color;
    bool operator==(const Ramp&) const = default;
  };
  struct Label {
    std::int64_t label = 0;
    DisplayColor color;
    bool operator==(const Label&) const = default;
  };

  /// For values that are amounts. shape: begin < end, finite.
  std::optional<Ramp> ramp;
  /// For labels. shape: sorted by label, unique.
  std::vector<Label> labels;

  bool empty() const { return !ramp && labels.empty(); }
  bool operator==(const DeclaredLook&) const = default;
};

/// Sorts the labels; of equal labels the first is kept.
void sortDeclared(std::vector<DeclaredLook::Label>& labels);

}  // namespace kiln
