#include "support/files/picture_files.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

// jpeglib.h needs stdio.h in front.
#include <jpeglib.h>

#include "support/files/header_writer.h"

namespace kiln::test {

std::string pngChunk(const std::string& name, const std::string& data) {
  std::string out(4, '\0');
  putNumber(out, 0, static_cast<std::uint32_t>(data.size()), true);
  out += name + data;
  std::string check(4, '\0');
  const std::string checked = name + data;
  putNumber(check, 0,
            static_cast<std::uint32_t>(
                crc32(0, reinterpret_cast<const Bytef*>(checked.data()), static_cast<uInt>(checked.size()))),
            true);
  return out + check;
}

std::string pngFile(int width, int height, int depth, int colour, const std::string& rows, const std::string& more) {
  std::string header(13, '\0');
  putNumber(header, 0, width, true), putNumber(header, 4, height, true);
  header[8] = static_cast<char>(depth), header[9] = static_cast<char>(colour);
  std::string filtered;
  const std::size_t row = rows.size() / static_cast<std::size_t>(height);
  for (std::size_t at = 0; at < rows.size(); at += row) filtered += '\0' + rows.substr(at, row);
  return "\x89PNG\r\n\x1a\n" + pngChunk("IHDR", header) + more + pngChunk("IDAT", zlibbed(filtered)) +
         pngChunk("IEND", "");
}

std::string pngSlice(const ForeignVolume& volume, std::int64_t z) {
  const ForeignVolume slice = {
      {volume.dims.x, volume.dims.y, 1}, volume.type, volume.box({{0, 0, z}, {volume.dims.x, volume.dims.y, z + 1}})};
  return pngFile(static_cast<int>(volume.dims.x), static_cast<int>(volume.dims.y),
                 static_cast<int>(8 * sizeOf(volume.type)), 0, slice.stored(true));
}

std::string jpegFile(int width, int height, int components, const std::string& pixels, bool progressive) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* out = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &out, &size);
  jpeg.image_width = static_cast<JDIMENSION>(width), jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = components;
  jpeg.in_color_space = components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 100, TRUE);
  if (progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  for (int y = 0; y < height; ++y) {
    auto* row = reinterpret_cast<unsigned char*>(const_cast<char*>(pixels.data())) + y * width * components;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  std::string bytes(reinterpret_cast<const char*>(out), size);
  jpeg_destroy_compress(&jpeg);
  std::free(out);
  return bytes;
}

std::string jpeg2000Slice(const ForeignVolume& volume, std::int64_t z, const Jpeg2000Layout& layout) {
  const ForeignFiles files;
  std::string pixels;
  for (int i = 0; i < layout.components; ++i)
    pixels += volume.part({{0, 0, z}, {volume.dims.x, volume.dims.y, z + 1}}).stored(true);
  const auto raw = files.write("slice.raw", pixels);
  const auto packed = files.directory() / (layout.boxes ? "slice.jp2" : "slice.j2k");
  const bool is_signed = volume.type == VoxelType::i8 || volume.type == VoxelType::i16;
  const int bits = layout.bits > 0 ? layout.bits : static_cast<int>(8 * sizeOf(volume.type));
  const std::string command =
      fmt::format("opj_compress -i '{}' -o '{}' -F {},{},{},{},{} {} > /dev/null 2>&1", raw.string(), packed.string(),
                  volume.dims.x, volume.dims.y, layout.components, bits, is_signed ? 's' : 'u', layout.options);
  if (std::system(command.c_str()) != 0) throw std::runtime_error("opj_compress (libopenjp2-tools) failed");
  return bytesOf(packed);
}

}  // namespace kiln::test
