#include "render/composite_ranks.h"

#include <cstring>

#include "base/pixel_rect.h"
#include "render/rank_messages.h"

namespace kiln {
namespace {

// Beyond those of the sequences (render/).
constexpr int kStripTag = 10, kMadeTag = 11;

using Pixels = std::vector<PartPixel>;

void reduce(Ranks& ranks, Pixels& pixels, std::span<const int> order, float opaque_at) {
  const auto over = [opaque_at](const std::byte* front, std::byte* behind, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      PartPixel before, after;
      std::memcpy(&before, front + i * sizeof(PartPixel), sizeof(PartPixel));
      std::memcpy(&after, behind + i * sizeof(PartPixel), sizeof(PartPixel));
      layBehind(after, opaque_at, before);
      std::memcpy(behind + i * sizeof(PartPixel), &before, sizeof(PartPixel));
    }
  };
  ranks.reduce(std::as_writable_bytes(std::span(pixels)), sizeof(PartPixel), over, order);
}

// The smallest rectangle in `rows` that holds all that is covered.
PixelRect coveredIn(const Pixels& pixels, int width, int y0, int y1) {
  PixelRect out{width, y1, 0, y0};
  for (int y = y0; y < y1; ++y) {
    const PartPixel* const row = pixels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    for (int x = 0; x < width; ++x) {
      if (!(row[x].covered > 0)) continue;
      out.x0 = std::min(out.x0, x);
      out.x1 = std::max(out.x1, x + 1);
      out.y0 = std::min(out.y0, y);
      out.y1 = std::max(out.y1, y + 1);
    }
  }
  return out.empty() ? PixelRect{} : out;
}

std::vector<std::byte> pixelsIn(const Pixels& pixels, int width, const PixelRect& rect) {
  std::vector<std::byte> out;
  appendValue(out, rect);
  for (int y = rect.y0; y < rect.y1; ++y) {
    const auto row = std::as_bytes(std::span(pixels).subspan(
        static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(rect.x0),
        static_cast<std::size_t>(rect.width())));
    out.insert(out.end(), row.begin(), row.end());
  }
  return out;
}

// Calls put(pixel, place) for each that was sent, `place` in the whole image.
template <class Put>
void unpack(const std::vector<std::byte>& bytes, int width, const Put& put) {
  ByteTaker in{bytes};
  const auto rect = in.take<PixelRect>();
  for (int y = rect.y0; y < rect.y1 && in.ok; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x)
      put(in.take<PartPixel>(),
          static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  requireTaken(in);
}

void sendDirectly(Ranks& ranks, Pixels& pixels, int width, std::span<const int> order, float opaque_at) {
  const int height = static_cast<int>(pixels.size() / static_cast<std::size_t>(width));
  const auto rowOf = [&](int rank) { return static_cast<int>(std::int64_t{height} * rank / ranks.count()); };
  const int me = ranks.rank();
  for (int to = 0; to < ranks.count(); ++to) {
    if (to != me)
      ranks.send(to, kStripTag, pixelsIn(pixels, width, coveredIn(pixels, width, rowOf(to), rowOf(to + 1))));
  }
  const std::size_t begin = static_cast<std::size_t>(rowOf(me)) * static_cast<std::size_t>(width);
  const std::size_t end = static_cast<std::size_t>(rowOf(me + 1)) * static_cast<std::size_t>(width);
  Pixels strip(end - begin);
  for (const int from : order) {
    if (from == me)
      for (std::size_t i = begin; i < end; ++i) layBehind(pixels[i], opaque_at, strip[i - begin]);
    else
      unpack(ranks.receive(kStripTag, from).bytes, width,
             [&](const PartPixel& pixel, std::size_t i) { layBehind(pixel, opaque_at, strip[i - begin]); });
  }
  if (!ranks.first()) {
    std::copy(strip.begin(), strip.end(), pixels.begin() + static_cast<std::ptrdiff_t>(begin));
    ranks.send(0, kMadeTag, pixelsIn(pixels, width, coveredIn(pixels, width, rowOf(me), rowOf(me + 1))));
    return;
  }
  std::fill(pixels.begin(), pixels.end(), PartPixel{});
  std::copy(strip.begin(), strip.end(), pixels.begin());
  for (int from = 1; from < ranks.count(); ++from)
    unpack(ranks.receive(kMadeTag, from).bytes, width,
           [&](const PartPixel& pixel, std::size_t i) { pixels[i] = pixel; });
}

}  // namespace

CompositeBy fasterComposite(std::size_t /*pixels*/, int ranks) {
  return ranks > 2 ? CompositeBy::kDirectSend : CompositeBy::kReduction;
}

void compositeRanks(Ranks& ranks, Pixels& pixels, int width, std::span<const int> order, float opaque_at,
                    CompositeBy by) {
  if (by == CompositeBy::kReduction)
    reduce(ranks, pixels, order, opaque_at);
  else
    sendDirectly(ranks, pixels, width, order, opaque_at);
}

}  // namespace kiln
