#include "annotate/font.h"

#include <algorithm>
#include <cstddef>

#include "base/text.h"

namespace kiln {
namespace {

constexpr char32_t kReplacement = 0xfffd;

// Takes the next character off the text.
char32_t takeCharacter(std::string_view& text) {
  const std::size_t bytes = bytesOfCharacter(text);
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  char32_t out = bytes == 0 ? kReplacement : bytes == 1 ? byte(0) : static_cast<char32_t>(byte(0) & (0x7f >> bytes));
  for (std::size_t i = 1; i < bytes; ++i) out = out << 6 | (byte(i) & 0x3f);
  text.remove_prefix(std::max<std::size_t>(bytes, 1));
  return out;
}

}  // namespace

Outline moved(Outline outline, const glm::dvec2& by) {
  for (Contour& contour : outline) {
    for (glm::dvec2& corner : contour) corner += by;
  }
  return outline;
}

TextLine lineOf(std::string_view utf8, double size) {
  TextLine out;
  char32_t before = 0;
  while (!utf8.empty()) {
    const char32_t character = takeCharacter(utf8);
    if (before != 0) out.width += size * font().kerning(before, character);
    const Font::Letter letter = font().letter(character);
    for (const Contour& contour : letter.outline) {
      Contour& placed = out.outline.emplace_back(contour);
      for (glm::dvec2& corner : placed) corner = size * corner + glm::dvec2(out.width, 0);
    }
    out.width += size * letter.advance;
    before = character;
  }
  return out;
}

}  // namespace kiln
