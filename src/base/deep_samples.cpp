// Between two depths a sample is evenly filled, as compositing programs take it that cut one: of a sample of alpha a,
// the front part t of its depth has alpha 1 - (1 - a)^t, and colours in proportion. Where two samples are told as one,
// what lies in front of a cut changes most at a border of theirs, for the logarithm of what light passes is straight
// between borders, before and after. So the errors of all mergings that made a sample bound its error by their sum.
#include "base/deep_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kiln {
namespace {

constexpr std::size_t kAlpha = 3;

// Of the sample's light, what comes from the front part t of its depth.
float partInFront(float alpha, float t) {
  if (t >= 1 || alpha >= 1) return 1;
  return alpha < 1e-4f ? t : -std::expm1(t * std::log1p(-alpha)) / alpha;
}

int squaresAlong(int from, int to, int edge) { return (to - 1) / edge - from / edge + 1; }

}  // namespace

DeepSamples::Rounded DeepSamples::rounded(float v) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(v);
  return static_cast<Rounded>((bits >> 16) + ((bits & 0xffff) != 0 ? 1 : 0));
}

float DeepSamples::valueOf(Rounded v) { return std::bit_cast<float>(static_cast<std::uint32_t>(v) << 16); }

DeepSamples::Kept DeepSamples::joined(const Kept& a, const Kept& b) {
  Kept out = a;
  const float open = 1 - a.sample.rgba[kAlpha];
  out.sample.z_back = b.sample.z_back;
  for (std::size_t c = 0; c < 4; ++c) out.sample.rgba[c] += open * b.sample.rgba[c];
  // An opaque layer stays one, whatever rounding says.
  if (b.sample.rgba[kAlpha] == 1) out.sample.rgba[kAlpha] = 1;
  out.error = a.joint;
  out.joint = b.joint;
  return out;
}

// `in_front`: what passes all that is in front of `a`.
DeepSamples::Rounded DeepSamples::jointError(const Kept& a, const Kept& b, float in_front) {
  const DeepSample both = joined(a, b).sample;
  const float depth = both.z_back - both.z;
  float most = 0;
  for (const float border : {a.sample.z_back, b.sample.z}) {
    const float part = partInFront(both.rgba[kAlpha], depth > 0 ? (border - both.z) / depth : 1);
    for (std::size_t c = 0; c < 4; ++c) most = std::max(most, std::abs(a.sample.rgba[c] - part * both.rgba[c]));
  }
  return rounded(valueOf(a.error) + valueOf(b.error) + in_front * most);
}

std::uint32_t DeepSamples::Square::take() {
  if (used == pages.size() * kPageChunks) pages.push_back(std::make_unique<Chunk[]>(kPageChunks));
  return used++;
}

DeepSamples::DeepSamples(const PixelRect& rect, const DeepBound& bound)
    : rect_(rect),
      bound_(bound),
      columns_(squaresAlong(rect.x0, rect.x1, kSquare)),
      pixels_(static_cast<std::size_t>(rect.width()) * static_cast<std::size_t>(rect.height())),
      squares_(static_cast<std::size_t>(columns_ * squaresAlong(rect.y0, rect.y1, kSquare))) {}

std::uint64_t DeepSamples::bytesFor(std::uint64_t pixels, const DeepBound& bound) {
  const auto chunks = static_cast<std::uint64_t>((bound.samples + kChunkSamples - 1) / kChunkSamples);
  // A page that is not full, and who keeps it, of every square.
  const std::uint64_t squares = pixels / (kSquare * kSquare) + 1;
  return pixels * (sizeof(Pixel) + chunks * sizeof(Chunk)) + squares * (kPageChunks * sizeof(Chunk) + sizeof(Square));
}

DeepSamples::Chunk& DeepSamples::lastChunk(const Square& square, const Pixel& pixel) const {
  Chunk* chunk = &square.at(pixel.first);
  for (int before = kChunkSamples; before < pixel.count; before += kChunkSamples) chunk = &square.at(chunk->next);
  return *chunk;
}

