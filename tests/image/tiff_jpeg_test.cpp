// TIFF and JPEG files. Known: the pixels and texts that were written, within 16 bits or the loss of quality 100.
// Shortened files are damaged, and a full disk leaves no file.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "base/error.h"
#include "base/file/file.h"
#include "image/file/image_file.h"
#include "image/file/jpeg_file.h"
#include "image/file/text_block.h"
#include "image/srgb.h"
#include "support/files/picture_files.h"
#include "support/system/expect_error.h"
#include "support/system/faulty_file_system.h"
#include "support/system/text_of.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Smooth colours, premultiplied; opaque without `alpha`.
Image smooth(int width, int height, bool alpha) {
  Image out(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(width),
                  v = static_cast<float>(y) / static_cast<float>(height);
      const float opacity = alpha ? 0.25f + 0.75f * u : 1.0f;
      const float rgba[] = {opacity * u, opacity * v, opacity * (1 - u), opacity};
      std::copy_n(rgba, 4, out.pixel(x, y));
    }
  }
  return out;
}

double worstShown(const Image& a, const Image& b) {
  double out = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i)
    out = std::max(out, std::abs(srgbFromLinear(a.rgba[i]) - srgbFromLinear(b.rgba[i])));
  return out;
}

class TiffAndJpeg : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    directory_ = freshDirectory(fmt::format("tiff_jpeg_{}", std::string(GetParam()).substr(2)));
    metadata_.text = {{"kiln:job", std::string(150000, 'j') + "\n=1:ü"}, {"comments", "two\nlines"}, {"empty", ""}};
  }
  fs::path file() const { return directory_ / GetParam(); }
  bool tiff() const { return fs::path(GetParam()).extension() == ".tif"; }

  fs::path directory_;
  ImageMetadata metadata_;
  const ImageFileOptions options_{.jpeg_quality = 100};
};

INSTANTIATE_TEST_SUITE_P(Formats, TiffAndJpeg, ::testing::Values("a.tif", "a.jpg"));

TEST_P(TiffAndJpeg, PixelsAndTexts_areReadBack) {
  for (const auto& [width, height] : {std::pair{1, 1}, std::pair{67, 45}, std::pair{130, 16}}) {
    const Image image = smooth(width, height, tiff());
    writeImage(image, metadata_, options_, file());
    const Image again = readImage(file());
    ASSERT_EQ(again.width, width);
    ASSERT_EQ(again.height, height);
    EXPECT_LT(worstShown(image, again), tiff() ? 1e-3 : 0.03);
    EXPECT_EQ(readImageText(file()), metadata_.text);
    checkImage(file());
    const std::vector<std::byte> bytes = readFile(file());
    writeImage(image, metadata_, options_, file());
    EXPECT_EQ(readFile(file()), bytes);
  }
}

TEST_P(TiffAndJpeg, AlphaAndLightBeyondOne_areBounded) {
  Image image = smooth(8, 8, true);
  image.pixel(0, 0)[0] = 7, image.pixel(1, 0)[0] = -3, image.pixel(2, 0)[0] = NAN, image.pixel(3, 0)[3] = 2;
  writeImage(image, {}, options_, file());
  const Image again = readImage(file());
  for (const float value : again.rgba) EXPECT_TRUE(value >= 0 && value <= 1) << value;
  EXPECT_TRUE(readImageText(file()).empty());
}

TEST_P(TiffAndJpeg, ShortenedFiles_areDamaged) {
  writeImage(smooth(67, 45, false), {}, options_, file());
  const std::vector<std::byte> bytes = readFile(file());
  for (std::size_t length = 3; length < bytes.size(); length += 1 + bytes.size() / 97) {
    writeText(file(), textOf(std::span(bytes).first(length)));
    EXPECT_THROW(checkImage(file()), Error) << length;
  }
}

TEST_P(TiffAndJpeg, ReadingTakesTheGivenMemory) {
  writeImage(smooth(200, 100, false), {}, options_, file());
  expectError([&] { readImage(file(), {}, fs::file_size(file()) + 200 * 100 * 16 - 1); }, ErrorCode::kBudget,
              "--memory");
  EXPECT_EQ(readImage(file(), {}, fs::file_size(file()) + 200 * 100 * 16).width, 200);
}

