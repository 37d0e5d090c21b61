#include "grid/declared_look.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace kiln {

std::string textOf(const DisplayColor& color) {
  const std::string opaque = fmt::format("#{:02x}{:02x}{:02x}", color.red, color.green, color.blue);
  return color.alpha == 255 ? opaque : fmt::format("{}{:02x}", opaque, color.alpha);
}

std::optional<DisplayColor> displayColorOf(std::string_view text) {
  if (text.starts_with('#')) text.remove_prefix(1);
  if (text.size() != 6 && text.size() != 8) return std::nullopt;
  DisplayColor out;
  std::uint8_t* const channels[] = {&out.red, &out.green, &out.blue, &out.alpha};
  for (std::size_t i = 0; 2 * i < text.size(); ++i) {
    const char* const digits = text.data() + 2 * i;
    const auto [end, error] = std::from_chars(digits, digits + 2, *channels[i], 16);
    if (error != std::errc() || end != digits + 2) return std::nullopt;
  }
  return out;
}

void sortDeclared(std::vector<DeclaredLook::Label>& labels) {
  const auto before = [](const auto& a, const auto& b) { return a.label < b.label; };
  const auto same = [](const auto& a, const auto& b) { return a.label == b.label; };
  std::stable_sort(labels.begin(), labels.end(), before);
  labels.erase(std::unique(labels.begin(), labels.end(), same), labels.end());
}

}  // namespace kiln
