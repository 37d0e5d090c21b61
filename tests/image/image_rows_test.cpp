// A picture written band by band has the bytes of the picture written whole.
#include "image/image_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "base/file/file.h"
#include "image/file/image_file.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// Copies a picture band by band, each of `rows` rows and valid until the next.
class Bands : public ImageRows {
 public:
  Bands(const Image& whole, int rows) : ImageRows(whole.width, whole.height), whole_(whole), rows_(rows) {}
  Band bandAt(int row) override {
    const int first = row / rows_ * rows_, count = std::min(rows_, height - first);
    band_ = Image(width, count);
    std::copy_n(whole_.pixel(0, first), 4 * width * count, band_.pixel(0, 0));
    for (const Plane& plane : whole_.planes) {
      Plane& part = band_.planes.emplace_back(Plane{plane.name, ZeroPages<float>(band_.rgba.size() / 4)});
      std::copy_n(plane.values.data() + std::ptrdiff_t{first} * width, width * count, part.values.data());
    }
    return {&band_, first};
  }

 private:
  const Image& whole_;
  const int rows_;
  Image band_;
};

TEST(ImageRows, BandsOfAnyHeight_giveTheBytesOfTheWholePicture) {
  const auto directory = freshDirectory("image_rows");
  std::mt19937 random(7);
  Image image(70, 301);
  for (float& value : image.rgba) value = static_cast<float>(random() % 1000) / 1000;
  ImageMetadata metadata;
  metadata.text["comments"] = "bands";
  metadata.whole = ImageMetadata::Whole{5, 9, 100, 400};
  for (const std::string name : {"a.png", "d.tif", "e.jpg", "b.exr", "c.exr"}) {
    // Planes are of EXR files only.
    if (name == "b.exr") image.planes.push_back({"Z", ZeroPages<float>(image.rgba.size() / 4, 3.5F)});
    for (const char* const compression : {"zip", "piz", "none"}) {
      const ImageFileOptions options{name == "c.exr", 16, compression};
      writeImage(image, metadata, options, directory / ("whole_" + name));
      for (const int rows : {1, 50, 64, 512}) {
        Bands bands(image, rows);
        writeImage(bands, metadata, options, directory / name);
        EXPECT_EQ(readFile(directory / name), readFile(directory / ("whole_" + name)))
            << name << ", " << compression << ", bands of " << rows;
      }
    }
  }
  // No temporary file remains.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(directory), {}), 10);
}

}  // namespace
}  // namespace kiln::test
