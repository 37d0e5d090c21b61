// Known answers: half has 11 significant bits, so a value k/1024 in [0, 2] is exact, and other values have a relative
// error of at most 2^-11. PNG pixels are computed by hand from the sRGB curve (0.5 light is
// 187.5, or 48192 of 65535).
#include "image/file/image_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "base/memory/memory.h"
#include "image/dither.h"
#include "image/file/exr_file.h"
#include "image/file/png_file.h"
#include "image/srgb.h"
#include "job/job_names.h"
#include "support/reference/drawing.h"
#include "support/system/sanitized.h"

namespace kiln {
namespace {
namespace fs = std::filesystem;

class ImageFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / ("kiln_image_file_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

// Values premultiplied by alpha; some are not representable in half.
Image somePicture(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float alpha = static_cast<float>((x + y) % 5) / 4;
      const float rgba[4] = {alpha * static_cast<float>(x) / static_cast<float>(width), alpha * 0.3f,
                             alpha * static_cast<float>(y) / static_cast<float>(height), alpha};
      std::copy(rgba, rgba + 4, image.pixel(x, y));
    }
  }
  return image;
}

ImageMetadata withText() {
  ImageMetadata metadata;
  metadata.text = {{"kiln:job", "{}"}};
  return metadata;
}

std::string errorOf(const std::function<void()>& act, ErrorCode code) {
  try {
    act();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return "";
}

TEST_F(ImageFile, ExrFloatKeepsEveryBit) {
  const Image image = somePicture(37, 53);  // more rows than three ZIP blocks of 16
  writeImage(image, {}, {.exr_float = true}, folder_ / "a.exr");
  const Image back = readImage(folder_ / "a.exr");
  EXPECT_EQ(back.width, 37);
  EXPECT_EQ(back.height, 53);
  EXPECT_EQ(back.rgba, image.rgba);
}

TEST_F(ImageFile, ExrHalfRoundsToElevenBits) {
  Image image = somePicture(37, 53);
  image.pixel(3, 3)[0] = 1023.0f / 1024;
  image.pixel(4, 3)[0] = 1e9f;  // beyond half: stored as the largest half, not infinity
  writeImage(image, {}, {}, folder_ / "a.exr");
  const Image back = readImage(folder_ / "a.exr");
  EXPECT_EQ(back.pixel(3, 3)[0], 1023.0f / 1024);
  EXPECT_EQ(back.pixel(4, 3)[0], 65504.0f);
  image.pixel(4, 3)[0] = back.pixel(4, 3)[0];
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    EXPECT_LE(std::abs(back.rgba[i] - image.rgba[i]), std::abs(image.rgba[i]) / 2048 + 1e-7f);
  }
}

TEST_F(ImageFile, ExrHoldsTextAndIsTheSameEveryTime) {
  ImageMetadata metadata;
  metadata.text = {{"kiln:job", "{\n \"kiln\": 1\n}"},
                   {"comments", "two words"},
                   {"kiln:a name that is longer than thirty-one bytes", "x"}};
  metadata.world_to_camera = glm::dmat4(1.0);
  const Image image = somePicture(8, 8);
  writeImage(image, metadata, {}, folder_ / "a.exr");
  writeImage(image, metadata, {}, folder_ / "b.EXR");
  EXPECT_EQ(readImageText(folder_ / "a.exr"), metadata.text);
  EXPECT_EQ(readFile(folder_ / "a.exr"), readFile(folder_ / "b.EXR"));
  metadata.text["long"] = std::string(5000, 'x') + " ä";  // compressed in a PNG, and not Latin-1
  writeImage(image, metadata, {}, folder_ / "a.png");
  EXPECT_EQ(readImageText(folder_ / "a.png"), metadata.text);
}

// A file of only planes has no colours, and is still checked to its last row.
TEST_F(ImageFile, FilesAreCheckedToTheirEnd) {
  Image image = somePicture(40, 40);
  writeImage(image, {}, {}, folder_ / "a.png");
  image.rgba.clear();
  image.planes = {{"Z", ZeroPages<float>(1600, 3)}};
  for (std::size_t i = 0; i < 1600; ++i) image.planes[0].values[i] = std::sqrt(static_cast<float>(i));
  writeImage(image, {}, {}, folder_ / "a.exr");
  EXPECT_THROW(readImage(folder_ / "a.exr"), Error);
  for (const char* name : {"a.png", "a.exr"}) {
    EXPECT_NO_THROW(checkImage(folder_ / name));
    std::vector<std::byte> data = readFile(folder_ / name);
    data[data.size() - 100] ^= std::byte{1};
    FileSystem::real().writeAtomic(folder_ / name, data);
    errorOf([&] { checkImage(folder_ / name); }, ErrorCode::kFormat);
    std::filesystem::resize_file(folder_ / name, data.size() / 2);
    errorOf([&] { checkImage(folder_ / name); }, ErrorCode::kFormat);
  }
}

// A channel of every second pixel has half as many columns, from half the window's first column on.
TEST_F(ImageFile, SubsampledChannelsOfAFarWindow_areChecked) {
  constexpr int kWidth = 32, kHeight = 4;
  for (const int first : {0, 40'000'000, -40'000'000}) {
    const fs::path path = folder_ / "a.exr";
    {
      Imf::Header header(kWidth, kHeight);
      header.dataWindow() = {{first, first}, {first + kWidth - 1, first + kHeight - 1}};
      header.channels().insert("BY", Imf::Channel(Imf::FLOAT, 2, 2));
      std::array<float, kWidth> row{};
      Imf::FrameBuffer buffer;
      buffer.insert("BY",
                    Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(row.data() - first / 2), sizeof(float), 0, 2, 2));
      Imf::OutputFile file(path.c_str(), header);
      file.setFrameBuffer(buffer);
      file.writePixels(kHeight);
    }
    EXPECT_NO_THROW(checkImage(path)) << first;
  }
}

