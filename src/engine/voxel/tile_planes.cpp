#include "engine/voxel/tile_planes.h"

#include <algorithm>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/voxel/tile_planes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/voxel/voxel_batch-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

using D8 = hn::CappedTag<float, 8>;

// Copies a row of `count` RGBA pixels into planes; joinRow copies it back.
void splitRow(const float* rgba, std::ptrdiff_t count, float* red, std::ptrdiff_t plane) {
  const D8 d;
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  std::ptrdiff_t x = 0;
  for (; x + lanes <= count; x += lanes) {
    hn::Vec<D8> r, g, b, a;
    hn::LoadInterleaved4(d, rgba + 4 * x, r, g, b, a);
    hn::StoreU(r, d, red + x);
    hn::StoreU(g, d, red + plane + x);
    hn::StoreU(b, d, red + 2 * plane + x);
    hn::StoreU(a, d, red + 3 * plane + x);
  }
  for (; x < count; ++x) {
    for (std::ptrdiff_t c = 0; c < 4; ++c) red[c * plane + x] = rgba[4 * x + c];
  }
}

void joinRow(const float* red, std::ptrdiff_t plane, std::ptrdiff_t count, float* rgba) {
  const D8 d;
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  std::ptrdiff_t x = 0;
  for (; x + lanes <= count; x += lanes) {
    hn::StoreInterleaved4(hn::LoadU(d, red + x), hn::LoadU(d, red + plane + x), hn::LoadU(d, red + 2 * plane + x),
                          hn::LoadU(d, red + 3 * plane + x), d, rgba + 4 * x);
  }
  for (; x < count; ++x) {
    for (std::ptrdiff_t c = 0; c < 4; ++c) rgba[4 * x + c] = red[c * plane + x];
  }
}

// Returns true if one of `columns` × `rows` pixels is open. `alpha` points to the first pixel, rows are `stride` floats
// apart. A whole vector may be read beyond the last column.
bool anyOpen(const float* alpha, int columns, int rows, std::ptrdiff_t stride) {
  const D8 d;
  const auto one = hn::Set(d, 1.0f);
  for (int x = 0; x < columns; x += static_cast<int>(hn::Lanes(d))) {
    auto least = one;
    const float* row = alpha + x;
    for (int y = 0; y < rows; ++y, row += stride) least = hn::Min(least, hn::LoadU(d, row));
    const auto counted = hn::Lt(hn::Iota(d, static_cast<float>(x)), hn::Set(d, static_cast<float>(columns)));
    if (!hn::AllFalse(d, hn::And(counted, hn::Lt(least, one)))) return true;
  }
  return false;
}

// Finds the footprints of a batch that have an open pixel. `alpha` points to the tile's first pixel; rows are `stride`
// floats apart.
class OpenFootprints {
  using VI = hn::Vec<DB>;
  static constexpr int kMost = 31;  // columns and rows

 public:
  OpenFootprints(const ProjectedVoxels& voxels, std::uint32_t asked, const PixelRect& tile, const float* alpha,
                 std::ptrdiff_t stride)
      : voxels_(voxels), asked_(asked), tile_(tile), alpha_(alpha), stride_(stride) {}

  // Neighbouring footprints overlap, so each pixel is tested once for all footprints. A row of pixels becomes a mask,
  // and each footprint tests its columns of the mask.
  std::uint32_t find() {
    const PixelRect all = intersection(rectAround(voxels_, asked_), tile_);
    if (all.width() > kMost || all.height() > kMost) return findEach();
    std::int32_t rows[kMost];
    for (int y = 0; y < all.height(); ++y) rows[y] = openOfRow(all.x0, all.y0 + y, all.width());
    const DB d;
    const VI most = hn::Set(d, kMost), one = hn::Set(d, 1);
    std::uint32_t out = 0;
    for (std::size_t n = 0; n < kVoxelBatch; n += hn::Lanes(d)) {
      const VI y0 = hn::Sub(hn::Load(d, voxels_.y0 + n), hn::Set(d, all.y0));
      const VI y1 = hn::Sub(hn::Load(d, voxels_.y1 + n), hn::Set(d, all.y0));
      VI open = hn::Zero(d);
      for (int y = 0; y < all.height(); ++y) {
        const VI row = hn::Set(d, y);
        open = hn::Or(open, hn::IfThenElseZero(hn::AndNot(hn::Gt(y0, row), hn::Gt(y1, row)), hn::Set(d, rows[y])));
      }
      // Voxels outside `asked` may have arbitrary columns.
      const auto column = [&](const std::int32_t* x) {
        return hn::Min(hn::Max(hn::Sub(hn::Load(d, x + n), hn::Set(d, all.x0)), hn::Zero(d)), most);
      };
      const VI columns = hn::Sub(hn::Shl(one, column(voxels_.x1)), hn::Shl(one, column(voxels_.x0)));
      out |= bitsOf(d, hn::Ne(hn::And(open, columns), hn::Zero(d))) << n;
    }
    return out & asked_;
  }

