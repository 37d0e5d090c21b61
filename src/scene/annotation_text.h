// Text of an annotation with placeholders for a frame's numbers and a volume's facts: "{volume}, frame {frame}".
//
// Doubled braces stand for braces. A text whose placeholders are filled in keeps doubled braces, so that filling it in
// again changes nothing: the resolved job of a picture draws an equal picture.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace kiln {

inline constexpr std::array<std::string_view, 7> kPlaceholders = {"frame",   "time",    "volume", "unit",
                                                                  "minimum", "maximum", "voxels"};

/// The texts of the placeholders, in the order of kPlaceholders.
using PlaceholderTexts = std::array<std::string, kPlaceholders.size()>;

/// Returns an empty text for a legal text, else the wrong part, such as "{fraem}".
std::string wrongPlaceholder(std::string_view text);

/// Replaces placeholders and keeps doubled braces. requires: a legal text.
std::string filledIn(std::string_view text, const PlaceholderTexts& texts);

/// Returns the characters to draw. requires: a text without placeholders.
std::string withSingleBraces(std::string_view text);

}  // namespace kiln
