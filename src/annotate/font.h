// Outlines of letters, in a module of its own: programs that draw no letters load no FreeType.
//
// The font is compiled in and its outlines are not hinted, so that letters have equal pixels on every machine.
#pragma once

#include <string_view>

#include "annotate/outline.h"

namespace kiln {

/// Height of a capital letter. unit: the font's size.
inline constexpr double kCapHeight = 0.729;

class Font {
 public:
  virtual ~Font() = default;
  struct Letter {
    Outline outline;     // from the letter's origin, y down. unit: the font's size
    double advance = 0;  // to the next letter's origin. unit: the font's size
  };
  /// Returns the letter of a Unicode character, or the font's box for an unknown one, which stays as long as the font.
  /// throws: Error kUnsupported.
  virtual const Letter& letter(char32_t character) const = 0;
  /// Returns the change of the advance between two neighbours. unit: the font's size.
  virtual double kerning(char32_t left, char32_t right) const = 0;
};

/// Returns false for a program that was built without a font.
bool hasFont();
/// Returns the font. throws: Error kUnsupported without the module. thread: safe.
const Font& font();

/// One line of text. Invalid UTF-8 is drawn as U+FFFD.
struct TextLine {
  Outline outline;   // from the beginning of the base line
  double width = 0;  // unit: pixels
};
/// `size`: of the font. unit: pixels.
TextLine lineOf(std::string_view utf8, double size);
/// Returns the width of such a line. cost: no outline.
double widthOf(std::string_view utf8, double size);

/// Returns the outline, moved.
Outline moved(Outline outline, const glm::dvec2& by);

}  // namespace kiln
