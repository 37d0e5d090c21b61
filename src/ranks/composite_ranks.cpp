#include "ranks/composite_ranks.h"

#include <algorithm>

#include "frame/part_image.h"
#include "image/pixel_rect.h"
#include "ranks/rank_messages.h"

namespace kiln {
namespace {

// Tags above those of sequence/.
constexpr int kStripTag = 10, kMadeTag = 11;

// Returns the smallest rectangle in rows [y0, y1) outside of which alpha is zero.
PixelRect shownIn(const Image& image, int y0, int y1) {
  PixelRect out{image.width, y1, 0, y0};
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (image.pixel(x, y)[3] == 0) continue;
      out.x0 = std::min(out.x0, x);
      out.x1 = std::max(out.x1, x + 1);
      out.y0 = std::min(out.y0, y);
      out.y1 = std::max(out.y1, y + 1);
    }
  }
  return out.empty() ? PixelRect{} : out;
}

// Calls f(pointer, floats) for the colours of a row of the rectangle, and for each plane.
template <class SomeImage, class F>
void forEachRun(SomeImage& image, const PixelRect& rect, int y, const F& f) {
  const auto width = static_cast<std::size_t>(rect.width());
  f(image.pixel(rect.x0, y), 4 * width);
  for (auto& plane : image.planes)
    f(plane.values.data() + static_cast<std::ptrdiff_t>(y) * image.width + rect.x0, width);
}

// Packs the visible rectangle of rows [y0, y1).
std::vector<std::byte> packedRows(const Image& image, int y0, int y1) {
  const PixelRect rect = shownIn(image, y0, y1);
  std::vector<std::byte> out;
  out.reserve(sizeof(rect) + rect.count() * (4 + image.planes.size()) * sizeof(float));
  appendValue(out, rect);
  for (int y = rect.y0; y < rect.y1; ++y) {
    forEachRun(image, rect, y, [&](const float* from, std::size_t floats) {
      const auto bytes = std::as_bytes(std::span(from, floats));
      out.insert(out.end(), bytes.begin(), bytes.end());
    });
  }
  return out;
}

// An unpacked rectangle: an image with its place.
struct Strip {
  PixelRect rect;
  Image image;
};
Strip stripFrom(const std::vector<std::byte>& bytes, const Aovs& aovs) {
  ByteTaker in{bytes};
  Strip out;
  out.rect = in.take<PixelRect>();
  out.image = emptyPart(out.rect, aovs);
  const PixelRect all{0, 0, out.rect.width(), out.rect.height()};
  for (int y = 0; y < all.y1 && in.ok; ++y) {
    forEachRun(out.image, all, y, [&](float* to, std::size_t floats) {
      for (std::size_t i = 0; i < floats; ++i) to[i] = in.take<float>();
    });
  }
  requireTaken(in);
  return out;
}

}  // namespace

Image compositeDirectly(Ranks& ranks, Image& part, const Aovs& aovs, std::span<const int> order,
                        float opacity_threshold) {
  const int me = ranks.rank();
  // The strip of rows of one rank.
  const auto rowOf = [&](int rank) { return static_cast<int>(std::int64_t{part.height} * rank / ranks.count()); };
  const auto stripFor = [&](int rank) { return packedRows(part, rowOf(rank), rowOf(rank + 1)); };
  for (int to = 0; to < ranks.count(); ++to) {
    if (to != me) ranks.send(to, kStripTag, stripFor(to));
  }
  Image made = emptyPart({0, 0, part.width, part.height}, aovs);
  const auto lay = [&](const std::vector<std::byte>& bytes) {
    Strip strip = stripFrom(bytes, aovs);
    layBehind(strip.image, aovs, strip.rect.x0, strip.rect.y0, opacity_threshold, made);
  };
  for (const int from : order) lay(from == me ? stripFor(me) : ranks.receive(kStripTag, from).bytes);
  if (!ranks.first()) {
    ranks.send(0, kMadeTag, packedRows(made, rowOf(me), rowOf(me + 1)));
    return made;
  }
  for (int from = 1; from < ranks.count(); ++from) lay(ranks.receive(kMadeTag, from).bytes);
  return made;
}

}  // namespace kiln
