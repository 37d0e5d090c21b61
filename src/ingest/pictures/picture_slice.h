// Grey PNG and JPEG files as slices of a volume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "grid/voxel_type.h"

namespace kiln {

struct PictureSlice {
  std::int64_t width = 0, height = 0;
  VoxelType type = VoxelType::u8;

  bool operator==(const PictureSlice&) const = default;
  std::uint64_t bytes() const { return static_cast<std::uint64_t>(width * height) * sizeOf(type); }
};

struct PictureHeader {
  PictureSlice slice;
  /// Size of the file. unit: bytes.
  std::uint64_t file_bytes = 0;
};

/// Reads the header of a PNG file. throws: Error kFormat if the file is damaged, kUnsupported for colours, palettes and
/// alpha; kIo.
PictureHeader readPngHeader(const std::filesystem::path& path);
/// Returns the values of a PNG file in the machine's byte order; values of 1, 2 and 4 bits as bytes, unscaled.
/// requires: `slice` is the file's. throws: Error kFormat if the file is damaged, cut short or larger than
/// `limit_bytes`; kIo. cost: the file in memory.
std::vector<std::byte> decodePng(const std::filesystem::path& path, const PictureSlice& slice,
                                 std::uint64_t limit_bytes);

/// As readPngHeader, of a JPEG file of 8 bits. cost: reads the front of the file.
PictureHeader readJpegHeader(const std::filesystem::path& path);
/// As decodePng. cost: kJpegPixelBytes more, the coefficients of a progressive file.
std::vector<std::byte> decodeJpeg(const std::filesystem::path& path, const PictureSlice& slice,
                                  std::uint64_t limit_bytes);
/// unit: bytes a pixel.
inline constexpr std::uint64_t kJpegPixelBytes = 2;

}  // namespace kiln
