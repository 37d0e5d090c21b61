#include "scene/annotation_text.h"

#include <algorithm>
#include <cstddef>

namespace kiln {
namespace {

std::string withDoubledBraces(std::string_view text) {
  std::string out;
  for (const char c : text) out.append(c == '{' || c == '}' ? 2 : 1, c);
  return out;
}

}  // namespace

std::string wrongPlaceholder(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '{' && text[i] != '}') continue;
    if (i + 1 < text.size() && text[i + 1] == text[i]) {
      ++i;
      continue;
    }
    const std::size_t end = text[i] == '{' ? text.find('}', i) : std::string_view::npos;
    if (end == std::string_view::npos) return std::string(text.substr(i, text[i] == '{' ? std::string_view::npos : 1));
    if (std::ranges::find(kPlaceholders, text.substr(i + 1, end - i - 1)) == kPlaceholders.end())
      return std::string(text.substr(i, end - i + 1));
    i = end;
  }
  return {};
}

std::string filledIn(std::string_view text, const PlaceholderTexts& texts) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool doubled = i + 1 < text.size() && text[i + 1] == text[i];
    if (text[i] != '{' || doubled) {
      const bool brace = text[i] == '{' || text[i] == '}';
      out.append(brace ? 2 : 1, text[i]);
      i += brace ? 1 : 0;
      continue;
    }
    const std::size_t end = text.find('}', i);
    const auto name = std::ranges::find(kPlaceholders, text.substr(i + 1, end - i - 1));
    out += withDoubledBraces(texts[static_cast<std::size_t>(name - kPlaceholders.begin())]);
    i = end;
  }
  return out;
}

std::string withSingleBraces(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    out += text[i];
    if ((text[i] == '{' || text[i] == '}') && i + 1 < text.size() && text[i + 1] == text[i]) ++i;
  }
  return out;
}

}  // namespace kiln
