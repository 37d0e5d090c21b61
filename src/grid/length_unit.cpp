#include "grid/length_unit.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <numeric>

#include "base/text.h"

namespace kiln {
namespace {

struct LengthUnit {
  const char* name;
  std::int64_t picometres;
  /// Alternative spellings, separated by spaces.
  std::string_view others;
};

// ImageJ writes the micro sign as \u00B5, older versions as the Latin-1 byte; XML may write an entity.
constexpr std::array<LengthUnit, 12> kUnits = {{
    {"pm", 1, "picometer picometre"},
    {"angstrom", 100, "angstroms Angstrom A \xc3\x85 \xe2\x84\xab &#197; &#xC5; &#8491; &#x212B; \\u00C5 \\u00c5"},
    {"nm", 1'000, "nanometer nanometre nanometers nanometres"},
    {"um", 1'000'000,
     "micron microns micrometer micrometre micrometers micrometres \\u00B5m \\u00b5m \\u03bcm \xb5m \xc2\xb5m "
     "\xce\xbcm &#181;m &#xB5;m "
     "&#xb5;m &#956;m &#x3BC;m &#x3bc;m &micro;m"},
    {"mm", 1'000'000'000, "millimeter millimetre millimeters millimetres"},
    {"cm", 10'000'000'000, "centimeter centimetre centimeters centimetres"},
    {"in", 25'400'000'000, "inch inches"},
    {"dm", 100'000'000'000, "decimeter decimetre"},
    {"ft", 304'800'000'000, "foot feet"},
    {"yd", 914'400'000'000, "yard yards"},
    {"m", 1'000'000'000'000, "meter metre meters metres"},
    {"km", 1'000'000'000'000'000, "kilometer kilometre kilometers kilometres"},
}};

const LengthUnit* unitNamed(std::string_view text) {
  const auto spaced = [](std::string_view words) { return fmt::format(" {} ", words); };
  for (const LengthUnit& unit : kUnits) {
    if (text == unit.name || spaced(unit.others).find(spaced(text)) != std::string::npos) return &unit;
  }
  // Words may be in capitals. Symbols may not: Mm is a megametre.
  constexpr std::size_t kLongestSymbol = 3;  // bytes; the micro sign has two
  const std::string small = lowered(text);
  return text.size() > kLongestSymbol && small != text ? unitNamed(small) : nullptr;
}

}  // namespace

std::string unitName(std::string_view unit) {
  const LengthUnit* const known = unitNamed(unit);
  return known ? known->name : "";
}

std::string shownUnit(std::string_view unit) {
  const std::string name = unitName(unit);
  if (name == "um") return "\xc2\xb5m";
  if (name == "angstrom") return "\xc3\x85";
  return name.empty() ? std::string(unit) : name;
}

std::optional<LengthRatio> lengthRatio(std::string_view from, std::string_view to) {
  if (from == to) return LengthRatio();
  const LengthUnit *const a = unitNamed(from), *const b = unitNamed(to);
  if (!a || !b) return std::nullopt;
  const std::int64_t common = std::gcd(a->picometres, b->picometres);
  return LengthRatio{static_cast<double>(a->picometres / common), static_cast<double>(b->picometres / common)};
}

}  // namespace kiln
