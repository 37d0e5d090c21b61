// viridis, plasma and inferno are every 17th entry of the tables of S. van der Walt and N. Smith (matplotlib, CC0);
// cool-to-warm is Moreland's diverging map with ParaView's end points; fire resembles a glowing body.
#include "scene/transfer/named_color_maps.h"

#include <array>
#include <cstdint>
#include <span>

namespace kiln {
namespace {

using Table = std::array<std::uint32_t, 16>;  // 0xRRGGBB

constexpr Table kViridis = {0x440154, 0x481a6c, 0x472f7d, 0x414487, 0x39568c, 0x31688e, 0x2a788e, 0x23888e,
                            0x1f988b, 0x22a884, 0x35b779, 0x54c568, 0x7ad151, 0xa5db36, 0xd2e21b, 0xfde725};
constexpr Table kPlasma = {0x0d0887, 0x330597, 0x5002a2, 0x6a00a8, 0x8405a7, 0x9c179e, 0xb12a90, 0xc33d80,
                           0xd35171, 0xe16462, 0xed7953, 0xf68f44, 0xfca636, 0xfec029, 0xf9dc24, 0xf0f921};
constexpr Table kInferno = {0x000004, 0x0c0826, 0x240c4f, 0x420a68, 0x5d126e, 0x781c6d, 0x932667, 0xae305c,
                            0xc73e4c, 0xdd513a, 0xed6925, 0xf8850f, 0xfca50a, 0xfac62d, 0xf2e661, 0xfcffa4};

ColorMap evenly(ColorSpace space, std::span<const glm::dvec3> colors) {
  ColorMap out;
  out.space = space;
  for (std::size_t i = 0; i < colors.size(); ++i)
    out.nodes.push_back({static_cast<double>(i) / static_cast<double>(colors.size() - 1), colors[i]});
  return out;
}

ColorMap evenly(const Table& table) {
  std::vector<glm::dvec3> colors;
  for (const std::uint32_t rgb : table) colors.push_back(glm::dvec3(rgb >> 16, rgb >> 8 & 0xff, rgb & 0xff) / 255.0);
  return evenly(ColorSpace::kRgb, colors);
}

}  // namespace

const std::vector<std::string>& colorMapNames() {
  static const std::vector<std::string> names = {"viridis", "plasma", "inferno", "cool-to-warm", "fire"};
  return names;
}

ColorMap namedColorMap(std::string_view name) {
  if (name == "viridis") return evenly(kViridis);
  if (name == "plasma") return evenly(kPlasma);
  if (name == "inferno") return evenly(kInferno);
  if (name == "cool-to-warm") {
    static constexpr glm::dvec3 kEnds[] = {
        {59 / 255.0, 76 / 255.0, 192 / 255.0}, {0.865, 0.865, 0.865}, {180 / 255.0, 4 / 255.0, 38 / 255.0}};
    return evenly(ColorSpace::kDiverging, kEnds);
  }
  static constexpr glm::dvec3 kGlow[] = {{0, 0, 0}, {0.6, 0.05, 0}, {1, 0.35, 0}, {1, 0.8, 0.2}, {1, 1, 0.92}};
  return evenly(ColorSpace::kRgb, kGlow);
}

}  // namespace kiln
