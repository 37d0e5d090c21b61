// Pictures on disk: OpenEXR (linear, premultiplied) and PNG (sRGB, straight alpha as PNG defines it). Written whole or
// not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/mat4x4.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/file.h"
#include "image/image.h"
#include "image/image_rows.h"

namespace kiln {

/// What a file says beside the pixels; a PNG has the texts only. shape: matrices for column vectors
/// (`scene/camera/camera.h`); the file holds their transposes, as OpenEXR multiplies row vectors.
struct ImageMetadata {
  /// Where the picture's first pixel is in a larger one, and that one's size: an EXR's data window and display window.
  struct Whole {
    int x = 0, y = 0, width = 0, height = 0;
  };
  std::optional<Whole> whole;
  std::optional<glm::dmat4> world_to_camera, world_to_ndc;
  bool panorama = false;  // of all directions: an EXR's attribute envmap
  /// String attributes (of a PNG, texts) by name: kJob, "comments", …
  std::map<std::string, std::string> text;
  /// What the picture is made of: a job, which draws it again.
  static constexpr const char* kJob = "kiln:job";
  /// How many bricks could not be read and were drawn as nothing (of parts put together at most so many, as two may
  /// have met one); not there where there were none.
  static constexpr const char* kDamagedBricks = "kiln:damagedBricks";
};

struct ImageFileOptions {
  bool exr_float = false;  // else half
  int png_bits = 8;        // 8 or 16
  /// none, rle, zips, zip, piz, or, with loss, dwaa or dwab.
  std::string exr_compression = "zip";
  /// What compressing an EXR may hold beside the picture (image/file/exr_cost.h); with more, more threads take part.
  std::uint64_t writer_bytes = UINT64_MAX;
};

/// Writes by the file's extension, .exr or .png; equal input gives equal bytes. cost: the compressed file in memory, of
/// up to a MiB of pixels; of larger pictures disk space for that file twice.
/// throws: Error kUsage (another extension; planes in a PNG; an unknown compression), kNoSpace, kIo.
void writeImage(const Image& image, const ImageMetadata& metadata, const ImageFileOptions& options,
                const std::filesystem::path& path, FileSystem& disk = FileSystem::real());

/// The same, band by band: gives the bytes that `writeImage` gives for the whole image. cost: a band, some rows and no
/// more memory; disk space for the compressed file twice. throws: also what `rows` throws.
void writeImage(ImageRows& rows, const ImageMetadata& metadata, const ImageFileOptions& options,
                const std::filesystem::path& path, FileSystem& disk = FileSystem::real());

/// One of several views of a scene, such as what an eye sees.
struct ImageView {
  std::string name;
  const Image* image = nullptr;
  ImageMetadata metadata;
};

/// Writes an EXR of as many parts as there are views, each with the attribute `view`. A program that knows of no parts
/// reads the first. requires: all of one size. throws: as writeImage.
void writeImageViews(std::span<const ImageView> views, const ImageFileOptions& options,
                     const std::filesystem::path& path, FileSystem& disk = FileSystem::real());

/// Writes a deep EXR: per pixel R G B A, of the options' type, and Z and ZBack as 32-bit floats, from front to back.
/// Half floats are chosen so that what they are when laid over one another is half a float's rounding from what the
/// samples are. "zip" is written as "zips". throws: as writeImage; Error kUsage for a compression that deep files have
/// not.
void writeDeepImage(const DeepSamples& samples, const ImageMetadata& metadata, const ImageFileOptions& options,
                    const std::filesystem::path& path, FileSystem& disk = FileSystem::real());

/// Whether `writeImage` makes the path an EXR.
bool isExrPath(const std::filesystem::path& path);

/// throws: Error kUsage where `path` has an extension that `writeImage` refuses for a picture with or without planes.
/// For a check before long work.
void requireImagePath(const std::filesystem::path& path, bool with_planes = false);

/// No limit for what reading a picture takes.
inline constexpr std::uint64_t kUnlimitedBytes = UINT64_MAX;

/// Reads R, G, B, A (or Y) of an EXR's data window, no planes, or a PNG back to linear premultiplied; the first bytes
/// say which format it is. Of a deep EXR, the samples are laid over one another. `memory_bytes` holds the file, the
/// picture and what unpacks it. throws: Error kFormat, kNotFound, kUnsupported; kBudget, with the memory that suffices,
/// before it is taken.
Image readImage(const std::filesystem::path& path, std::span<const std::string> planes = {},
                std::uint64_t memory_bytes = kUnlimitedBytes);
/// Reads all of a file, whatever it shows, and keeps nothing. throws: as readImage.
void checkImage(const std::filesystem::path& path, std::uint64_t memory_bytes = kUnlimitedBytes);
/// The string attributes of an EXR, the texts of a PNG in front of the pixels. cost: reads no pixels. throws: as
/// readImage.
std::map<std::string, std::string> readImageText(const std::filesystem::path& path,
                                                 std::uint64_t memory_bytes = kUnlimitedBytes);

/// How a picture's file holds its pixels, of an EXR of several parts the first. unit of the window: pixels.
struct PixelLayout {
  std::int64_t x = 0, y = 0, width = 0, height = 0;           // of an EXR, its data window
  int png_bits = 0;                                           // of a PNG, for each channel
  std::string compression;                                    // of an EXR, as OpenEXR names it
  std::vector<std::pair<std::string, std::string>> channels;  // of an EXR, name and type: uint, half or float
  bool deep = false;
};
/// cost: reads the headers alone. throws: as readImageText.
PixelLayout readPixelLayout(const std::filesystem::path& path);

}  // namespace kiln