// 64 blocks of luminance and 16 of each colour difference, of 64 coefficients of two bytes.
TEST(JpegPictures, ProgressiveFile_countsItsCoefficients) {
  const fs::path file = freshDirectory("progressive_jpeg") / "a.jpg";
  constexpr std::uint64_t kPixels = 64 * 64 * 16, kCoefficients = (64 + 2 * 16) * 128;
  for (const bool progressive : {false, true}) {
    writeText(file, jpegFile(64, 64, 3, std::string(64 * 64 * 3, 'f'), progressive));
    const std::uint64_t coefficients = progressive ? kCoefficients : 0, bytes = fs::file_size(file);
    EXPECT_EQ(readImage(file, {}, bytes + kPixels + coefficients).width, 64);
    expectError([&] { readImage(file, {}, bytes + kPixels + coefficients - 1); }, ErrorCode::kBudget, "--memory");
    checkImage(file, bytes + coefficients);
  }
  expectError([&] { checkImage(file, fs::file_size(file) + kCoefficients - 1); }, ErrorCode::kBudget, "--memory");
}

TEST_P(TiffAndJpeg, AFullDisk_leavesNoFile) {
  std::uint64_t calls = 0;
  {
    FaultyFileSystem counting;
    writeImage(smooth(67, 45, false), metadata_, {.disk = &counting}, file());
    calls = counting.calls();
    fs::remove(file());
  }
  ASSERT_GT(calls, 0u);
  for (std::uint64_t n = 0; n < calls; ++n) {
    FaultyFileSystem disk({.after_calls = n});
    expectError([&] { writeImage(smooth(67, 45, false), metadata_, {.disk = &disk}, file()); }, ErrorCode::kNoSpace,
                GetParam());
    EXPECT_TRUE(fs::is_empty(directory_)) << n;
  }
}

TEST(TiffPictures, OtherTiffs_areRefused) {
  const fs::path file = freshDirectory("other_tiff") / "a.tif";
  // A grey picture of one pixel of 8 bits.
  const unsigned char bytes[] = {'I', 'I', 42, 0, 8,  0, 0, 0, 4, 0, 0, 1, 3, 0, 1, 0, 0, 0, 1, 0, 0,
                                 0,   1,   1,  3, 0,  1, 0, 0, 0, 1, 0, 0, 0, 6, 1, 3, 0, 1, 0, 0, 0,
                                 1,   0,   0,  0, 17, 1, 4, 0, 1, 0, 0, 0, 8, 0, 0, 0, 0, 0, 0, 0};
  writeText(file, textOf(std::as_bytes(std::span(bytes))));
  expectError([&] { readImage(file); }, ErrorCode::kUnsupported, "of another program");
}

// Read as straight alpha, premultiplied colours would darken.
TEST(TiffPictures, PremultipliedAlpha_isRefused) {
  const fs::path file = freshDirectory("premultiplied_tiff") / "a.tif";
  writeImage(smooth(20, 10, true), {}, {}, file);
  // The entry of the tag 338, ExtraSamples: one number of 16 bits, 2 for straight and 1 for premultiplied alpha.
  std::string bytes = readTextFile(file);
  const std::size_t entry = bytes.find(std::string("\x52\x01\x03\0\x01\0\0\0\x02\0", 10));
  ASSERT_NE(entry, std::string::npos);
  bytes[entry + 8] = 1;
  writeText(file, bytes);
  expectError([&] { readImage(file); }, ErrorCode::kUnsupported, "of another program");
}

TEST(TextBlocks, Blocks_keepTextsAndRefuseOtherBytes) {
  const std::map<std::string, std::string> text = {{"a", "1:\n="}, {"b", ""}};
  EXPECT_EQ(textsOfBlock(textBlock(text)), text);
  EXPECT_EQ(textBlock(text), "a=4:1:\n=\nb=0:\n");
  for (const char* const wrong : {"a", "a=1:", "a=9:b\n", "a=1:bc", "a=x:b\n", "ImageJ=1.53\n"})
    EXPECT_FALSE(textsOfBlock(wrong)) << wrong;
}

// Rows that end in an error, as those of a preview that a newer one replaces.
class RowsUntilError : public ImageRows {
 public:
  RowsUntilError(const Image& image, int error_row)
      : ImageRows(image.width, image.height), image_(image), error_row_(error_row) {}
  Band bandAt(int row) override {
    if (row >= error_row_) throw Error(ErrorCode::kCancelled, "stopped");
    return {&image_, 0};
  }

 private:
  const Image& image_;
  const int error_row_;
};

TEST(JpegFile, AnErrorOfTheRowsAnywhere_isPassedOn) {
  const Image image = smooth(640, 256, false);
  for (const int row : {0, 16, 64, 240}) {
    RowsUntilError rows(image, row);
    expectError([&] { encodeJpeg(rows, 100); }, ErrorCode::kCancelled, "stopped");
  }
}

}  // namespace
}  // namespace kiln::test
