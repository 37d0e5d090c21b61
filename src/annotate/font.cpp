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

// Calls place(letter, x) for each letter of the text, x from the beginning. Returns the text's width.
template <class Place>
double forLetters(std::string_view utf8, double size, const Place& place) {
  const Font& letters = font();
  double width = 0;
  char32_t before = 0;
  while (!utf8.empty()) {
    const char32_t character = takeCharacter(utf8);
    if (before != 0) width += size * letters.kerning(before, character);
    const Font::Letter& letter = letters.letter(character);
    place(letter, width);
    width += size * letter.advance;
    before = character;
  }
  return width;
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
  out.width = forLetters(utf8, size, [&](const Font::Letter& letter, double x) {
    for (const Contour& contour : letter.outline) {
      Contour& placed = out.outline.emplace_back(contour);
      for (glm::dvec2& corner : placed) corner = size * corner + glm::dvec2(x, 0);
    }
  });
  return out;
}

double widthOf(std::string_view utf8, double size) {
  return forLetters(utf8, size, [](const Font::Letter&, double) {});
}

}  // namespace kiln
