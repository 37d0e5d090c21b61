#include "image/file/text_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

#include "base/text.h"

namespace kiln {

std::string textBlock(const std::map<std::string, std::string>& text) {
  std::string out;
  for (const auto& [key, value] : text) out += fmt::format("{}={}:{}\n", key, value.size(), value);
  return out;
}

std::optional<std::map<std::string, std::string>> textsOfBlock(std::string_view block) {
  std::map<std::string, std::string> out;
  while (!block.empty()) {
    const std::size_t equals = block.find('='), colon = block.find(':', std::min(equals, block.size()));
    if (equals == std::string_view::npos || colon == std::string_view::npos) return std::nullopt;
    const auto bytes = numberOf<std::size_t>(block.substr(equals + 1, colon - equals - 1));
    const std::string_view rest = block.substr(colon + 1);
    if (!bytes || *bytes >= rest.size() || rest[*bytes] != '\n') return std::nullopt;
    out[std::string(block.substr(0, equals))] = rest.substr(0, *bytes);
    block = rest.substr(*bytes + 1);
  }
  return out;
}

}  // namespace kiln
