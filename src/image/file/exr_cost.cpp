#include "image/file/exr_cost.h"

#include <algorithm>
#include <map>

#include "base/thread/parallel.h"

namespace kiln {
namespace {

constexpr int kMostExrThreads = 16;

// Measured cost of a compression, with noise, 100 to 8000 pixels a row, 1 to 8 threads; rounded up.
struct Cost {
  int rows;
  double half, full;  // buffer bytes per byte of a block, for half and float colours
  std::uint64_t thread_bytes;
};

const Cost& costOf(const std::string& compression) {
  constexpr std::uint64_t kKi = 1 << 10;
  static const std::map<std::string, Cost> kCosts = {
      {"none", {1, 1.3, 1.2, 16 * kKi}},     {"rle", {1, 3.8, 3.7, 16 * kKi}},    {"zips", {1, 3.2, 3.2, 288 * kKi}},
      {"zip", {16, 3.2, 3.2, 288 * kKi}},    {"piz", {32, 3.2, 3.2, 2048 * kKi}}, {"dwaa", {32, 4.6, 3.8, 2176 * kKi}},
      {"dwab", {256, 4.6, 3.8, 2176 * kKi}},
  };
  const auto found = kCosts.find(compression);
  return found != kCosts.end() ? found->second : kCosts.at("dwab");
}

std::uint64_t colorBytes(const ExrShape& shape) { return shape.exr_float ? 16 : 8; }

}  // namespace

// A few blocks per thread, between 32 rows and 32 MiB of rows.
ExrWork exrWork(const ExrShape& shape, int threads) {
  constexpr std::uint64_t kMostBytes = 32u << 20;
  constexpr std::int64_t kLeastRows = 32, kRowsOfThread = 64;
  const auto row_bytes = static_cast<std::uint64_t>(shape.width) * colorBytes(shape);
  const auto most = static_cast<std::int64_t>(kMostBytes / std::max<std::uint64_t>(row_bytes, 1));
  const std::int64_t rows =
      std::min(std::max(kLeastRows, most / kLeastRows * kLeastRows), kRowsOfThread * std::max(threads, 1));
  return {threads, static_cast<int>(std::min(rows, std::max<std::int64_t>(shape.height, 1)))};
}

std::uint64_t exrBytes(const ExrShape& shape, const ExrWork& work) {
  const Cost& cost = costOf(shape.compression);
  const auto width = static_cast<std::uint64_t>(shape.width);
  const std::int64_t blocks = (shape.height + cost.rows - 1) / cost.rows;
  const std::int64_t buffers = std::clamp<std::int64_t>(blocks, 1, std::max(1, 2 * work.threads));
  const double block_bytes = static_cast<double>(width * (colorBytes(shape) + shape.plane_bytes)) *
                             std::min<double>(cost.rows, static_cast<double>(shape.height));
  return static_cast<std::uint64_t>(static_cast<double>(buffers) * block_bytes *
                                    (shape.exr_float ? cost.full : cost.half)) +
         static_cast<std::uint64_t>(std::max(1, work.threads)) * cost.thread_bytes +
         static_cast<std::uint64_t>(work.rows) * width * colorBytes(shape);
}

ExrWork exrWorkWithin(const ExrShape& shape, std::uint64_t memory_bytes) {
  for (int threads = std::min(static_cast<int>(ThreadLimit::active()), kMostExrThreads); threads > 1; --threads) {
    const ExrWork work = exrWork(shape, threads);
    if (exrBytes(shape, work) <= memory_bytes) return work;
  }
  return exrWork(shape, 0);
}

}  // namespace kiln
