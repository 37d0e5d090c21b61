// Texts of declared colours, and the order of declared labels.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "grid/volume_info.h"

namespace kiln {

/// "#rrggbb", or "#rrggbbaa" unless the colour is opaque.
std::string textOf(const DisplayColor& color);
/// Parses these texts, with or without the mark in front; nothing for other texts.
std::optional<DisplayColor> displayColorOf(std::string_view text);

/// Sorts the labels; of equal labels the first is kept.
void sortDeclared(std::vector<DeclaredLook::Label>& labels);

}  // namespace kiln