// Windows are stored as the first and the last pixel's x and y, after the name, the type's name and a length.
TEST_F(ImageFile, ExrOfAPartSaysWhereInTheWholeItIs) {
  const Image part = somePicture(5, 4);
  ImageMetadata metadata;
  metadata.whole = {7, 3, 20, 10};
  const std::vector<std::byte> file = encodeExr(part, metadata, {true}, "a.exr");
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  const auto window = [&](std::string_view name) {
    std::array<std::int32_t, 4> out{};
    const std::size_t place = text.find(name);
    EXPECT_NE(place, std::string_view::npos) << name;
    std::memcpy(out.data(), text.data() + place + name.size() + 4, sizeof out);
    return out;
  };
  EXPECT_EQ(window(std::string_view("dataWindow\0box2i\0", 17)), (std::array<std::int32_t, 4>{7, 3, 11, 6}));
  EXPECT_EQ(window(std::string_view("displayWindow\0box2i\0", 20)), (std::array<std::int32_t, 4>{0, 0, 19, 9}));
  EXPECT_EQ(decodeExr(file, "a.exr").rgba, part.rgba);
}

// Read by OpenEXR itself. Planes are floats for every type of the colours, without rounding.
TEST_F(ImageFile, ExrHoldsPlanesAsFloats) {
  Image image = somePicture(5, 4);
  image.planes = {{"Z", ZeroPages<float>(20, 1000.1f)}, {"N.X", ZeroPages<float>(20)}};
  image.planes[0].values[7] = std::numeric_limits<float>::infinity();
  std::iota(image.planes[1].values.begin(), image.planes[1].values.end(), 1 / 3.0f);
  ImageMetadata metadata;
  metadata.whole = {7, 3, 20, 10};
  writeImage(image, metadata, {}, folder_ / "a.exr");
  Imf::InputFile file((folder_ / "a.exr").c_str());
  EXPECT_EQ(file.header().channels()["R"].type, Imf::HALF);
  Imf::FrameBuffer buffer;
  std::vector<ZeroPages<float>> back(2, ZeroPages<float>(20));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(file.header().channels()[image.planes[i].name].type, Imf::FLOAT);
    buffer.insert(image.planes[i].name,
                  Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(back[i].data() - 3 * 5 - 7), 4, 20));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(3, 6);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(back[i], image.planes[i].values);
  Image colors = image;
  colors.planes.clear();
  writeImage(colors, metadata, {}, folder_ / "b.exr");
  EXPECT_EQ(readImage(folder_ / "a.exr").rgba, readImage(folder_ / "b.exr").rgba);
  EXPECT_NE(errorOf([&] { writeImage(image, {}, {}, folder_ / "a.png"); }, ErrorCode::kUsage).find("--aov"),
            std::string::npos);
}

