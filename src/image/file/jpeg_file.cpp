// libjpeg reports errors by longjmp, which must not pass over C++ objects with destructors: all calls are in a single
// function with locals of plain data.
#include "image/file/jpeg_file.h"

#include <algorithm>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

// jpeglib.h needs stdio.h in front.
#include <jpeglib.h>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "image/srgb.h"

namespace kiln {
namespace {

struct JpegOutput {
  jpeg_error_mgr errors;
  jpeg_compress_struct jpeg;
  std::jmp_buf jump;
  char complaint[JMSG_LENGTH_MAX] = "";
  unsigned char* bytes = nullptr;
  unsigned long count = 0;
  ~JpegOutput() { std::free(bytes); }
};

[[noreturn]] void onEncodeError(j_common_ptr jpeg) {
  auto& output = *static_cast<JpegOutput*>(jpeg->client_data);
  jpeg->err->format_message(jpeg, output.complaint);
  std::longjmp(output.jump, 1);
}
void onEncodeMessage(j_common_ptr) {}

// Returns false if libjpeg found an error. shape: 3 bytes a pixel.
bool compress(JpegOutput& output, std::uint8_t* pixels, int width, int height, int quality) noexcept {
  jpeg_compress_struct& jpeg = output.jpeg;
  jpeg = {};
  jpeg.err = jpeg_std_error(&output.errors);
  output.errors.error_exit = &onEncodeError;
  output.errors.output_message = &onEncodeMessage;
  jpeg.client_data = &output;
  if (setjmp(output.jump) != 0) {
    jpeg_destroy_compress(&jpeg);
    return false;
  }
  jpeg_create_compress(&jpeg);
  jpeg_mem_dest(&jpeg, &output.bytes, &output.count);
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg.dct_method = JDCT_ISLOW;
  jpeg_start_compress(&jpeg, TRUE);
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = pixels + std::size_t{3} * jpeg.next_scanline * jpeg.image_width;
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  return true;
}

}  // namespace

std::vector<std::byte> encodeJpeg(ImageRows& rows, int quality) {
  const SrgbBytes& srgb = SrgbBytes::all();
  const auto width = static_cast<std::size_t>(rows.width);
  std::vector<std::uint8_t> pixels(3 * width * static_cast<std::size_t>(rows.height));
  for (int y = 0; y < rows.height;) {
    const ImageRows::Band band = rows.bandAt(y);
    const int end = std::min(band.end(), rows.height);
    parallelFor(static_cast<std::size_t>(end - y), [&](std::size_t i) {
      const int row = y + static_cast<int>(i);
      std::uint8_t* out = pixels.data() + 3 * width * static_cast<std::size_t>(row);
      const float* rgba = band.image->pixel(0, row - band.first_row);
      for (std::size_t x = 0; x < width; ++x, rgba += 4) {
        for (int channel = 0; channel < 3; ++channel) *out++ = srgb.of(rgba[channel]);
      }
    });
    y = end;
  }
  JpegOutput output;
  if (!compress(output, pixels.data(), rows.width, rows.height, quality))
    throw Error(ErrorCode::kIo, std::string("libjpeg cannot encode a picture: ") + output.complaint);
  const auto bytes = std::as_bytes(std::span(output.bytes, output.count));
  return {bytes.begin(), bytes.end()};
}

}  // namespace kiln
