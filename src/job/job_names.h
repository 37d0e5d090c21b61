// The words that jobs and the command line share, in the order of their enumerators.
#pragma once

#include <array>
#include <string_view>

#include "scene/render_options.h"

namespace kiln {

inline constexpr std::array<std::string_view, 3> kProjectionNames = {"perspective", "orthographic", "equirectangular"};
inline constexpr std::size_t kSides = 6;
/// Behind the sides, anatomical names of the first four; left and right are anatomical themselves.
inline constexpr std::array<std::string_view, 10> kSideNames = {
    "front", "back", "top", "bottom", "left", "right", "anterior", "posterior", "superior", "inferior"};
inline constexpr std::array<std::string_view, 5> kVisibilityNames = {"none", "mask", "range-tree", "quadtree",
                                                                     "overlay"};
inline constexpr std::array<std::string_view, 2> kShadingNames = {"none", "phong"};
inline constexpr std::array<std::string_view, 2> kOccludesNames = {"ambient", "all"};
inline constexpr std::array<std::string_view, 4> kLightNames = {"headlight", "directional", "point", "camera"};
inline constexpr std::array<std::string_view, 2> kRegionShapeNames = {"rectangle", "triangle"};
inline constexpr std::array<std::string_view, 3> kEaseNames = {"smooth", "linear", "stop"};
inline constexpr std::array<std::string_view, 2> kToneNames = {"clip", "soft"};
inline constexpr std::array<std::string_view, 2> kLookNames = {"plain", "studio"};
inline constexpr std::array<std::string_view, 3> kFitNames = {"visible", "region", "box"};
inline constexpr std::array<std::string_view, 6> kLegendPlaceNames = {"right",    "left",         "top-right",
                                                                      "top-left", "bottom-right", "bottom-left"};
inline constexpr std::array<std::string_view, 3> kQualityNames = {"draft", "good", "best"};
inline constexpr std::array<std::string_view, 2> kPivotNames = {"eye", "target"};
inline constexpr std::array<std::string_view, 3> kAovNames = {"depth", "normal", "value"};
inline constexpr std::array<std::string_view, 6> kContentNames = {"picture", "color", "depth",
                                                                  "normal",  "value", "deep"};
inline constexpr std::array<std::string_view, 3> kStereoEyeNames = {"left", "right", "both"};
// The first five are lossless.
inline constexpr std::array<std::string_view, 7> kExrCompressionNames = {"none", "rle",  "zips", "zip",
                                                                         "piz",  "dwaa", "dwab"};
inline constexpr std::array<std::string_view, 4> kDistributionNames = {"auto", "tiles", "frames", "bricks"};
inline constexpr std::array<std::string_view, 2> kColorSpaceNames = {"linear", "srgb"};
inline constexpr std::array<std::string_view, 2> kExrTypeNames = {"half", "float"};
inline constexpr std::array<std::string_view, 2> kSampleTestNames = {"untested", "tested"};
inline constexpr std::array<std::string_view, 2> kProjectedAreaNames = {"box", "sphere"};

}  // namespace kiln