 private:
  // Returns a mask of open pixels. Bits beyond `columns` are undefined.
  std::int32_t openOfRow(int x, int y, int columns) const {
    const D8 d;
    const float* const row = at(x, y);
    std::uint32_t out = 0;
    for (int i = 0; i < columns; i += static_cast<int>(hn::Lanes(d)))
      out |= bitsOf(d, hn::Lt(hn::LoadU(d, row + i), hn::Set(d, 1.0f))) << i;
    return static_cast<std::int32_t>(out);
  }

  std::uint32_t findEach() const {
    std::uint32_t out = 0;
    forEachBit(asked_, [&](std::size_t n) {
      const PixelRect rect = intersection(voxels_.rect(n), tile_);
      out |= static_cast<std::uint32_t>(anyOpen(at(rect.x0, rect.y0), rect.width(), rect.height(), stride_)) << n;
    });
    return out;
  }

  const float* at(int x, int y) const { return alpha_ + (y - tile_.y0) * stride_ + (x - tile_.x0); }

  const ProjectedVoxels& voxels_;
  const std::uint32_t asked_;
  const PixelRect tile_;
  const float* const alpha_;
  const std::ptrdiff_t stride_;
};

std::uint32_t openOf(const ProjectedVoxels& voxels, std::uint32_t asked, const PixelRect& tile, const float* alpha,
                     std::ptrdiff_t stride) {
  return OpenFootprints(voxels, asked, tile, alpha, stride).find();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(splitRow);
HWY_EXPORT(joinRow);
HWY_EXPORT(openOf);

void TilePlanes::reserve(const PixelRect& tile) {
  const std::size_t needed =
      bytesFor(static_cast<std::size_t>(tile.width()), static_cast<std::size_t>(tile.height())) / sizeof(float);
  if (values_.size() >= needed) return;
  // Free the old memory before allocating, and allocate exactly `needed`: the memory is charged to the budget.
  values_ = {};
  values_ = std::vector<float>(needed);
}

void TilePlanes::take(const TilePixels& tile) noexcept {
  assert(bytesFor(static_cast<std::size_t>(tile.rect.width()), static_cast<std::size_t>(tile.rect.height())) <=
         values_.size() * sizeof(float));
  tile_ = tile;
  plane_ = tile.rect.width() + 2 * kBeside;
  const auto split = HWY_DYNAMIC_DISPATCH(splitRow);
  for (int y = tile.rect.y0; y < tile.rect.y1; ++y) {
    float* const row = at(tile.rect.x0, y);
    for (std::ptrdiff_t c = 0; c < 4; ++c) {
      const float beside = c == 3 ? 1.0f : 0.0f;
      std::fill_n(row + c * plane_ - kBeside, kBeside, beside);
      std::fill_n(row + c * plane_ + tile.rect.width(), kBeside, beside);
    }
    split(tile.rgba + (y - tile.rect.y0) * tile.stride, tile.rect.width(), row, plane_);
  }
}

void TilePlanes::putBack() const {
  const auto join = HWY_DYNAMIC_DISPATCH(joinRow);
  const float* row = values_.data() + kBeside;
  for (int y = 0; y < tile_.rect.height(); ++y, row += 4 * plane_)
    join(row, plane_, tile_.rect.width(), tile_.rgba + y * tile_.stride);
}

std::uint32_t TilePlanes::open(const ProjectedVoxels& voxels, std::uint32_t asked) const {
  const float* const alpha = values_.data() + offsetOf(tile_.rect.x0, tile_.rect.y0) + 3 * plane_;
  return HWY_DYNAMIC_DISPATCH(openOf)(voxels, asked, tile_.rect, alpha, 4 * plane_);
}

}  // namespace kiln
#endif
