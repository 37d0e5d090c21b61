#include "frame/pixel_filter.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "job/job_facts.h"
#include "occlusion/visibility.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "frame/pixel_filter.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Computes to[i] as the sum over k of weights[k] times the float `stride` k behind.
template <class D>
HWY_INLINE void weigh(D d, const float* const* from, const float* weights, int taps, float* to) {
  auto sum = hn::Mul(hn::LoadU(d, from[0]), hn::Set(d, weights[0]));
  for (int k = 1; k < taps; ++k) sum = hn::Add(sum, hn::Mul(hn::LoadU(d, from[k]), hn::Set(d, weights[k])));
  hn::StoreU(sum, d, to);
}

// Adds rows of samples into one row. requires: `floats` is a multiple of four.
void weighRows(const float* const* rows, const float* weights, int taps, std::size_t floats, float* line) {
  const hn::CappedTag<float, 16> d;
  const hn::CappedTag<float, 4> d4;
  const float* from[4];
  std::size_t i = 0;
  const auto step = [&](auto tag) {
    for (int k = 0; k < taps; ++k) from[k] = rows[k] + i;
    weigh(tag, from, weights, taps, line + i);
    i += hn::Lanes(tag);
  };
  while (i + hn::Lanes(d) <= floats) step(d);
  while (i < floats) step(d4);
}

// Filters a row of samples into a row of pixels, `edge` samples apart; `line` is the first sample of the first pixel.
void weighColumns(const float* line, const float* weights, int taps, int edge, std::size_t pixels, float* to) {
  const hn::CappedTag<float, 16> d;
  const hn::CappedTag<float, 4> d4;
  const float* from[4];
  std::size_t i = 0;
  const std::size_t floats = 4 * pixels;
  const auto step = [&](auto tag) {
    // Offset from a pixel's first channel.
    const float* const first = line + static_cast<std::size_t>(edge) * (i / 4 * 4) + i % 4;
    for (int k = 0; k < taps; ++k) from[k] = first + 4 * k;
    weigh(tag, from, weights, taps, to + i);
    i += hn::Lanes(tag);
  };
  // Pixels are contiguous in memory only if each pixel is one sample.
  while (edge == 1 && i + hn::Lanes(d) <= floats) step(d);
  while (i < floats) step(d4);
}

