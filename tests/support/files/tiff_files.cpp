#include "support/files/tiff_files.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <algorithm>
#include <array>

namespace kiln::test {
namespace {

int sampleFormat(VoxelType type) {
  if (isFloating(type)) return SAMPLEFORMAT_IEEEFP;
  const bool is_signed = type == VoxelType::i8 || type == VoxelType::i16 || type == VoxelType::i32;
  return is_signed ? SAMPLEFORMAT_INT : SAMPLEFORMAT_UINT;
}

std::int64_t valuesOfPixel(const TiffLayout& layout) { return layout.holds_samples ? layout.samples : 1; }

void setFields(TIFF* tiff, const ForeignVolume& volume, const TiffLayout& layout) {
  const auto width = static_cast<std::uint32_t>(volume.dims.x / valuesOfPixel(layout)),
             height = static_cast<std::uint32_t>(volume.dims.y);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, layout.bits > 0 ? layout.bits : static_cast<int>(sizeOf(volume.type)) * 8);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, layout.samples);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
               layout.sample_format > 0 ? layout.sample_format : static_cast<int>(sampleFormat(volume.type)));
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, layout.photometric);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, layout.compression);
  if (layout.predictor != 1) TIFFSetField(tiff, TIFFTAG_PREDICTOR, layout.predictor);
  if (layout.tile > 0) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, layout.tile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, layout.tile);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, layout.strip_rows > 0 ? layout.strip_rows : static_cast<int>(height));
  }
  if (layout.photometric == PHOTOMETRIC_PALETTE) {
    std::array<std::uint16_t, 256> ramp{};
    TIFFSetField(tiff, TIFFTAG_COLORMAP, ramp.data(), ramp.data(), ramp.data());
  }
  if (!layout.description.empty()) TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, layout.description.c_str());
  if (layout.x_resolution > 0) TIFFSetField(tiff, TIFFTAG_XRESOLUTION, layout.x_resolution);
  if (layout.y_resolution > 0) TIFFSetField(tiff, TIFFTAG_YRESOLUTION, layout.y_resolution);
  if (layout.orientation > 0) TIFFSetField(tiff, TIFFTAG_ORIENTATION, layout.orientation);
  if (layout.resolution_unit > 0) TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, layout.resolution_unit);
}

void writeBlocks(TIFF* tiff, const ForeignVolume& volume, std::int64_t z, const TiffLayout& layout) {
  const Extent3& dims = volume.dims;
  const std::int64_t width = layout.tile > 0 ? layout.tile * valuesOfPixel(layout) : dims.x;
  const std::int64_t height = layout.tile > 0 ? layout.tile : layout.strip_rows > 0 ? layout.strip_rows : dims.y;
  std::uint32_t index = 0;
  for (std::int64_t y = 0; y < dims.y; y += height) {
    for (std::int64_t x = 0; x < dims.x; x += width, ++index) {
      const VoxelBox part = intersection({{x, y, z}, {x + width, y + height, z + 1}}, boxOf(dims));
      const std::vector<std::byte> rows = volume.box(part);
      // A strip ends with the page, a tile does not.
      const std::size_t row = static_cast<std::size_t>(part.extent().x) * sizeOf(volume.type);
      const std::size_t line = static_cast<std::size_t>(width) * sizeOf(volume.type);
      const std::int64_t lines = layout.tile > 0 ? height : part.extent().y;
      std::vector<std::byte> block(line * static_cast<std::size_t>(lines));
      for (std::size_t i = 0; i * row < rows.size(); ++i) std::copy_n(&rows[i * row], row, &block[i * line]);
      if (layout.bits > 0 || layout.samples > valuesOfPixel(layout)) {
        const tmsize_t bytes =
            layout.tile > 0 ? TIFFTileSize(tiff) : TIFFVStripSize(tiff, static_cast<std::uint32_t>(lines));
        block.assign(static_cast<std::size_t>(bytes), std::byte{0});
      }
      const auto size = static_cast<tmsize_t>(block.size());
      const tmsize_t written = layout.tile > 0 ? TIFFWriteEncodedTile(tiff, index, block.data(), size)
                                               : TIFFWriteEncodedStrip(tiff, index, block.data(), size);
      ASSERT_EQ(written, size);
    }
  }
}

}  // namespace

void writeTiff(const std::filesystem::path& path, const ForeignVolume& volume, std::int64_t z0, std::int64_t z1,
               const TiffLayout& layout) {
  const std::string mode = std::string("w") + (layout.big_endian ? "b" : "l") + (layout.big_tiff ? "8" : "");
  TIFF* const tiff = TIFFOpen(path.c_str(), mode.c_str());
  ASSERT_NE(tiff, nullptr) << path;
  for (std::int64_t z = z0; z < z1; ++z) {
    setFields(tiff, volume, layout);
    if (z >= z1 - layout.reduced_pages) TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
    writeBlocks(tiff, volume, z, layout);
    ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
  }
  TIFFClose(tiff);
}

}  // namespace kiln::test
