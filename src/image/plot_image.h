// An opaque picture for sheets and plots: rectangles, pictures and text.
// Text is ASCII, in glyphs of 5 × 7 pixels, so that pixels are equal everywhere; other characters are drawn as '?'.
#pragma once

#include <glm/vec3.hpp>
#include <string_view>

#include "image/image.h"
#include "image/pixel_rect.h"

namespace kiln {

/// Colours of sheets of pictures: paper, text, captions. unit: sRGB.
inline const glm::dvec3 kSheetPaper{0.11, 0.12, 0.14}, kSheetInk{0.92, 0.92, 0.90}, kSheetCaption{0.60, 0.62, 0.66};

/// Colours are sRGB, 0..1. What lies outside the image is cut off.
class PlotImage {
 public:
  /// unit: pixels.
  PlotImage(int width, int height, const glm::dvec3& srgb);

  void fill(const PixelRect& rect, const glm::dvec3& srgb);
  /// Draws one line of text with its top left corner at (x, y); a glyph's pixel has `scale` pixels.
  void text(int x, int y, std::string_view text, const glm::dvec3& srgb, int scale = 1);
  /// unit: pixels.
  static int textWidth(std::string_view text, int scale = 1);
  static int textHeight(int scale = 1);
  /// Composites a picture over the image, its top left corner at (x, y).
  void draw(const Image& picture, int x, int y);

  const Image& image() const { return image_; }
  float* pixel(int x, int y) { return image_.pixel(x, y); }
  Image take() && { return std::move(image_); }

 private:
  Image image_;
};

}  // namespace kiln
