#include "scene/transfer/iso_surfaces.h"

#include <fmt/format.h>

#include <optional>

#include "base/error.h"
#include "base/text.h"
#include "image/named_color.h"
#include "scene/scene_limits.h"
#include "scene/transfer/value_text.h"

namespace kiln {

TransferFunction isoSurfaces(std::string_view text) {
  const auto refuse = [&](const std::string& expected) {
    throw Error(ErrorCode::kUsage, fmt::format("'{}{}': expected {}", kIso, text, expected));
  };
  TransferFunction out;
  for (const std::string_view part : splitAt(text, ',')) {
    const std::optional<ValueText> surface = valueText(part);
    if (!surface)
      refuse(
          fmt::format("surfaces VALUE[:OPACITY[:COLOR]] separated by commas after iso:, such as iso:300, OPACITY "
                      "from 0 to 1, COLOR {} (found '{}')",
                      kColorForms, part));
    if (!out.surfaces.empty() && !(out.surfaces.back().value < surface->value))
      refuse(fmt::format("surfaces in order of their values (found {} after {})", surface->value,
                         out.surfaces.back().value));
    constexpr IsoSurface kDefault;
    out.surfaces.push_back(
        {surface->value, surface->color.value_or(kDefault.color), surface->opacity.value_or(kDefault.opacity)});
  }
  if (out.surfaces.size() > kMostIsoSurfaces)
    refuse(fmt::format("at most {} surfaces (found {})", kMostIsoSurfaces, out.surfaces.size()));
  return out;
}

}  // namespace kiln
