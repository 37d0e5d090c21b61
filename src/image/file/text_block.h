// The texts of a picture as one block of bytes, for formats without named texts.
//
// Each text is its key, "=", the number of its bytes, ":", its bytes and a line feed.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace kiln {

/// requires: keys without "=".
std::string textBlock(const std::map<std::string, std::string>& text);
/// Returns nothing for other bytes.
std::optional<std::map<std::string, std::string>> textsOfBlock(std::string_view block);

}  // namespace kiln
