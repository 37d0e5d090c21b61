#include "render/composite_ranks.h"

#include <cstring>
#include <type_traits>
#include <utility>

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

std::vector<std::byte> pixelsIn(const Pixels& pixels, const EdgeLayers* edges, int width, const PixelRect& rect) {
  std::vector<std::byte> out;
  appendValue(out, rect);
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      PartPixel pixel =
          pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
      const int edge_x = edges == nullptr ? 0 : x + edges->rect().x0,
                edge_y = edges == nullptr ? 0 : y + edges->rect().y0;
      const int layers = edges == nullptr ? 0 : edges->count(edge_x, edge_y);
      // A number below nothing says how many layers follow.
      if (layers > 0) pixel.covered = static_cast<float>(-layers);
      appendValue(out, pixel);
      if (layers > 0) edges->forEach(edge_x, edge_y, [&](const EdgeLayer& layer) { appendValue(out, layer); });
    }
  }
  return out;
}

// Calls lay(place, layer) for all that was sent, `layer` an EdgeLayer or a PartPixel and `place` in the whole image.
template <class Lay>
void unpack(const std::vector<std::byte>& bytes, int width, const Lay& lay) {
  ByteTaker in{bytes};
  const auto rect = in.take<PixelRect>();
  for (int y = rect.y0; y < rect.y1 && in.ok; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x) {
      const auto pixel = in.take<PartPixel>();
      const std::size_t place =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
      if (pixel.covered >= 0) lay(place, pixel);
      for (auto left = static_cast<int>(-pixel.covered); left > 0 && in.ok; --left) lay(place, in.take<EdgeLayer>());
    }
  }
  requireTaken(in);
}

void sendDirectly(Ranks& ranks, PartImage& image, std::span<const int> order, float opaque_at) {
  const int width = image.width;
  const int height = static_cast<int>(image.pixels.size() / static_cast<std::size_t>(width));
  const auto rowOf = [&](int rank) { return static_cast<int>(std::int64_t{height} * rank / ranks.count()); };
  const auto packed = [&](const Pixels& pixels, const EdgeLayers* edges, int rank) {
    return pixelsIn(pixels, edges, width, coveredIn(pixels, width, rowOf(rank), rowOf(rank + 1)));
  };
  const int me = ranks.rank();
  for (int to = 0; to < ranks.count(); ++to) {
    if (to != me) ranks.send(to, kStripTag, packed(image.pixels, image.edges.get(), to));
  }
  Pixels made(image.pixels.size());
  for (const int from : order) {
    const std::vector<std::byte> strip =
        from == me ? packed(image.pixels, image.edges.get(), me) : ranks.receive(kStripTag, from).bytes;
    unpack(strip, width, [&](std::size_t i, const auto& layer) { layBehind(layer, opaque_at, made[i]); });
  }
  image.pixels = std::move(made);
  if (!ranks.first()) {
    ranks.send(0, kMadeTag, packed(image.pixels, nullptr, me));
    return;
  }
  for (int from = 1; from < ranks.count(); ++from)
    unpack(ranks.receive(kMadeTag, from).bytes, width, [&](std::size_t i, const auto& pixel) {
      if constexpr (std::is_same_v<std::decay_t<decltype(pixel)>, PartPixel>) image.pixels[i] = pixel;
    });
}

}  // namespace

void compositeRanks(Ranks& ranks, PartImage& image, std::span<const int> order, float opaque_at, CompositeBy by) {
  if (by == CompositeBy::kReduction)
    reduce(ranks, image.pixels, order, opaque_at);
  else
    sendDirectly(ranks, image, order, opaque_at);
}

}  // namespace kiln
