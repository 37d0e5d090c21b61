// How fast partial images of ranks are put together, by MPI's reduction and by direct sending: run under mpirun, once
// for each number of ranks. Each rank's image is a slab's: it covers the part of the picture that 1/N of a cube does.
// Prints megapixels of the whole picture a second, the best of five, beside the bytes that any algorithm must move: all
// that is covered, to where it is put together, from each rank but one.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <numeric>

#include "render/composite_ranks.h"

namespace {

using namespace kiln;

Image slabImage(int size, int rank, int ranks) {
  Image out(size, size);
  out.planes = {{"coverage", ZeroPages<float>(out.rgba.size() / 4)}};
  // Seen from the side, a rank's slab is a band of rows, half of which its neighbours cover, too.
  const int begin = size * rank / (ranks + 1), end = size * (rank + 2) / (ranks + 1);
  constexpr float kColor[] = {0.2f, 0.3f, 0.1f, 0.5f};
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < size; ++x) {
      std::copy_n(kColor, 4, out.pixel(x, y));
      out.planes[0].values[static_cast<std::size_t>(y * size + x)] = 1;
    }
  }
  return out;
}

std::vector<PartPixel> pixelsOf(const Image& part) {
  std::vector<PartPixel> out;
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) out.push_back(pixelOf(part, x, y));
  }
  return out;
}

// Of five times that `composite` is called, each time after `prepare`.
template <class Prepare, class Composite>
double bestSeconds(Ranks& ranks, const Prepare& prepare, const Composite& composite) {
  double best = 1e30;
  for (int i = 0; i < 5; ++i) {
    prepare();
    ranks.barrier();
    const auto begin = std::chrono::steady_clock::now();
    composite();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return best;
}

}  // namespace

int main() {
  const std::unique_ptr<Ranks> ranks = mpiRanks();
  std::vector<int> order(static_cast<std::size_t>(ranks->count()));
  std::iota(order.begin(), order.end(), 0);
  if (ranks->first()) fmt::print("ranks size    MPI reduction  direct send   sent by it  must be moved\n");
  for (const int size : {256, 512, 1024, 2048, 4096}) {
    const Image part = slabImage(size, ranks->rank(), ranks->count());
    std::vector<PartPixel> pixels;
    const double by_reduction = bestSeconds(
        *ranks, [&] { pixels = pixelsOf(part); }, [&] { compositeByReduction(*ranks, pixels, order, 0.998f); });
    const std::uint64_t before = ranks->traffic().sent_bytes;
    const double by_sending = bestSeconds(
        *ranks, [] {}, [&] { compositeDirectly(*ranks, part, order, 0.998f); });
    std::uint64_t sent = (ranks->traffic().sent_bytes - before) / 5;
    std::vector<std::byte> bytes(sizeof(sent));
    std::copy_n(reinterpret_cast<const std::byte*>(&sent), sizeof(sent), bytes.begin());
    std::uint64_t all = 0;
    for (const auto& one : ranks->gather(bytes)) {
      std::copy_n(one.begin(), sizeof(sent), reinterpret_cast<std::byte*>(&sent));
      all += sent;
    }
    if (!ranks->first()) continue;
    const double megapixels = 1e-6 * size * size, mib = 1.0 / (1 << 20);
    const double least = 2e6 * megapixels / (ranks->count() + 1) * (ranks->count() - 1) * sizeof(PartPixel);
    fmt::print("{:5} {:4}²  {:7.1f} MP/s  {:7.1f} MP/s  {:7.1f} MiB  {:7.1f} MiB\n", ranks->count(), size,
               megapixels / by_reduction, megapixels / by_sending, mib * static_cast<double>(all), mib * least);
  }
}