// Smaller than uncompressed, except for incompressible data; the first five are lossless.
TEST_F(ImageFile, ExrIsCompressedAsAskedFor) {
  Image image(64, 64);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = static_cast<float>(i % 256 / 4) / 64;
  image.planes = {{"value", ZeroPages<float>(64 * 64, std::numeric_limits<float>::quiet_NaN())}};
  const std::size_t plain = encodeExr(image, {}, {true, 8, "none"}, "a.exr").size();
  for (const std::string_view name : kExrCompressionNames) {
    const std::vector<std::byte> file = encodeExr(image, {}, {true, 8, std::string(name)}, "a.exr");
    EXPECT_LE(file.size(), plain) << name;
    const Image back = decodeExr(file, "a.exr");
    const bool exact = !name.starts_with("dwa");
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
      ASSERT_NEAR(back.rgba[i], image.rgba[i], exact ? 0 : 0.02) << name << " " << i;
  }
  EXPECT_THROW(encodeExr(image, {}, {true, 8, "lzw"}, "a.exr"), Error);
}

// OpenEXR multiplies row vectors: the translation is in the last row, the last four of 16 floats in the file.
TEST_F(ImageFile, ExrMatricesAreForRowVectors) {
  ImageMetadata metadata;
  glm::dmat4 translation(1.0);
  translation[3] = {5, 6, 7, 1};
  metadata.world_to_camera = translation;
  metadata.world_to_ndc = glm::dmat4(1.0);
  const std::vector<std::byte> file = encodeExr(somePicture(2, 2), metadata, {}, "a.exr");
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  EXPECT_NE(text.find(std::string_view("worldToNDC\0m44f", 15)), std::string_view::npos);
  const std::string_view name("worldToCamera\0m44f\0", 19);
  const std::size_t place = text.find(name);
  ASSERT_NE(place, std::string_view::npos);
  float values[16];
  std::memcpy(values, text.data() + place + name.size() + 4, sizeof values);
  const float expected[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1};
  EXPECT_EQ(std::memcmp(values, expected, sizeof values), 0);
}

// Premultiplied 0.25 at alpha 0.5 is straight 0.5 light: sRGB 188 of 255; alpha is not encoded: 128.
TEST_F(ImageFile, PngOfEightBitsIsStraightSrgb) {
  Image image(4, 1);
  const float pixels[16] = {0.25f, 0, 0.5f, 0.5f, 0, 0, 0, 0, 1, 2, -1, 1, std::nanf(""), 0, 0, 1};
  std::copy(pixels, pixels + 16, image.rgba.begin());
  writeImage(image, {}, {}, folder_ / "a.png");
  const Image back = readImage(folder_ / "a.png");
  const auto light = [](double srgb) { return std::pow((srgb / 255 + 0.055) / 1.055, 2.4); };
  // The first threshold of the pattern is the smallest, which takes the lower byte.
  EXPECT_NEAR(back.pixel(0, 0)[0], light(187) * 128 / 255, 1e-6);
  EXPECT_EQ(back.pixel(0, 0)[1], 0);
  EXPECT_NEAR(back.pixel(0, 0)[2], 128 / 255.0, 1e-6);
  EXPECT_NEAR(back.pixel(0, 0)[3], 128 / 255.0, 1e-6);
  for (int c = 0; c < 4; ++c) EXPECT_EQ(back.pixel(1, 0)[c], 0);
  EXPECT_EQ(back.pixel(2, 0)[0], 1);
  EXPECT_EQ(back.pixel(2, 0)[1], 1);  // clamped
  EXPECT_EQ(back.pixel(2, 0)[2], 0);
  EXPECT_EQ(back.pixel(3, 0)[0], 0);
}

