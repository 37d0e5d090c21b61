// The layers of a partial image's edges in its EXR. Known: what was written comes back, a program that knows of no
// parts reads the flat picture, and damage is an error or another picture.
#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.h"
#include "output/exr_file.h"
#include "support/random_scene.h"

namespace kiln::test {
namespace {

constexpr int kWidth = 21, kHeight = 17;

// Pixels with none, one and many layers.
Image partialImage() {
  Image out(kWidth, kHeight);
  Random random(7);
  for (float& v : out.rgba) v = static_cast<float>(random.uniform(0, 1));
  out.planes = {{"coverage", ZeroPages<float>(static_cast<std::size_t>(kWidth * kHeight), 0.5f)}};
  // As a crop has them, counted in the whole picture.
  out.edges = std::make_shared<EdgeLayers>(PixelRect{100, 60, 100 + kWidth, 60 + kHeight});
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int i = (x * y) % 7; i > 0; --i) {
        const auto unit = [&] { return static_cast<float>(random.uniform(0, 1)); };
        out.edges->put(100 + x, 60 + y, {unit(), {unit(), unit(), unit(), unit()}});
      }
    }
  }
  return out;
}

std::vector<std::byte> encoded(const Image& image) {
  ImageMetadata metadata;
  metadata.whole = {100, 60, 300, 200};
  return encodeExr(image, metadata, {true}, "a");
}

std::vector<EdgeLayer> layersAt(const EdgeLayers& edges, int x, int y) {
  std::vector<EdgeLayer> out;
  edges.forEach(x, y, [&](const EdgeLayer& layer) { out.push_back(layer); });
  return out;
}

TEST(ExrEdges, ComeBackAsTheyWere) {
  const Image image = partialImage();
  const std::vector<std::byte> data = encoded(image);
  EXPECT_EQ(data, encoded(image));
  const std::vector<std::string> planes = {"coverage"};
  const Image found = decodeExr(data, "a", planes, true);
  EXPECT_EQ(found.rgba, image.rgba);
  ASSERT_TRUE(found.edges);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const std::vector<EdgeLayer> layers = layersAt(*found.edges, x, y);
      const std::vector<EdgeLayer> expected = layersAt(*image.edges, 100 + x, 60 + y);
      ASSERT_EQ(layers.size(), expected.size());
      for (std::size_t i = 0; i < layers.size(); ++i) {
        EXPECT_EQ(layers[i].part, expected[i].part);
        EXPECT_EQ(layers[i].rgba, expected[i].rgba);
      }
    }
  }
  EXPECT_NO_THROW(checkExr(data, "a"));
  EXPECT_EQ(decodeExr(data, "a").rgba, image.rgba);
  EXPECT_FALSE(decodeExr(data, "a").edges);
  Image flat = image;
  flat.edges.reset();
  EXPECT_FALSE(decodeExr(encoded(flat), "a", planes, true).edges);
}

TEST(ExrEdges, DamageIsAnErrorOrAnotherPicture) {
  std::vector<std::byte> data = encoded(partialImage());
  for (std::size_t length = 0; length < data.size(); length += 97) {
    const std::span<const std::byte> part = std::span(data).first(length);
    EXPECT_THROW(decodeExr(part, "cut", {}, true), Error) << length;
    EXPECT_THROW(checkExr(part, "cut"), Error) << length;
  }
  Random random(8);
  int noticed = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const auto bit = static_cast<std::size_t>(random.between(0, static_cast<std::int64_t>(data.size()) * 8 - 1));
    data[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    try {
      decodeExr(data, "flipped", {}, true);
    } catch (const Error& error) {
      noticed += error.code() == ErrorCode::kFormat || error.code() == ErrorCode::kUnsupported ? 1 : 0;
    }
    data[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
  }
  EXPECT_GT(noticed, 40);
}

}  // namespace
}  // namespace kiln::test
