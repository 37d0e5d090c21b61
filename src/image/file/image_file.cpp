#include "image/file/image_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "base/error.h"
#include "base/file/chosen_disk.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "image/file/exr_deep.h"
#include "image/file/exr_file.h"
#include "image/file/jpeg_file.h"
#include "image/file/png_file.h"
#include "image/file/tiff_picture.h"
#include "image/image_memory.h"

namespace kiln {
namespace {

// Larger pictures are encoded into a scratch file: the encoded file may be as large as the picture. unit: bytes of
// pixels.
constexpr std::size_t kEncodedInMemory = std::size_t{1} << 20;

std::size_t pixelBytes(const Image& image) {
  return sizeof(float) * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
         (4 + image.planes.size());
}

}  // namespace

ImageFileOptions ImageFileOptions::within(std::uint64_t memory_bytes, const Image& picture) const {
  ImageFileOptions out = *this;
  out.writer_bytes = memory_bytes - std::min(memory_bytes, picture.bytes());
  return out;
}

std::optional<PictureFormat> pictureFormatOf(const std::filesystem::path& path) {
  const std::string ending = extensionOf(path);
  if (ending == ".exr") return PictureFormat::kExr;
  if (ending == ".png") return PictureFormat::kPng;
  if (ending == ".tif" || ending == ".tiff") return PictureFormat::kTiff;
  if (ending == ".jpg" || ending == ".jpeg") return PictureFormat::kJpeg;
  return std::nullopt;
}

bool isExrPath(const std::filesystem::path& path) { return pictureFormatOf(path) == PictureFormat::kExr; }

bool isPictureName(const std::filesystem::path& path) {
  return isExrPath(path) || pictureFormatOf(path) == PictureFormat::kPng;
}

void requireImagePath(const std::filesystem::path& path, bool with_planes) {
  if (!pictureFormatOf(path))
    throw Error(ErrorCode::kUsage, path, "", "is no picture's name; it must end in .exr, .png, .tif or .jpg");
  if (with_planes && !isExrPath(path))
    throw Error(ErrorCode::kUsage, path, "",
                "only an EXR holds more than colours; planes (--aov) need a name ending in .exr");
}

void requireSides(const std::filesystem::path& path, int width, int height) {
  if (pictureFormatOf(path) == PictureFormat::kJpeg && std::max(width, height) > kLargestJpegSide_px)
    throw Error(ErrorCode::kUsage, path, "",
                fmt::format("a JPEG has sides of at most {} pixels (found {} x {}); write a PNG or a TIFF",
                            kLargestJpegSide_px, width, height));
}

namespace {

PatternPlace patternPlaceOf(const ImageMetadata& metadata) {
  const ImageMetadata::Whole whole = metadata.whole.value_or(ImageMetadata::Whole());
  return {whole.x, whole.y, metadata.views_beside};
}

}  // namespace

void writeImage(const Image& image, const ImageMetadata& metadata, const ImageFileOptions& options,
                const std::filesystem::path& path) {
  assert(image.width > 0 && image.height > 0);
  assert(image.rgba.size() == static_cast<std::size_t>(image.width) * image.height * 4 || image.rgba.empty());
  assert(options.png_bits == 8 || options.png_bits == 16);
  requireImagePath(path, !image.planes.empty());
  const bool other = !isPictureName(path);  // TIFF and JPEG have one way
  if (other || pixelBytes(image) > kEncodedInMemory) {
    RowsOfImage rows(image);
    return writeImage(rows, metadata, options, path);
  }
  chosenDisk(options.disk)
      .writeAtomic(path, isExrPath(path)
                             ? encodeExr(image, metadata, options, path)
                             : encodePng(image, options.png_bits, path, metadata.text, patternPlaceOf(metadata)));
}

void writeImage(ImageRows& rows, const ImageMetadata& metadata, const ImageFileOptions& options,
                const std::filesystem::path& path) {
  requireImagePath(path, !rows.bandAt(0).image->planes.empty());
  const PictureFormat format = *pictureFormatOf(path);
  requireSides(path, rows.width, rows.height);
  if (format == PictureFormat::kJpeg)
    return chosenDisk(options.disk).writeAtomic(path, encodeJpeg(rows, options.jpeg_quality, metadata.text));
  ScratchOutput out(path, chosenDisk(options.disk));
  if (format == PictureFormat::kExr)
    encodeExr(rows, metadata, options, path, out);
  else if (format == PictureFormat::kTiff)
    encodeTiff(rows, path, metadata.text,
               [&](std::uint64_t offset, std::span<const std::byte> bytes) { out.write(offset, bytes); });
  else
    encodePng(rows, options.png_bits, path, metadata.text, patternPlaceOf(metadata),
              [&](std::span<const std::byte> bytes) { out.write(out.size(), bytes); });
  out.publish();
}

std::vector<std::byte> encodedPng(ImageRows& rows, const ImageMetadata& metadata, int bits) {
  std::vector<std::byte> out;
  encodePng(rows, bits, {}, metadata.text, patternPlaceOf(metadata),
            [&](std::span<const std::byte> bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); });
  return out;
}