TEST_F(ImageFile, PngOfSixteenBitsIsWithinItsSteps) {
  const Image image = somePicture(31, 17);
  writeImage(image, {}, {.png_bits = 16}, folder_ / "a.png");
  const Image back = readImage(folder_ / "a.png");
  ASSERT_EQ(back.rgba.size(), image.rgba.size());
  for (std::size_t i = 0; i < image.rgba.size(); ++i) EXPECT_NEAR(back.rgba[i], image.rgba[i], 3e-5);
  Image half(1, 1);
  half.rgba = {0.5f, 0.5f, 0.5f, 1};
  writeImage(half, {}, {.png_bits = 16}, folder_ / "b.png");
  const double encoded = std::round(65535 * (1.055 * std::pow(0.5, 1 / 2.4) - 0.055)) / 65535;
  EXPECT_NEAR(readImage(folder_ / "b.png").rgba[0], std::pow((encoded + 0.055) / 1.055, 2.4), 1e-7);
}

TEST_F(ImageFile, PngIsTaggedSrgbAndTheSameEveryTime) {
  const std::vector<std::byte> a = encodePng(somePicture(9, 9), 8, "a.png");
  EXPECT_EQ(a, encodePng(somePicture(9, 9), 8, "a.png"));
  const std::string_view text(reinterpret_cast<const char*>(a.data()), a.size());
  EXPECT_NE(text.find("sRGB"), std::string_view::npos);
  EXPECT_EQ(text.find("tIME"), std::string_view::npos);
}

// The mean of a block's bytes is the light's place between two bytes, and a ramp over a single byte has no band.
// Rounded, the same ramp has two bands and an error of half a byte.
TEST_F(ImageFile, PngOfEightBitsDithersSmoothGradients) {
  constexpr int kWidth = 256, kHeight = 64;
  const auto place = [](int x) { return 100 + (x + 0.5) / kWidth; };  // unit: bytes
  Image ramp(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto light = static_cast<float>(linearFromSrgb(place(x) / 255));
      std::copy_n(std::array<float, 4>{light, light, light, 1}.data(), 4, ramp.pixel(x, y));
    }
  }
  writeImage(ramp, {}, {}, folder_ / "ramp.png");
  const Image back = readImage(folder_ / "ramp.png");
  const auto byteAt = [&](int x, int y) { return 255 * srgbFromLinear(back.pixel(x, y)[0]); };
  double worst = 0;
  for (int y = 0; y < kHeight; y += kDitherEdge) {
    for (int x = 0; x < kWidth; x += kDitherEdge) {
      double found = 0, wanted = 0;
      for (int i = 0; i < kDitherEdge * kDitherEdge; ++i) {
        found += byteAt(x + i % kDitherEdge, y + i / kDitherEdge);
        wanted += place(x + i % kDitherEdge);
        EXPECT_EQ(back.pixel(x, y)[0], back.pixel(x, y)[1]) << "grey stays grey";
      }
      worst = std::max(worst, std::abs(found - wanted) / (kDitherEdge * kDitherEdge));
    }
  }
  RecordProperty("worst_block_error_in_bytes", std::to_string(worst));
  EXPECT_LT(worst, 1.0 / 32);
}

