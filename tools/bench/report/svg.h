// Builds drawings as SVG: a few shapes with CSS classes, written in call order. Inside a page the page's style applies;
// a separate file includes the style.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// Escapes &, <, > and quotes, for HTML and SVG.
std::string escaped(std::string_view text);

struct SvgPoint {
  double x = 0, y = 0;
};

/// unit: pixels of the drawing, y down.
class Svg {
 public:
  /// `label` describes the drawing for screen readers.
  Svg(double width, double height, std::string_view label);

  void line(const SvgPoint& a, const SvgPoint& b, std::string_view classes);
  void polyline(const std::vector<SvgPoint>& points, std::string_view classes);
  void rect(double x, double y, double width, double height, std::string_view classes);
  void circle(const SvgPoint& centre, double radius, std::string_view classes);
  /// shape: `data` in SVG's path language.
  void path(std::string_view data, std::string_view classes);
  /// `anchor`: "start", "middle" or "end".
  void text(const SvgPoint& at, std::string_view anchor, std::string_view content, std::string_view classes = "");
  /// Writes text that runs upwards.
  void uprightText(const SvgPoint& at, std::string_view anchor, std::string_view content);

  /// Returns the element for a page whose style includes `svgStyle()`.
  std::string inlined() const;
  /// Returns a complete SVG file.
  std::string file() const;

 private:
  double width_, height_;
  std::string label_, body_;
};

/// Returns the rules for the classes: lines, text, and a colour for each visibility method ("m-range-tree", …).
std::string svgStyle();

}  // namespace kiln