void writeImageViews(std::span<const ImageView> views, const ImageFileOptions& options,
                     const std::filesystem::path& path) {
  ScratchOutput out(path, chosenDisk(options.disk));
  encodeExrViews(views, options, path, out);
  out.publish();
}

void writeDeepImage(const DeepSamples& samples, const ImageMetadata& metadata, const ImageFileOptions& options,
                    const std::filesystem::path& path) {
  ScratchOutput out(path, chosenDisk(options.disk));
  encodeDeepExr(samples, metadata, options, path, out);
  out.publish();
}

namespace {

Error notAPicture(const std::filesystem::path& path) {
  return Error(ErrorCode::kFormat, path, "byte 0",
               "the file is no picture that Kiln writes: OpenEXR, PNG, TIFF or JPEG");
}

// Returns enough bytes to recognize a picture.
std::vector<std::byte> firstBytes(const File& file) {
  std::vector<std::byte> out(8);
  out.resize(file.readSomeAt(0, out));
  return out;
}

// Reads the whole file. requires: `memory_bytes` also has room for the picture.
std::vector<std::byte> readWithin(const std::filesystem::path& path, std::uint64_t memory_bytes) {
  requireMemory(File(path).size(), memory_bytes, path);
  return readFile(path);
}

}  // namespace

void requireMemory(std::uint64_t needed, std::uint64_t allowed, const std::filesystem::path& path) {
  if (needed <= allowed) return;
  throw Error(ErrorCode::kBudget, path, "",
              fmt::format("reading it takes {} of memory, and {} are left; give --memory {} more", formatBytes(needed),
                          formatBytes(allowed), roundedUpBytes(needed - allowed)));
}

Image readImage(const std::filesystem::path& path, std::span<const std::string> planes, std::uint64_t memory_bytes) {
  const std::vector<std::byte> data = readWithin(path, memory_bytes);
  const std::uint64_t left = memory_bytes - data.size();
  if (looksLikeExr(data)) return decodeExr(data, path, planes, left);
  if (!planes.empty())
    throw Error(ErrorCode::kUnsupported, path, "channel " + planes[0], "is available in an EXR only");
  if (looksLikePng(data)) return decodePng(data, path, left);
  if (looksLikeTiff(data)) return decodeTiff(data, path, left);
  if (looksLikeJpeg(data)) return decodeJpeg(data, path, left);
  throw notAPicture(path);
}

bool isPicture(const std::filesystem::path& path) {
  const std::vector<std::byte> first = firstBytes(File(path));
  return looksLikeExr(first) || looksLikePng(first);
}

void checkImage(const std::filesystem::path& path, std::uint64_t memory_bytes) {
  const std::vector<std::byte> data = readWithin(path, memory_bytes);
  const std::uint64_t left = memory_bytes - data.size();
  if (looksLikeExr(data)) return checkExr(data, path, left);
  if (looksLikePng(data)) return checkPng(data, path, left);
  if (looksLikeTiff(data)) return checkTiff(data, path);
  if (looksLikeJpeg(data)) return checkJpeg(data, path, left);
  throw notAPicture(path);
}

std::map<std::string, std::string> readImageText(const std::filesystem::path& path, std::uint64_t memory_bytes) {
  const File file(path);
  const std::vector<std::byte> first = firstBytes(file);
  if (looksLikeExr(first)) return readExrPart(file).text;
  if (looksLikePng(first)) return decodePngText(readWithin(path, memory_bytes), path, memory_bytes - file.size());
  if (looksLikeTiff(first)) return decodeTiffText(readWithin(path, memory_bytes), path);
  if (looksLikeJpeg(first)) return decodeJpegText(readWithin(path, memory_bytes), path);
  throw notAPicture(path);
}

PixelLayout readPixelLayout(const std::filesystem::path& path) {
  const File file(path);
  // Width, height and bit depth of a PNG lie in its first 25 bytes.
  std::vector<std::byte> first(25);
  first.resize(file.readSomeAt(0, first));
  PixelLayout out;
  if (looksLikeExr(first)) {
    ExrPart part = readExrPart(file);
    out.x = part.x, out.y = part.y, out.width = part.width, out.height = part.height;
    out.deep = part.deep;
    out.compression = std::move(part.compression);
    out.channels = std::move(part.channels);
    return out;
  }
  if (!looksLikePng(first) || first.size() < 25) throw notAPicture(path);
  const auto number = [&](std::size_t at) {
    std::int64_t value = 0;
    for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | std::to_integer<std::int64_t>(first[i]);
    return value;
  };
  out.width = number(16), out.height = number(20);
  out.png_bits = std::to_integer<int>(first[24]);
  return out;
}

}  // namespace kiln