// Colours of whole bytes, black, white, light outside of 0 to 1, and alpha are what rounding gives.
TEST_F(ImageFile, DitheringLeavesWholeBytesFlat) {
  for (int byte = 0; byte < 256; ++byte) {
    const auto light = static_cast<float>(linearFromSrgb(byte / 255.0));
    for (const float alpha : {1.0f, 0.3f}) {
      Image flat(16, 16);
      for (int i = 0; i < 256; ++i)
        std::copy_n(std::array<float, 4>{light * alpha, 2 * alpha, -alpha, alpha}.data(), 4,
                    flat.pixel(i % 16, i / 16));
      const Image back = decodePng(encodePng(flat, 8, "flat"), "flat");
      const auto stored = static_cast<float>(std::round(255 * alpha)) / 255;
      for (int i = 0; i < 256; ++i) {
        const float* const pixel = back.pixel(i % 16, i / 16);
        ASSERT_NEAR(pixel[0], light * stored, 1e-6) << byte;
        ASSERT_EQ(pixel[1], pixel[3]);
        ASSERT_EQ(pixel[2], 0);
        ASSERT_EQ(pixel[3], stored);
      }
    }
  }
}

// A pixel has the same bytes in the whole picture, in a crop, in a band of rows and in each of two views side by side.
TEST_F(ImageFile, DitheringFollowsTheWholePicture) {
  const Image whole = somePicture(40, 30);
  const Image drawn = decodePng(encodePng(whole, 8, "whole"), "whole");
  const Image crop = decodePng(encodePng(test::partOf(whole, {13, 7, 30, 27}), 8, "crop", {}, {13, 7}), "crop");
  const Image band = decodePng(encodePng(test::partOf(whole, {0, 11, 40, 19}), 8, "band", {}, {0, 11}), "band");
  EXPECT_EQ(band.rgba, test::partOf(drawn, {0, 11, 40, 19}).rgba);
  Image beside(34, 20);
  for (int y = 0; y < 20; ++y) {
    std::copy_n(whole.pixel(13, 7 + y), 4 * 17, beside.pixel(0, y));
    std::copy_n(whole.pixel(13, 7 + y), 4 * 17, beside.pixel(17, y));
  }
  const Image pair = decodePng(encodePng(beside, 8, "pair", {}, {13, 7, 2}), "pair");
  for (int y = 0; y < 20; ++y) {
    for (int i = 0; i < 4 * 17; ++i) {
      ASSERT_EQ(crop.pixel(0, y)[i], drawn.pixel(13, 7 + y)[i]);
      ASSERT_EQ(pair.pixel(0, y)[i], crop.pixel(0, y)[i]);
      ASSERT_EQ(pair.pixel(17, y)[i], crop.pixel(0, y)[i]);
    }
  }
}