// Filters pixels of rays in quincunx. A pixel's weights cover the sub-pixels with rays among 4 × 4, starting in
// rows[..], except two corners that are farther than a pixel.
void weighQuincunx(const float* const* rows, std::size_t pixels, float* to) {
  const hn::CappedTag<float, 4> d;
  const auto near = hn::Set(d, 10 / 32.0f), far = hn::Set(d, 3 / 32.0f);
  for (std::size_t n = 0; n < pixels; ++n) {
    for (std::size_t c = 0; c < 4; c += hn::Lanes(d)) {
      const auto at = [&](int row, std::size_t column) { return hn::LoadU(d, rows[row] + 8 * n + 4 * column + c); };
      const auto own = hn::Add(at(1, 1), at(2, 2));
      const auto beside = hn::Add(hn::Add(at(0, 2), at(1, 3)), hn::Add(at(2, 0), at(3, 1)));
      hn::StoreU(hn::Add(hn::Mul(own, near), hn::Mul(beside, far)), d, to + 4 * n + c);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(weighRows);
HWY_EXPORT(weighColumns);
HWY_EXPORT(weighQuincunx);

// Gaussians of 0.48, 0.46 and 0.3 pixel in fractions of a power of two: sums are exactly 1 in any order. For 16 rays a
// pixel the mean is as good (figures: engine/pixel/decisions/pixels.md).
PixelFilter::PixelFilter(int samples, bool of_rays) : edge_(subPixelsAlongEdge(samples)) {
  if (of_rays && samples == 1) {
    reach_ = 1;
    weights_ = {3 / 32.0f, 26 / 32.0f, 3 / 32.0f};
  } else if (samples == 2) {
    assert(of_rays);
    reach_ = 1;
    quincunx_ = true;
  } else if (of_rays && samples == 4) {
    reach_ = 1;
    weights_ = {1 / 32.0f, 15 / 32.0f, 15 / 32.0f, 1 / 32.0f};
  } else {
    std::fill_n(weights_.begin(), edge_, 1 / static_cast<float>(edge_));
  }
}

PixelFilter pixelFilterOf(const EngineChoice& engine, int samples, bool filters_rays) {
  return PixelFilter(samples, filters_rays && engine.capabilities().filters_rays);
}

std::vector<PixelRect> bandsOf(const PixelRect& pixels, const ImageSize& size, const PixelFilter& filter, int band_px) {
  if (filter.inPlace(pixels, size)) return {pixels};
  const int tile = kVisibilityTile / filter.edge();
  const int step = std::max(band_px / kVisibilityTile, 1) * tile;
  std::vector<PixelRect> out;
  PixelRect band = pixels;
  for (; band.y0 < pixels.y1; band.y0 = band.y1) {
    band.y1 = std::min(pixels.y1, band.y0 / tile * tile + step);
    out.push_back(band);
  }
  return out;
}

ImageSize bandSize(const PixelRect& pixels, const PixelFilter& filter, int band_px) {
  const int edge = filter.edge(), beside = 2 * filter.reach();
  return {edge * pixels.width() + beside, std::min(band_px, edge * pixels.height()) + beside};
}

PixelRect PixelFilter::samplesOf(const PixelRect& pixels, const ImageSize& size) const {
  const PixelRect all{0, 0, edge_ * size.width, edge_ * size.height};
  return intersection(
      {edge_ * pixels.x0 - reach_, edge_ * pixels.y0 - reach_, edge_ * pixels.x1 + reach_, edge_ * pixels.y1 + reach_},
      all);
}

namespace {

// Mirrors a sample beyond the picture's edge.
int mirrored(int i, int samples) { return i < 0 ? -i : i < samples ? i : 2 * samples - 2 - i; }

}  // namespace

// Filters rows of pixels, with its own scratch memory.
class PixelFilter::Rows {
 public:
  /// `beside` samples of a row precede the first pixel's own samples.
  Rows(const PixelFilter& filter, int samples, int beside)
      : f_(filter), samples_(samples), beside_(beside), line_(4 * static_cast<std::size_t>(samples + 2 * f_.reach_)) {}

  /// requires: `rows` has the rows of all taps.
  void make(const float* const* rows, int pixels, float* to) {
    if (f_.quincunx_) return makeQuincunx(rows, pixels, to);
    const auto reach = static_cast<std::size_t>(f_.reach_);
    float* const first = line_.data() + 4 * reach;
    float* const end = first + 4 * static_cast<std::size_t>(samples_);
    HWY_DYNAMIC_DISPATCH(weighRows)(rows, f_.weights_.data(), f_.taps(), static_cast<std::size_t>(end - first), first);
    for (std::size_t i = 0; i < reach; ++i) {
      std::copy_n(first, 4, line_.data() + 4 * i);
      std::copy_n(end - 4, 4, end + 4 * i);
    }
    HWY_DYNAMIC_DISPATCH(weighColumns)
    (line_.data() + std::ptrdiff_t{4} * beside_, f_.weights_.data(), f_.taps(), f_.edge_,
     static_cast<std::size_t>(pixels), to);
  }

 private:
  void makeQuincunx(const float* const* rows, int pixels, float* to) const {
    // Mirroring at the sides keeps the pattern of sub-pixels with rays.
    const auto make = [&](int first, int count) {
      const float* from[kMostTaps];
      for (int k = 0; k < kMostTaps; ++k) from[k] = rows[k] + 4 * (2 * first + beside_ - 1);
      HWY_DYNAMIC_DISPATCH(weighQuincunx)(from, static_cast<std::size_t>(count), to + std::ptrdiff_t{4} * first);
    };
    const bool at_left = beside_ == 0, at_right = 2 * pixels + beside_ == samples_;
    const int first = at_left ? 1 : 0, end = pixels - (at_right ? 1 : 0);
    if (end > first) make(first, end - first);
    for (const int x : {0, pixels - 1}) {
      if (x >= first && x < end) continue;
      float patch[kMostTaps][4 * kMostTaps];
      const float* from[kMostTaps];
      for (int k = 0; k < kMostTaps; ++k) {
        for (int i = 0; i < kMostTaps; ++i)
          std::copy_n(rows[k] + 4 * mirrored(2 * x + beside_ - 1 + i, samples_), 4, patch[k] + 4 * i);
        from[k] = patch[k];
      }
      HWY_DYNAMIC_DISPATCH(weighQuincunx)(from, 1, to + std::ptrdiff_t{4} * x);
    }
  }

  const PixelFilter& f_;
  const int samples_, beside_;
  std::vector<float> line_;  // a row of samples, with mirrored samples at both ends
};

void PixelFilter::put(const Image& samples, const PixelRect& shown, const PixelRect& pixels, Image& image,
                      int row) const {
  const ProfileScope span(Activity::kFinish);
  if (shown.empty()) return;
  const int left = std::min(edge_ * pixels.x0, reach_), top = std::min(edge_ * pixels.y0, reach_);
  constexpr int kRows = 16;  // rows per task
  parallelFor(static_cast<std::size_t>((pixels.height() + kRows - 1) / kRows), [&](std::size_t chunk) {
    Rows rows(*this, samples.width, left);
    const int first = kRows * static_cast<int>(chunk);
    for (int y = first; y < std::min(first + kRows, pixels.height()); ++y) {
      const int own = edge_ * (pixels.y0 + y);  // first row of samples of the pixel
      if (own + edge_ + reach_ <= shown.y0 || own - reach_ >= shown.y1) continue;
      const float* from[kMostTaps];
      for (int k = 0; k < taps(); ++k) {
        const int at = edge_ * y + top - reach_ + k;
        from[k] = samples.pixel(0, quincunx_ ? mirrored(at, samples.height) : std::clamp(at, 0, samples.height - 1));
      }
      rows.make(from, pixels.width(), image.pixel(0, row + y));
    }
  });
}

int PixelFilter::rowsTogether(int height) {
  const int chunks = 4 * static_cast<int>(ThreadLimit::active());
  return std::max(16, (height + chunks - 1) / chunks);
}

std::uint64_t PixelFilter::copiedBytes(const ImageSize& size) {
  const int rows = rowsTogether(size.height);
  const auto chunks = static_cast<std::uint64_t>((size.height + rows - 1) / rows);
  // A task keeps two rows of each neighbour, and three more while it runs.
  return 5 * chunks * 16 * static_cast<std::uint64_t>(size.width);
}

void PixelFilter::apply(Image& image, const PixelRect& shown) const {
  const ProfileScope span(Activity::kFinish);
  if (shown.empty()) return;
  // Outside this rectangle samples are zero or absent.
  const PixelRect made =
      intersection(PixelRect{shown.x0 - reach_, shown.y0 - reach_, shown.x1 + reach_, shown.y1 + reach_},
                   {0, 0, image.width, image.height});
  const auto rowOf = [&](int y) { return image.pixel(made.x0, made.y0 + y); };
  const int kept = rowsTogether(made.height());
  const int chunks = (made.height() + kept - 1) / kept;
  const auto floats = 4 * static_cast<std::size_t>(made.width());
  const auto at = [&](std::vector<float>& rows, int i) { return rows.data() + static_cast<std::size_t>(i) * floats; };
  // Copies the rows that the neighbouring tasks still need.
  std::vector<float> last(floats * static_cast<std::size_t>(chunks)), first(last.size());
  for (int i = 0; i < chunks; ++i) {
    std::copy_n(rowOf(kept * i), floats, at(first, i));
    std::copy_n(rowOf(std::min(kept * (i + 1), made.height()) - 1), floats, at(last, i));
  }
  parallelFor(static_cast<std::size_t>(chunks), [&](std::size_t chunk) {
    const int i = static_cast<int>(chunk), end = std::min(kept * (i + 1), made.height());
    Rows rows(*this, made.width(), 0);
    std::vector<float> before(at(last, std::max(i - 1, 0)), at(last, std::max(i - 1, 0)) + floats), here(floats);
    if (i == 0) std::copy_n(at(first, 0), floats, before.data());
    for (int y = kept * i; y < end; ++y) {
      float* const row = rowOf(y);
      std::copy_n(row, floats, here.data());
      const bool is_last = y + 1 == end;
      const float* const after = !is_last ? rowOf(y + 1) : i + 1 < chunks ? at(first, i + 1) : here.data();
      const float* const from[kMostTaps] = {before.data(), here.data(), after};
      rows.make(from, made.width(), row);
      before.swap(here);
    }
  });
}

}  // namespace kiln
#endif
