#include "bench/report/svg.h"

#include <fmt/format.h>

namespace kiln {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

Svg::Svg(double width, double height, std::string_view label) : width_(width), height_(height), label_(label) {}

void Svg::line(const SvgPoint& a, const SvgPoint& b, std::string_view classes) {
  body_ += fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" class=\"{}\"/>\n", a.x, a.y, b.x,
                       b.y, classes);
}

void Svg::polyline(const std::vector<SvgPoint>& points, std::string_view classes) {
  body_ += "<polyline points=\"";
  for (const SvgPoint& p : points) body_ += fmt::format("{:.2f},{:.2f} ", p.x, p.y);
  body_ += fmt::format("\" class=\"{}\"/>\n", classes);
}

void Svg::rect(double x, double y, double width, double height, std::string_view classes) {
  body_ += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" class=\"{}\"/>\n", x, y,
                       width, height, classes);
}

void Svg::circle(const SvgPoint& centre, double radius, std::string_view classes) {
  body_ += fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" class=\"{}\"/>\n", centre.x, centre.y, radius,
                       classes);
}

void Svg::path(std::string_view data, std::string_view classes) {
  body_ += fmt::format("<path d=\"{}\" class=\"{}\"/>\n", data, classes);
}

void Svg::text(const SvgPoint& at, std::string_view anchor, std::string_view content, std::string_view classes) {
  body_ += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"{}\" class=\"{}\">{}</text>\n", at.x, at.y,
                       anchor, classes, escaped(content));
}

void Svg::uprightText(const SvgPoint& at, std::string_view anchor, std::string_view content) {
  body_ += fmt::format("<text transform=\"translate({:.2f},{:.2f}) rotate(-90)\" text-anchor=\"{}\">{}</text>\n", at.x,
                       at.y, anchor, escaped(content));
}

std::string Svg::inlined() const {
  return fmt::format(
      "<svg class=\"drawing\" viewBox=\"0 0 {:.0f} {:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" "
      "role=\"img\" aria-label=\"{}\">\n{}</svg>\n",
      width_, height_, width_, height_, escaped(label_), body_);
}

std::string Svg::file() const {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"drawing\" viewBox=\"0 0 {:.0f} {:.0f}\" "
      "width=\"{:.0f}\" height=\"{:.0f}\">\n<title>{}</title>\n<style>\n{}</style>\n{}</svg>\n",
      width_, height_, width_, height_, escaped(label_), svgStyle(), body_);
}

// Okabe and Ito's colours, distinguishable with red-green colour blindness. Variables have other values on dark pages.
std::string svgStyle() {
  return R"(.drawing { --ink: #1d1d1b; --faint: #8a8a84; --rule: #d9d8d2; --paper: #fffefb;
  --none: #8a8a84; --range-tree: #0072b2; --quadtree: #d55e00; --overlay: #009e73; --mask: #a3478c; }
@media (prefers-color-scheme: dark) { .drawing { --ink: #e8e6e0; --faint: #98958c; --rule: #3b3a37; --paper: #191817;
  --none: #98958c; --range-tree: #56b4e9; --quadtree: #f0843c; --overlay: #2ec99a; --mask: #dd8fc9; } }
.drawing { max-width: 100%; height: auto; }
.drawing text { font: 12px system-ui, sans-serif; fill: var(--ink); }
.drawing text.faint { fill: var(--faint); }
.drawing text.small { font-size: 10.5px; }
.drawing line.axis { stroke: var(--faint); }
.drawing line.grid { stroke: var(--rule); }
.drawing line.unit { stroke: var(--ink); stroke-dasharray: 3 3; }
.drawing polyline { fill: none; stroke-width: 1.8; stroke-linejoin: round; }
.drawing .m-none { --c: var(--none); } .drawing .m-range-tree { --c: var(--range-tree); }
.drawing .m-quadtree { --c: var(--quadtree); } .drawing .m-overlay { --c: var(--overlay); }
.drawing .m-mask { --c: var(--mask); }
.drawing polyline[class] { stroke: var(--c); } .drawing rect[class^="m-"], .drawing circle[class^="m-"] { fill: var(--c); }
.drawing text[class^="m-"] { fill: var(--c); }
.drawing .published { fill: var(--paper); stroke: var(--ink); stroke-width: 1.2; }
.drawing .volume { fill: none; stroke: var(--faint); stroke-dasharray: 2 3; }
.drawing .node { fill: none; stroke: var(--faint); stroke-width: .7; }
.drawing .cell { fill: var(--range-tree); fill-opacity: .62; stroke: var(--paper); stroke-width: .6; }
.drawing .hidden { fill: var(--quadtree); fill-opacity: .16; stroke: var(--quadtree); stroke-width: .5; stroke-opacity: .5; }
.drawing .arrow { stroke: var(--ink); stroke-width: 1.4; fill: none; }
)";
}

}  // namespace kiln