// A 2x1 grey picture of one bit made by hand: black, white. Zlib stream: stored block of filter 0 and bits 01.
TEST_F(ImageFile, PngOfOtherKindsIsRead) {
  static const unsigned char kGrey[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00, 0x00,
      0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0xdc, 0x59, 0x42, 0x27, 0x00, 0x00, 0x00,
      0x0d, 0x49, 0x44, 0x41, 0x54, 0x78, 0x01, 0x01, 0x02, 0x00, 0xfd, 0xff, 0x00, 0x40, 0x00, 0x42, 0x00, 0x41,
      0x20, 0xb0, 0x99, 0xcb, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  std::ofstream(folder_ / "grey.png", std::ios::binary).write(reinterpret_cast<const char*>(kGrey), sizeof kGrey);
  const Image image = readImage(folder_ / "grey.png");
  EXPECT_EQ(image.rgba, (ZeroPages<float>{0, 0, 0, 1, 1, 1, 1, 1}));
}

TEST_F(ImageFile, OtherNamesAreRefusedBeforeAnyWork) {
  for (const char* name : {"a.gif", "a", "exr", "a.exr.txt"}) {
    EXPECT_NE(errorOf([&] { requireImagePath(name); }, ErrorCode::kUsage).find(".exr, .png, .tif or .jpg"),
              std::string::npos);
  }
  requireImagePath("dir.x/a.EXR");
  requireImagePath("a.png");
  errorOf([&] { writeImage(somePicture(2, 2), {}, {}, folder_ / "a.gif"); }, ErrorCode::kUsage);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(ImageFile, ReadingNamesWhatIsWrong) {
  errorOf([&] { readImage(folder_ / "none.exr"); }, ErrorCode::kNotFound);
  std::ofstream(folder_ / "text.exr") << "not a picture at all";
  EXPECT_NE(errorOf([&] { readImage(folder_ / "text.exr"); }, ErrorCode::kFormat).find("text.exr"), std::string::npos);
  std::ofstream(folder_ / "empty.png");
  errorOf([&] { readImage(folder_ / "empty.png"); }, ErrorCode::kFormat);
  writeImage(somePicture(2, 2), {}, {}, folder_ / "a.png");
}

// Any truncation is detected, except at the very end of a PNG, whose last chunk is empty.
TEST_F(ImageFile, TruncationIsAnErrorAtEveryLength) {
  const Image image = somePicture(23, 40);
  for (const bool exr : {true, false}) {
    const std::vector<std::byte> whole = exr ? encodeExr(image, withText(), {}, "a") : encodePng(image, 8, "a");
    for (std::size_t length = 0; length < whole.size(); length += 7) {
      const std::vector<std::byte> part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
      errorOf([&] { exr ? decodeExr(part, "cut") : decodePng(part, "cut"); }, ErrorCode::kFormat);
    }
  }
}

// A flipped bit gives an error or another picture, never a crash and never a picture of gigabytes.
TEST_F(ImageFile, FlippedBitsAreSurvived) {
  const Image image = somePicture(23, 40);
  for (const bool exr : {true, false}) {
    std::vector<std::byte> data = exr ? encodeExr(image, withText(), {}, "a") : encodePng(image, 8, "a");
    for (std::size_t bit = 0; bit < std::min<std::size_t>(data.size(), 1200) * 8; bit += test::casesOf(5u, 21u)) {
      data[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
      try {
        const Image read = exr ? decodeExr(data, "flipped") : decodePng(data, "flipped");
        EXPECT_EQ(read.rgba.size(), static_cast<std::size_t>(read.width) * static_cast<std::size_t>(read.height) * 4);
      } catch (const Error&) {
      }
      data[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    }
  }
}

// Bytes in front of an EXR's or a PNG's pixels are set to numbers of some GiB: an error in one line, or a picture, in
// little memory. OpenEXR would clear as many bytes as a length claims, and libpng would unpack a text of this size.
TEST_F(ImageFile, HostileLengths_takeLittleMemory) {
  const std::uint64_t before = peakResidentBytes();
  const Image eye = somePicture(23, 40);
  const ImageView eyes[] = {{"left", &eye, withText()}, {"right", &eye, withText()}};
  writeImageViews(eyes, {}, folder_ / "eyes.exr");
  const std::vector<std::byte> files[] = {encodeExr(somePicture(23, 40), withText(), {}, "a"),
                                          readFile(folder_ / "eyes.exr"),
                                          encodePng(somePicture(23, 40), 8, "a", withText().text)};
  for (const std::vector<std::byte>& whole : files) {
    for (std::size_t at = 4; at + 4 < std::min<std::size_t>(whole.size(), 1400); at += test::casesOf(3u, 11u)) {
      std::vector<std::byte> data = whole;
      const std::uint32_t length = at % 2 == 0 ? 0x7ffffff0 : 0x00007fff;
      std::memcpy(&data[at], &length, sizeof length);
      FileSystem::real().writeAtomic(folder_ / "hostile", data);
      for (int how = 0; how < 3; ++how) {
        try {
          if (how == 0) readImage(folder_ / "hostile", {}, 256u << 20);
          if (how == 1) checkImage(folder_ / "hostile", 256u << 20);
          if (how == 2) readImageText(folder_ / "hostile", 256u << 20);
        } catch (const Error& error) {
          EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        }
      }
    }
  }
  if (!test::kSanitized) {
    EXPECT_LT(peakResidentBytes() - before, 320u << 20);
  }
}

// One bit a pixel, all equal: 33 million pixels in 36 KB, half a GiB as floats. The text unpacks to 7 MB.
TEST_F(ImageFile, SmallPngOfManyPixels_isHeldAgainstMemory) {
  const auto big = [](std::uint32_t v) {
    std::string out;
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(v >> shift & 255);
    return out;
  };
  const auto chunk = [&](const std::string& type, const std::string& data) {
    const std::string body = type + data;
    const auto crc = crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
    return big(static_cast<std::uint32_t>(data.size())) + body + big(static_cast<std::uint32_t>(crc));
  };
  const auto packed = [](const std::string& bytes) {
    std::string out(compressBound(bytes.size()), '\0');
    uLongf size = out.size();
    compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(),
              9);
    out.resize(size);
    return out;
  };
  constexpr std::uint32_t kSide = 5792;
  const std::string head =
      std::string("\x89PNG\r\n\x1a\n") + chunk("IHDR", big(kSide) + big(kSide) + std::string("\1\0\0\0\0", 5));
  const std::string text = chunk("zTXt", std::string("a\0\0", 3) + packed(std::string(7'000'000, ' ')));
  const std::string end =
      chunk("IDAT", packed(std::string((kSide / 8 + 1) * std::size_t{kSide}, '\0'))) + chunk("IEND", "");
  const auto write = [&](const std::string& bytes) {
    FileSystem::real().writeAtomic(folder_ / "a.png", std::string_view(bytes));
    return folder_ / "a.png";
  };
  const fs::path many = write(head + end);
  EXPECT_LT(fs::file_size(many), 40'000u);
  EXPECT_NE(errorOf([&] { readImage(many, {}, 64u << 20); }, ErrorCode::kBudget).find("give --memory"),
            std::string::npos);
  checkImage(many, 8u << 20);  // row by row
  std::string texts;
  for (int i = 0; i < 40; ++i) texts += text;
  const std::uint64_t before = peakResidentBytes();
  const fs::path bombs = write(head + texts + end);
  EXPECT_NE(errorOf([&] { readImageText(bombs, 16u << 20); }, ErrorCode::kBudget).find("40 of its 40 texts"),
            std::string::npos);
  if (!test::kSanitized) {
    EXPECT_LT(peakResidentBytes() - before, 64u << 20);
  }
  EXPECT_EQ(readImageText(write(head + text + end)).at("a").size(), 7'000'000u);
}

TEST_F(ImageFile, Reading_needsTheMemoryThatItSays) {
  writeImage(somePicture(640, 480), {}, {}, folder_ / "a.exr");
  writeImage(somePicture(640, 480), {}, {}, folder_ / "a.png");
  for (const char* name : {"a.exr", "a.png"}) {
    errorOf([&] { readImage(folder_ / name, {}, 640 * 480 * 16); }, ErrorCode::kBudget);
    EXPECT_EQ(readImage(folder_ / name, {}, 16u << 20).width, 640);
    errorOf([&] { readImage(folder_ / name, {}, 100); }, ErrorCode::kBudget);
  }
}

class FullDisk : public FileSystem {
 public:
  void writeFile(const fs::path& path, std::span<const std::byte> data, WritePolicy policy) override {
    FileSystem::writeFile(path, data.first(data.size() / 2), policy);
    throw Error(ErrorCode::kNoSpace, path, "", "full");
  }
};

TEST_F(ImageFile, AFailedWriteLeavesTheOldFile) {
  FullDisk disk;
  for (const char* name : {"a.exr", "a.png"}) {
    errorOf([&] { writeImage(somePicture(5, 5), {}, {.disk = &disk}, folder_ / name); }, ErrorCode::kNoSpace);
    EXPECT_TRUE(fs::is_empty(folder_));
  }
  writeImage(somePicture(5, 5), {}, {}, folder_ / "a.exr");
  const std::vector<std::byte> before = readFile(folder_ / "a.exr");
  errorOf([&] { writeImage(somePicture(6, 6), {}, {.disk = &disk}, folder_ / "a.exr"); }, ErrorCode::kNoSpace);
  EXPECT_EQ(readFile(folder_ / "a.exr"), before);
}

}  // namespace
}  // namespace kiln
