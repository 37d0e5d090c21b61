#include "annotate/edge_letters.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "annotate/annotator.h"
#include "annotate/font.h"

namespace kiln {
namespace {

// Size of the font: a share of the shorter side, and at least so many pixels. A capital of 11 pixels' font has 8 rows,
// the fewest that are read without effort.
constexpr double kLettersOfSide = 22, kLeastFont_px = 11;
// From the edge of the picture to a letter, and the rim, which is wide: a letter may lie over bright bone. unit: the
// font's size.
constexpr double kEdgeGap = 0.35, kLetterRim = 0.2;

double letterSize(const ImageSize& size) {
  return std::max(std::min(size.width, size.height) / kLettersOfSide, kLeastFont_px);
}

Annotator annotatorOf(const EdgeLetters& letters, const Image& image) {
  return {edgeLetterShapes(letters, {image.width, image.height}), {0, 0, image.width, image.height}};
}

}  // namespace

int edgeLetterRoom(const ImageSize& size) {
  if (std::min(size.width, size.height) < kLeastLetteredSide) return 0;
  return static_cast<int>(std::ceil((2 * kEdgeGap + 1) * letterSize(size)));
}

std::vector<Shape> edgeLetterShapes(const EdgeLetters& letters, const ImageSize& size) {
  if (letters.left == 0 || edgeLetterRoom(size) == 0) return {};
  // Values outside a patient's body are dark in most windows.
  Style style(letterSize(size), glm::dvec3(1));
  style.halo = kLetterRim * style.em;
  Drawing drawing(style);
  const double gap = kEdgeGap * style.em, capital = kCapHeight * style.em;
  const double middle_x = 0.5 * size.width, middle_base = 0.5 * (size.height + capital);
  const auto write = [&](const char& letter, const glm::dvec2& base, Drawing::Align align) {
    drawing.text(std::string_view(&letter, 1), base, style.em, align);
  };
  write(letters.left, {gap, middle_base}, Drawing::Align::kLeft);
  write(letters.right, {size.width - gap, middle_base}, Drawing::Align::kRight);
  write(letters.top, {middle_x, gap + capital}, Drawing::Align::kCentre);
  write(letters.bottom, {middle_x, size.height - gap}, Drawing::Align::kCentre);
  return std::move(drawing).take();
}

void drawEdgeLetters(const EdgeLetters& letters, Image& image) {
  annotatorOf(letters, image).over(image, 0, 0, nullptr);
}

void addEdgeLetterPlanes(const EdgeLetters& letters, Image& image) {
  annotatorOf(letters, image).addPlanes(image, 0, nullptr);
}

}  // namespace kiln
