// Source: the basic colours of CSS (W3C, CSS Color Module Level 4, §6.1), with orange, brown and pink.
#include "image/named_color.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>

#include "base/text.h"
#include "image/srgb.h"

namespace kiln {
namespace {

constexpr std::array<std::string_view, 22> kCssNames = {
    "black", "silver", "gray", "grey", "white", "maroon", "red",  "brown",   "orange",  "yellow", "olive",
    "lime",  "green",  "aqua", "cyan", "teal",  "blue",   "navy", "fuchsia", "magenta", "purple", "pink"};
constexpr std::array<std::uint32_t, kCssNames.size()> kCssColors = {
    0x000000, 0xc0c0c0, 0x808080, 0x808080, 0xffffff, 0x800000, 0xff0000, 0xa52a2a, 0xffa500, 0xffff00, 0x808000,
    0x00ff00, 0x008000, 0x00ffff, 0x00ffff, 0x008080, 0x0000ff, 0x000080, 0xff00ff, 0xff00ff, 0x800080, 0xffc0cb};

std::optional<std::uint32_t> numberOfName(std::string_view text) {
  const auto found = std::find(kCssNames.begin(), kCssNames.end(), lowered(text));
  if (found == kCssNames.end()) return std::nullopt;
  return kCssColors[static_cast<std::size_t>(found - kCssNames.begin())];
}

std::optional<std::uint32_t> numberOfDigits(std::string_view digits) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number, 16);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  if (digits.size() == 6) return number;
  // Each digit of #rgb counts twice.
  if (digits.size() == 3) return 17 * ((number & 0xf00) << 8 | (number & 0xf0) << 4 | (number & 0xf));
  return std::nullopt;
}

}  // namespace

std::span<const std::string_view> colorNames() { return kCssNames; }

std::optional<glm::dvec3> colorNamed(std::string_view text) {
  const auto number = text.starts_with('#') ? numberOfDigits(text.substr(1)) : numberOfName(text);
  if (!number) return std::nullopt;
  return linearFromSrgb(glm::dvec3(*number >> 16, *number >> 8 & 0xff, *number & 0xff) / 255.0);
}

}  // namespace kiln
