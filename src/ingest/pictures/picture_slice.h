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

/// Reads the header of a PNG file. throws: Error kFormat if it is damaged, kUnsupported for colours, palettes and
/// alpha; kIo.
PictureSlice readPngHeader(const std::filesystem::path& path);
/// Returns the values of a PNG file in the machine's byte order; those of 1, 2 and 4 bits as bytes, unscaled.
/// requires: `header` is the file's. throws: Error kFormat if it is damaged or cut short; kIo.
std::vector<std::byte> decodePng(const std::filesystem::path& path, const PictureSlice& header);

/// As readPngHeader, of a JPEG file of 8 bits.
PictureSlice readJpegHeader(const std::filesystem::path& path);
/// As decodePng.
std::vector<std::byte> decodeJpeg(const std::filesystem::path& path, const PictureSlice& header);

}  // namespace kiln
