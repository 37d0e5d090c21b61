// Pictures on disk: OpenEXR (linear, premultiplied); PNG and TIFF (sRGB, straight alpha); JPEG (sRGB, opaque). A file
// is written whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "image/image.h"

namespace kiln {

class FileSystem;
class ImageRows;

/// Contents of a file beside the pixels; only an EXR holds more than the texts. shape: matrices for column vectors
/// (`scene/camera/camera.h`); the file holds their transposes, because OpenEXR multiplies row vectors.
struct ImageMetadata {
  /// Position of the first pixel in a larger picture, and the size of the larger picture: data window and display
  /// window of an EXR.
  struct Whole {
    int x = 0, y = 0, width = 0, height = 0;
  };
  std::optional<Whole> whole;
  std::optional<glm::dmat4> world_to_camera, world_to_ndc;
  int views_beside = 1;   // views of equal width, side by side in one picture
  bool panorama = false;  // covers all directions: the EXR attribute envmap
  /// String attributes of an EXR, texts of a PNG, by name: kJob, kComments, …
  std::map<std::string, std::string> text;
  /// Keys of the texts of --owner and --comments: OpenEXR's own.
  static constexpr const char* kOwner = "owner";
  static constexpr const char* kComments = "comments";
  /// Key of the job that draws the picture again.
  static constexpr const char* kJob = "kiln:job";
  /// Key of the folder from which relative names in the job count, as seen from the picture's folder, such as "..".
  static constexpr const char* kFolder = "kiln:folder";
  /// Key of the number of unreadable bricks, drawn as empty space; absent if zero. A composite of partial images holds
  /// an upper bound, because two parts may have met the same brick.
  static constexpr const char* kDamagedBricks = "kiln:damagedBricks";
};

struct ImageFileOptions {
  bool exr_float = false;  // else half
  int png_bits = 8;        // 8 or 16
  /// none, rle, zips, zip, piz or, lossy, dwaa or dwab.
  std::string exr_compression = "zip";
  /// Memory for compressing an EXR, beside the picture (image/file/exr_cost.h). More memory allows more threads. unit:
  /// bytes.
  std::uint64_t writer_bytes = UINT64_MAX;
  FileSystem* disk = nullptr;  // null: the operating system's
  int jpeg_quality = 92;       // 1 to 100

  /// Returns the options with the memory that a picture leaves of `memory_bytes` for the writer.
  ImageFileOptions within(std::uint64_t memory_bytes, const Image& picture) const;
};

/// Writes a file in the format of its extension, .exr, .png, .tif or .jpg; equal input gives equal bytes. cost: memory
/// of the compressed file for pictures up to 1 MiB; for larger pictures twice the file's size on disk.
void writeImage(const Image& image, const ImageMetadata& metadata, const ImageFileOptions& options,
                const std::filesystem::path& path);

/// Writes band by band; the bytes equal those of `writeImage` for the whole image. cost: memory of a band and some
/// rows; disk space of twice the compressed file. throws: also any exception of `rows`.
void writeImage(ImageRows& rows, const ImageMetadata& metadata, const ImageFileOptions& options,
                const std::filesystem::path& path);

/// Returns the bytes of the PNG that `writeImage` writes. cost: memory of the compressed file. throws: Error kIo; any
/// exception of `rows`.
std::vector<std::byte> encodedPng(ImageRows& rows, const ImageMetadata& metadata, int bits = 8);

/// One view of a scene, such as the picture for one eye.
struct ImageView {
  std::string name;
  const Image* image = nullptr;
  ImageMetadata metadata;
};

/// Writes an EXR with one part per view, each with the attribute `view`. A program without support for parts reads the
/// first view. requires: equal sizes. throws: as writeImage.
void writeImageViews(std::span<const ImageView> views, const ImageFileOptions& options,
                     const std::filesystem::path& path);

/// Writes a deep EXR: per sample R G B A, of the options' type, and Z and ZBack as 32-bit floats, from front to back.
/// Half floats are chosen so that the composite of a pixel differs from the exact composite by the rounding of one half
/// float. "zip" is written as "zips". throws: as writeImage; Error kUsage for a compression that deep files do not
/// have.
void writeDeepImage(const DeepSamples& samples, const ImageMetadata& metadata, const ImageFileOptions& options,
                    const std::filesystem::path& path);

/// True if `writeImage` writes an EXR to this path.
bool isExrPath(const std::filesystem::path& path);

/// True if the name is that of a picture whose job is read, .exr or .png. Other names of pictures may be volumes'.
bool isPictureName(const std::filesystem::path& path);

enum class PictureFormat { kExr, kPng, kTiff, kJpeg };
/// Returns the format that `writeImage` writes to this path; nothing for other extensions.
std::optional<PictureFormat> pictureFormatOf(const std::filesystem::path& path);

/// throws: Error kUsage if `writeImage` refuses the extension for a picture with or without planes. Call before long
/// work.
void requireImagePath(const std::filesystem::path& path, bool with_planes = false);
/// throws: Error kUsage if the format of the path has no pictures of this size. unit: pixels. Call before long work.
void requireSides(const std::filesystem::path& path, int width, int height);

/// No limit on memory for reading a picture.
inline constexpr std::uint64_t kUnlimitedBytes = UINT64_MAX;

/// Returns whether the file begins as an EXR or a PNG. throws: Error kNotFound, kIo.
bool isPicture(const std::filesystem::path& path);

/// Reads R, G, B, A (or Y) of an EXR's data window and the named planes, a PNG, a JPEG or Kiln's own TIFF, as linear
/// premultiplied values. The first bytes decide the format. Samples of a deep EXR are composited. `memory_bytes` bounds
/// the file, the picture and decoding buffers. throws: Error kFormat, kNotFound, kUnsupported; kBudget, naming the
/// sufficient memory, before the allocation.
Image readImage(const std::filesystem::path& path, std::span<const std::string> planes = {},
                std::uint64_t memory_bytes = kUnlimitedBytes);
/// Reads a file to its end and discards the pixels. throws: as readImage.
void checkImage(const std::filesystem::path& path, std::uint64_t memory_bytes = kUnlimitedBytes);
/// Returns the string attributes of an EXR, or the texts of another picture. cost: reads no pixels.
/// throws: as readImage.
std::map<std::string, std::string> readImageText(const std::filesystem::path& path,
                                                 std::uint64_t memory_bytes = kUnlimitedBytes);

/// Layout of the pixels in a file; of the first part if an EXR has several. unit of the window: pixels.
struct PixelLayout {
  std::int64_t x = 0, y = 0, width = 0, height = 0;           // the data window of an EXR
  int png_bits = 0;                                           // bits per channel of a PNG
  std::string compression;                                    // EXR only: OpenEXR's name
  std::vector<std::pair<std::string, std::string>> channels;  // EXR only: name and type (uint, half or float)
  bool deep = false;
};
/// cost: reads headers only. throws: as readImageText.
PixelLayout readPixelLayout(const std::filesystem::path& path);

}  // namespace kiln
