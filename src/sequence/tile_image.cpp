#include "sequence/tile_image.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace kiln {
namespace {

void putRows(const ZeroPages<float>& from, int channels, const PixelRect& at, const PixelRect& whole,
             ZeroPages<float>& to) {
  const auto row = static_cast<std::size_t>(at.width()) * static_cast<std::size_t>(channels);
  for (int y = 0; y < at.height(); ++y) {
    const std::size_t first = static_cast<std::size_t>(at.y0 - whole.y0 + y) * static_cast<std::size_t>(whole.width()) +
                              static_cast<std::size_t>(at.x0 - whole.x0);
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * row), row,
                to.begin() + static_cast<std::ptrdiff_t>(first * static_cast<std::size_t>(channels)));
  }
}

ZeroPages<float> takeFloats(ByteTaker& taker, std::size_t count) {
  const std::span<const std::byte> bytes = taker.takeBytes(count * sizeof(float));
  ZeroPages<float> out(bytes.size() / sizeof(float));
  std::memcpy(out.data(), bytes.data(), bytes.size());
  return out;
}

}  // namespace

void putTile(const Image& tile, const PixelRect& at, const PixelRect& whole, Image& image) {
  putRows(tile.rgba, 4, at, whole, image.rgba);
  for (std::size_t i = 0; i < tile.planes.size(); ++i) {
    if (i == image.planes.size())
      image.planes.push_back({tile.planes[i].name, ZeroPages<float>(image.rgba.size() / 4)});
    putRows(tile.planes[i].values, 1, at, whole, image.planes[i].values);
  }
}

void appendTile(std::vector<std::byte>& out, const PixelRect& at, const Image& tile) {
  const auto put = [&](const ZeroPages<float>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    out.insert(out.end(), bytes.begin(), bytes.end());
  };
  out.reserve(out.size() + sizeof at + (4 + tile.planes.size()) * tile.rgba.size());
  appendValue(out, at);
  put(tile.rgba);
  appendValue(out, static_cast<std::uint32_t>(tile.planes.size()));
  for (const Plane& plane : tile.planes) {
    appendText(out, plane.name);
    put(plane.values);
  }
}

std::optional<Image> takeTile(ByteTaker& taker, const PixelRect& at) {
  const std::size_t pixels = at.count();
  Image out;
  out.width = at.width();
  out.height = at.height();
  out.rgba = takeFloats(taker, 4 * pixels);
  const auto planes = taker.take<std::uint32_t>();
  for (std::uint32_t i = 0; i < planes && taker.ok; ++i) {
    std::string name = taker.takeText();
    out.planes.push_back({std::move(name), takeFloats(taker, pixels)});
  }
  return taker.ok && taker.left.empty() ? std::optional(std::move(out)) : std::nullopt;
}

}  // namespace kiln
