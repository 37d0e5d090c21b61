// Drawings as SVG: a few shapes with classes, written as they come. Inside of a page the page's style colours them; a
// file of its own carries the style with it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// Text with &, <, > and quotes made harmless, for HTML and SVG.
std::string escaped(std::string_view text);

struct SvgPoint {
  double x = 0, y = 0;
};

/// unit: pixels of the drawing, y down.
class Svg {
 public:
  /// `label` says to those who cannot see it what the drawing shows.
  Svg(double width, double height, std::string_view label);

  void line(const SvgPoint& a, const SvgPoint& b, std::string_view classes);
  void polyline(const std::vector<SvgPoint>& points, std::string_view classes);
  void rect(double x, double y, double width, double height, std::string_view classes);
  void circle(const SvgPoint& centre, double radius, std::string_view classes);
  /// shape: `data` in SVG's path language.
  void path(std::string_view data, std::string_view classes);
  /// `anchor`: "start", "middle" or "end".
  void text(const SvgPoint& at, std::string_view anchor, std::string_view content, std::string_view classes = "");
  /// The same, turned to run upwards.
  void uprightText(const SvgPoint& at, std::string_view anchor, std::string_view content);

  /// For a page that has `svgStyle()` in its style.
  std::string inlined() const;
  /// For a file.
  std::string file() const;

 private:
  double width_, height_;
  std::string label_, body_;
};

/// The rules behind the classes: lines, text, and a colour for each visibility method ("m-range-tree", …).
std::string svgStyle();

}  // namespace kiln
