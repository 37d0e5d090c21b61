#include "scene/transfer/iso_surfaces.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/text.h"
#include "image/named_color.h"
#include "scene/scene_limits.h"

namespace kiln {
namespace {

constexpr double kLargestValue = 1e300;

std::optional<IsoSurface> surfaceText(std::string_view text) {
  const std::vector<std::string_view> parts = splitAt(text, ':');
  if (parts.size() > 3) return std::nullopt;
  IsoSurface out;
  const std::optional<double> value = numberOf<double>(parts[0]);
  if (!value || !(std::abs(*value) <= kLargestValue)) return std::nullopt;
  out.value = *value;
  if (parts.size() > 1) {
    const std::optional<double> opacity = numberOf<double>(parts[1]);
    if (!opacity || !(*opacity >= 0 && *opacity <= 1)) return std::nullopt;
    out.opacity = *opacity;
  }
  if (parts.size() > 2) {
    const std::optional<glm::dvec3> color = colorNamed(parts[2]);
    if (!color) return std::nullopt;
    out.color = *color;
  }
  return out;
}

}  // namespace

TransferFunction isoSurfaces(std::string_view text) {
  const auto refuse = [&](const std::string& expected) {
    throw Error(ErrorCode::kUsage, fmt::format("'{}{}': expected {}", kIso, text, expected));
  };
  TransferFunction out;
  for (const std::string_view part : splitAt(text, ',')) {
    const std::optional<IsoSurface> surface = surfaceText(part);
    if (!surface)
      refuse(
          fmt::format("surfaces VALUE[:OPACITY[:COLOR]] separated by commas after iso:, such as iso:300, OPACITY "
                      "from 0 to 1, COLOR {} (found '{}')",
                      kColorForms, part));
    if (!out.surfaces.empty() && !(out.surfaces.back().value < surface->value))
      refuse(fmt::format("surfaces in order of their values (found {} after {})", surface->value,
                         out.surfaces.back().value));
    out.surfaces.push_back(*surface);
  }
  if (out.surfaces.size() > kMostIsoSurfaces)
    refuse(fmt::format("at most {} surfaces (found {})", kMostIsoSurfaces, out.surfaces.size()));
  return out;
}

}  // namespace kiln
