#include "image/plot_image.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "image/srgb.h"

namespace kiln {
namespace {

constexpr int kGlyphWidth = 5, kGlyphHeight = 7;
constexpr char kFirst = ' ', kLast = '~';
// One character of ASCII each: seven rows of five bits from the top, the left pixel in the highest bit.
constexpr std::uint64_t kGlyphs[] = {
    0x000000000ull, 0x108421004ull, 0x294000000ull, 0x295f57d4aull, 0x11f4717c4ull, 0x632222263ull, 0x32544564dull,
    0x108000000ull, 0x088842082ull, 0x208210888ull, 0x009575480ull, 0x0084f9080ull, 0x000003088ull, 0x0000f8000ull,
    0x00000018cull, 0x002222200ull, 0x3a33ae62eull, 0x11842108eull, 0x3a211111full, 0x7c441062eull, 0x08ca97c42ull,
    0x7e1e0862eull, 0x1910f462eull, 0x7c2222108ull, 0x3a317462eull, 0x3a317844cull, 0x018c03180ull, 0x018c03088ull,
    0x088882082ull, 0x001f07c00ull, 0x208208888ull, 0x3a2111004ull, 0x3a216d6aeull, 0x3a318fe31ull, 0x7a31f463eull,
    0x3a308422eull, 0x72518c65cull, 0x7e10f421full, 0x7e10f4210ull, 0x3a30bc62full, 0x4631fc631ull, 0x38842108eull,
    0x1c4210a4cull, 0x4654c5251ull, 0x42108421full, 0x4775ac631ull, 0x4639ace31ull, 0x3a318c62eull, 0x7a31f4210ull,
    0x3a318d64dull, 0x7a31f5251ull, 0x3e107043eull, 0x7c8421084ull, 0x46318c62eull, 0x46318c544ull, 0x4631ad6aaull,
    0x462a22a31ull, 0x463151084ull, 0x7c222221full, 0x39084210eull, 0x020820820ull, 0x38421084eull, 0x115100000ull,
    0x00000001full, 0x208200000ull, 0x000e0be2full, 0x4216cc63eull, 0x000e8422eull, 0x042d9c62full, 0x000e8fe0eull,
    0x1928e2108ull, 0x01f18bc2eull, 0x4216cc631ull, 0x100c2108eull, 0x080610a4cull, 0x4212a6292ull, 0x30842108eull,
    0x001aad631ull, 0x0016cc631ull, 0x000e8c62eull, 0x001e8fa10ull, 0x000d9bc21ull, 0x0016cc210ull, 0x000e8383eull,
    0x211c42126ull, 0x00118c66dull, 0x00118c544ull, 0x00118d6aaull, 0x001151151ull, 0x00118bc2eull, 0x001f1111full,
    0x088441082ull, 0x108421084ull, 0x208411088ull, 0x0008a8800ull,
};

std::uint64_t glyphOf(char c) { return kGlyphs[(c < kFirst || c > kLast ? '?' : c) - kFirst]; }

}  // namespace

PlotImage::PlotImage(int width, int height, const glm::dvec3& srgb) : image_(width, height) {
  fill({0, 0, width, height}, srgb);
}

void PlotImage::fill(const PixelRect& rect, const glm::dvec3& srgb) {
  float linear[3];
  // A colour of whole bytes, which dithering leaves flat.
  for (int channel = 0; channel < 3; ++channel)
    linear[channel] = static_cast<float>(linearFromSrgb(std::round(255 * srgb[channel]) / 255));
  for (int y = std::max(rect.y0, 0); y < std::min(rect.y1, image_.height); ++y) {
    for (int x = std::max(rect.x0, 0); x < std::min(rect.x1, image_.width); ++x) {
      float* const pixel = image_.pixel(x, y);
      std::copy_n(linear, 3, pixel);
      pixel[3] = 1;
    }
  }
}

int PlotImage::textWidth(std::string_view text, int scale) {
  return std::max(0, static_cast<int>(text.size()) * (kGlyphWidth + 1) - 1) * scale;
}

int PlotImage::textHeight(int scale) { return kGlyphHeight * scale; }

void PlotImage::text(int x, int y, std::string_view text, const glm::dvec3& srgb, int scale) {
  for (const char c : text) {
    const std::uint64_t glyph = glyphOf(c);
    for (int bit = 0; bit < kGlyphWidth * kGlyphHeight; ++bit) {
      if ((glyph >> (kGlyphWidth * kGlyphHeight - 1 - bit) & 1) == 0) continue;
      const int px = x + bit % kGlyphWidth * scale, py = y + bit / kGlyphWidth * scale;
      fill({px, py, px + scale, py + scale}, srgb);
    }
    x += (kGlyphWidth + 1) * scale;
  }
}

void PlotImage::draw(const Image& picture, int x, int y) {
  for (int row = std::max(0, -y); row < std::min(picture.height, image_.height - y); ++row) {
    for (int column = std::max(0, -x); column < std::min(picture.width, image_.width - x); ++column) {
      const float* const from = picture.pixel(column, row);
      float* const to = image_.pixel(x + column, y + row);
      for (int channel = 0; channel < 4; ++channel) to[channel] = from[channel] + (1 - from[3]) * to[channel];
    }
  }
}

}  // namespace kiln
