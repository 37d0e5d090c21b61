#include "annotate/font.h"

#include <cstddef>

namespace kiln {
namespace {

constexpr char32_t kReplacement = 0xfffd;

// Takes the next character off the text.
char32_t takeCharacter(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  const std::size_t bytes = first < 0x80 ? 1 : first >> 5 == 6 ? 2 : first >> 4 == 14 ? 3 : first >> 3 == 30 ? 4 : 0;
  char32_t out = bytes == 1 ? first : static_cast<char32_t>(first & (0x7f >> bytes));
  bool legal = bytes > 0 && bytes <= text.size();
  for (std::size_t i = 1; legal && i < bytes; ++i) {
    legal = byte(i) >> 6 == 2;
    out = out << 6 | (byte(i) & 0x3f);
  }
  text.remove_prefix(legal ? bytes : 1);
  return legal ? out : kReplacement;
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
