#include "bench/report/report_words.h"

#include <fmt/format.h>

#include <cmath>

#include "job/job_names.h"

namespace kiln {

std::string_view titleOf(VisibilityMethod method) {
  switch (method) {
    case VisibilityMethod::kNone:
      return "Octree only";
    case VisibilityMethod::kMask:
      return "Octree/\u200bMask";
    case VisibilityMethod::kRangeTree:
      return "Octree/\u200bRange tree";
    case VisibilityMethod::kQuadtree:
      return "Octree/\u200bQuadtree";
    case VisibilityMethod::kOverlay:
      break;
  }
  return "Octree/\u200bOverlay";
}

std::string_view wordOf(VisibilityMethod method) {
  switch (method) {
    case VisibilityMethod::kNone:
      return "octree only";
    case VisibilityMethod::kMask:
      return "mask";
    case VisibilityMethod::kRangeTree:
      return "range tree";
    case VisibilityMethod::kQuadtree:
      return "quadtree";
    case VisibilityMethod::kOverlay:
      break;
  }
  return "overlay";
}

std::string classOf(VisibilityMethod method) { return "m-" + std::string(nameIn(kVisibilityNames, method)); }

std::string_view titleOf(Projection projection) {
  return projection == Projection::kOrthographic ? "Orthographic" : "Perspective";
}

std::string textOf(const ImageSize& size) { return fmt::format("{}×{}", size.width, size.height); }

std::string counted(double number) {
  const std::string digits = fmt::format("{:.0f}", number);
  std::string out;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) out += "\u202f";
    out += digits[i];
  }
  return out;
}

std::string measured(double number) {
  if (number >= 1000) return counted(number);
  const int before = number >= 1 ? static_cast<int>(std::floor(std::log10(number))) + 1 : 0;
  return fmt::format("{:.{}f}", number, std::max(0, 3 - before));
}

}  // namespace kiln