void DeepSamples::append(Square& square, Pixel& pixel, const Kept& sample) {
  if (pixel.count % kChunkSamples == 0) {
    const std::uint32_t next = square.take();
    (pixel.count == 0 ? pixel.first : lastChunk(square, pixel).next) = next;
  }
  const int place = pixel.count++ % kChunkSamples;
  lastChunk(square, pixel).samples[place] = sample;
}

// `sample` comes behind a full pixel: of all neighbours, those become one whose error is least. `open`: what passes all
// that is in front of the sample.
void DeepSamples::joinLeast(const Square& square, const Pixel& pixel, const Kept& sample, float open) {
  std::array<Kept*, DeepBound::kMostSamples + 1> all;
  Chunk* chunk = &square.at(pixel.first);
  const auto count = static_cast<std::size_t>(pixel.count);
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && i % kChunkSamples == 0) chunk = &square.at(chunk->next);
    all[i] = &chunk->samples[i % kChunkSamples];
  }
  Kept last = sample;
  all[count] = &last;
  const auto least =
      static_cast<std::size_t>(std::min_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count),
                                                [](const Kept* a, const Kept* b) { return a->joint < b->joint; }) -
                               all.begin());
  // What passes those in front of each that is looked at, counted from the back.
  for (std::size_t i = count; i-- > (least > 0 ? least - 1 : 0);) open /= 1 - all[i]->sample.rgba[kAlpha];
  *all[least] = joined(*all[least], *all[least + 1]);
  for (std::size_t i = least + 1; i < count; ++i) *all[i] = *all[i + 1];
  for (std::size_t i = least > 0 ? least - 1 : 0; i <= least && i + 1 < count; ++i) {
    all[i]->joint = jointError(*all[i], *all[i + 1], open);
    open *= 1 - all[i]->sample.rgba[kAlpha];
  }
}

void DeepSamples::add(int x, int y, float z, float z_back, const float* before, const float* after) {
  const float open = 1 - before[kAlpha];
  if (!(open > 0) || std::equal(before, before + 4, after)) return;
  Pixel& pixel = pixels_[placeOf(x, y)];
  Square& square = squares_[squareOf(x, y)];
  Kept sample{{z, z_back, {}}, 0, 0};
  for (std::size_t c = 0; c < 4; ++c) sample.sample.rgba[c] = std::max(after[c] - before[c], 0.0f) / open;
  float& alpha = sample.sample.rgba[kAlpha];
  alpha = after[kAlpha] >= 1 ? 1 : std::min(alpha, 1.0f);
  if (pixel.count > 0) {
    Kept& last = lastChunk(square, pixel).samples[(pixel.count - 1) % kChunkSamples];
    // Rounding does not put a slab into the one before.
    sample.sample.z = std::max(z, last.sample.z_back);
    sample.sample.z_back = std::max(z_back, sample.sample.z);
    last.joint = jointError(last, sample, open / (1 - last.sample.rgba[kAlpha]));
    if (valueOf(last.joint) <= bound_.error && bound_.error > 0) {
      last = joined(last, sample);
      return;
    }
  }
  if (pixel.count < bound_.samples)
    append(square, pixel, sample);
  else
    joinLeast(square, pixel, sample, open);
}

void DeepSamples::copy(int x, int y, DeepSample* out) const {
  const Pixel& pixel = pixels_[placeOf(x, y)];
  if (pixel.count == 0) return;
  const Square& square = squares_[squareOf(x, y)];
  const Chunk* chunk = &square.at(pixel.first);
  for (int i = 0; i < pixel.count; ++i) {
    if (i > 0 && i % kChunkSamples == 0) chunk = &square.at(chunk->next);
    out[i] = chunk->samples[i % kChunkSamples].sample;
  }
}

}  // namespace kiln
