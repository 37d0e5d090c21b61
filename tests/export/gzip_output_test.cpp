// A gzip stream of many blocks. Known because zlib inflates the stream, and because the test made the bytes.
#include "export/output/gzip_output.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <random>

#include "base/thread/parallel.h"

namespace kiln::test {
namespace {

// Runs of equal bytes across the borders of blocks, so that blocks refer to the bytes before.
std::vector<std::byte> bytesOfRuns(std::size_t count) {
  std::mt19937 random(5);
  std::vector<std::byte> out;
  while (out.size() < count) out.insert(out.end(), 1 + random() % 700, static_cast<std::byte>(random() % 256));
  out.resize(count);
  return out;
}

std::vector<std::byte> gzippedBy(unsigned threads, const std::vector<std::byte>& data, std::size_t piece) {
  const ThreadLimit limit(threads);
  std::vector<std::byte> out;
  GzipOutput gzip([&](std::span<const std::byte> packed) { out.insert(out.end(), packed.begin(), packed.end()); });
  for (std::size_t at = 0; at < data.size(); at += piece)
    gzip.write(std::span(data).subspan(at, std::min(piece, data.size() - at)));
  gzip.finish();
  return out;
}

// Inflates a gzip stream of `bytes` bytes, and checks its checksum and its end.
std::vector<std::byte> inflated(std::vector<std::byte> packed, std::size_t bytes) {
  std::vector<std::byte> out(bytes + 1);
  z_stream stream{};
  constexpr int kGzip = 15 + 16;
  EXPECT_EQ(inflateInit2(&stream, kGzip), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  EXPECT_EQ(stream.avail_in, 0u);
  out.resize(out.size() - stream.avail_out);
  inflateEnd(&stream);
  return out;
}

TEST(GzipOutput, BytesDoNotDependOnThreadsOrPieces) {
  constexpr std::size_t kLength = (5 << 20) + 12345;
  const std::vector<std::byte> data = bytesOfRuns(kLength);
  const std::vector<std::byte> expected = gzippedBy(1, data, data.size());
  EXPECT_TRUE(inflated(expected, data.size()) == data);
  EXPECT_LT(expected.size(), data.size() / 20);
  for (const unsigned threads : {1u, 2u, 3u})
    for (const std::size_t piece : {std::size_t{100'000}, std::size_t{512 << 10}, kLength})
      EXPECT_TRUE(gzippedBy(threads, data, piece) == expected) << threads << " threads, pieces of " << piece;
}

}  // namespace
}  // namespace kiln::test
