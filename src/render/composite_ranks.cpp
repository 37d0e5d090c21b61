#include "render/composite_ranks.h"

#include <cstring>

#include "base/pixel_rect.h"
#include "render/rank_messages.h"

namespace kiln {
namespace {

// Beyond those of the sequences (render/).
constexpr int kStripTag = 10, kMadeTag = 11;

// The smallest rectangle in rows y0 to y1 whose pixels show(x, y) something.
template <class Shows>
PixelRect shownIn(int width, int y0, int y1, const Shows& shows) {
  PixelRect out{width, y1, 0, y0};
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!shows(x, y)) continue;
      out.x0 = std::min(out.x0, x);
      out.x1 = std::max(out.x1, x + 1);
      out.y0 = std::min(out.y0, y);
      out.y1 = std::max(out.y1, y + 1);
    }
  }
  return out.empty() ? PixelRect{} : out;
}

// Of each pixel of some rows, how many layers it has, and they.
std::vector<std::byte> layersIn(const Image& part, int y0, int y1) {
  const PixelRect rect = shownIn(part.width, y0, y1, [&](int x, int y) { return pixelOf(part, x, y).covered > 0; });
  std::vector<std::byte> out;
  appendValue(out, rect);
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      appendValue(out, static_cast<std::uint16_t>(layersOf(part, x, y)));
      forEachLayer(part, x, y, [&](const EdgeLayer& layer) { appendValue(out, layer); });
    }
  }
  return out;
}

std::size_t placeOf(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

void layBehindAll(const std::vector<std::byte>& layers, int width, float opaque_at, std::vector<PartPixel>& made) {
  ByteTaker in{layers};
  const auto rect = in.take<PixelRect>();
  for (int y = rect.y0; y < rect.y1 && in.ok; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      for (auto left = in.take<std::uint16_t>(); left > 0 && in.ok; --left)
        layBehind(in.take<EdgeLayer>(), opaque_at, made[placeOf(x, y, width)]);
    }
  }
  requireTaken(in);
}

std::vector<std::byte> madeIn(const std::vector<PartPixel>& made, int width, int y0, int y1) {
  const PixelRect rect = shownIn(width, y0, y1, [&](int x, int y) { return made[placeOf(x, y, width)].covered > 0; });
  std::vector<std::byte> out;
  appendValue(out, rect);
  for (int y = rect.y0; y < rect.y1; ++y) {
    const auto row =
        std::as_bytes(std::span(made).subspan(placeOf(rect.x0, y, width), static_cast<std::size_t>(rect.width())));
    out.insert(out.end(), row.begin(), row.end());
  }
  return out;
}

void takeMade(const std::vector<std::byte>& bytes, int width, std::vector<PartPixel>& made) {
  ByteTaker in{bytes};
  const auto rect = in.take<PixelRect>();
  for (int y = rect.y0; y < rect.y1 && in.ok; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) made[placeOf(x, y, width)] = in.take<PartPixel>();
  }
  requireTaken(in);
}

}  // namespace

std::vector<PartPixel> compositeDirectly(Ranks& ranks, const Image& part, std::span<const int> order, float opaque_at) {
  const int me = ranks.rank();
  // The strip of rows that a rank puts together.
  const auto rowOf = [&](int rank) { return static_cast<int>(std::int64_t{part.height} * rank / ranks.count()); };
  const auto stripFor = [&](int rank) { return layersIn(part, rowOf(rank), rowOf(rank + 1)); };
  for (int to = 0; to < ranks.count(); ++to) {
    if (to != me) ranks.send(to, kStripTag, stripFor(to));
  }
  std::vector<PartPixel> made(part.rgba.size() / 4);
  for (const int from : order)
    layBehindAll(from == me ? stripFor(me) : ranks.receive(kStripTag, from).bytes, part.width, opaque_at, made);
  if (!ranks.first()) {
    ranks.send(0, kMadeTag, madeIn(made, part.width, rowOf(me), rowOf(me + 1)));
    return made;
  }
  for (int from = 1; from < ranks.count(); ++from) takeMade(ranks.receive(kMadeTag, from).bytes, part.width, made);
  return made;
}

void compositeByReduction(Ranks& ranks, std::vector<PartPixel>& pixels, std::span<const int> order, float opaque_at) {
  const auto over = [opaque_at](const std::byte* front, std::byte* behind, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      PartPixel before, after;
      std::memcpy(&before, front + i * sizeof(PartPixel), sizeof(PartPixel));
      std::memcpy(&after, behind + i * sizeof(PartPixel), sizeof(PartPixel));
      if (after.covered > 0) layBehind(asLayer(after), opaque_at, before);
      std::memcpy(behind + i * sizeof(PartPixel), &before, sizeof(PartPixel));
    }
  };
  ranks.reduce(std::as_writable_bytes(std::span(pixels)), sizeof(PartPixel), over, order);
}

}  // namespace kiln
