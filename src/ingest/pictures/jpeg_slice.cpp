// libjpeg reports errors by longjmp, which must not pass over C++ objects with destructors: all of its calls are in
// small functions whose locals are plain data. Its warnings tell of missing or damaged data, which it fills with grey,
// so a warning is an error.
#include <fmt/format.h>

#include <algorithm>
#include <csetjmp>
#include <cstdio>

// jpeglib.h needs stdio.h in front.
#include <jpeglib.h>

#include "base/error.h"
#include "base/file.h"
#include "ingest/pictures/picture_slice.h"

namespace kiln {
namespace {

// A block of 64 equal pixels takes two bits or more, in progressive files some less.
constexpr std::uint64_t kMostOfJpeg = 2048;

struct JpegHandle {
  jpeg_error_mgr errors;
  jpeg_decompress_struct jpeg;
  std::jmp_buf jump;
  char complaint[JMSG_LENGTH_MAX] = "";
  bool warned = false;
};

JpegHandle& handleOf(j_common_ptr jpeg) { return *static_cast<JpegHandle*>(jpeg->client_data); }

[[noreturn]] void onJpegError(j_common_ptr jpeg) {
  jpeg->err->format_message(jpeg, handleOf(jpeg).complaint);
  std::longjmp(handleOf(jpeg).jump, 1);
}
void onJpegMessage(j_common_ptr jpeg, int level) {
  if (level >= 0 || handleOf(jpeg).warned) return;
  handleOf(jpeg).warned = true;
  jpeg->err->format_message(jpeg, handleOf(jpeg).complaint);
}
void onJpegOutput(j_common_ptr) {}

// Reads the header, and the pixels if `out` is not null. Returns false if libjpeg found an error.
bool runJpeg(JpegHandle& handle, const unsigned char* data, std::size_t size, unsigned char* out) noexcept {
  jpeg_decompress_struct& jpeg = handle.jpeg;
  jpeg = {};
  jpeg.err = jpeg_std_error(&handle.errors);
  handle.errors.error_exit = &onJpegError;
  handle.errors.emit_message = &onJpegMessage;
  handle.errors.output_message = &onJpegOutput;
  jpeg.client_data = &handle;
  if (setjmp(handle.jump) != 0) {
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, data, static_cast<unsigned long>(size));
  jpeg_read_header(&jpeg, TRUE);
  if (out != nullptr) {
    jpeg.out_color_space = JCS_GRAYSCALE;
    jpeg_start_decompress(&jpeg);
    while (jpeg.output_scanline < jpeg.output_height) {
      JSAMPROW row = out + static_cast<std::size_t>(jpeg.output_scanline) * jpeg.output_width;
      jpeg_read_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_decompress(&jpeg);
  }
  return true;
}

[[noreturn]] void failJpeg(const std::filesystem::path& path, const JpegHandle& handle) {
  throw Error(ErrorCode::kFormat, path, "",
              fmt::format("cannot be decoded; the file is cut short or damaged (libjpeg: {})", handle.complaint));
}

PictureSlice pictureOf(const jpeg_decompress_struct& jpeg) {
  return {static_cast<std::int64_t>(jpeg.image_width), static_cast<std::int64_t>(jpeg.image_height), VoxelType::u8};
}

}  // namespace

PictureSlice readJpegHeader(const std::filesystem::path& path) {
  const std::vector<std::byte> data = readFile(path);
  JpegHandle handle;
  if (!runJpeg(handle, reinterpret_cast<const unsigned char*>(data.data()), data.size(), nullptr))
    failJpeg(path, handle);
  const PictureSlice out = pictureOf(handle.jpeg);
  const int components = handle.jpeg.num_components, bits = handle.jpeg.data_precision;
  jpeg_destroy_decompress(&handle.jpeg);
  if (components != 1)
    throw Error(ErrorCode::kUnsupported, path, "",
                fmt::format("holds {} colours a pixel, not one value; save it as grey", components));
  if (bits != 8)
    throw Error(ErrorCode::kUnsupported, path, "", fmt::format("holds values of {} bits; 8 are read", bits));
  if (out.bytes() / kMostOfJpeg > data.size())
    throw Error(ErrorCode::kFormat, path, "",
                fmt::format("is {} x {}, more than its {} bytes can hold", out.width, out.height, data.size()));
  return out;
}

std::vector<std::byte> decodeJpeg(const std::filesystem::path& path, const PictureSlice& header) {
  const std::vector<std::byte> data = readFile(path);
  const auto* const bytes = reinterpret_cast<const unsigned char*>(data.data());
  JpegHandle handle;
  // The file may have changed since its header was read.
  if (!runJpeg(handle, bytes, data.size(), nullptr)) failJpeg(path, handle);
  const bool same = pictureOf(handle.jpeg) == header && handle.jpeg.num_components == 1;
  jpeg_destroy_decompress(&handle.jpeg);
  if (!same) throw Error(ErrorCode::kFormat, path, "", "has changed while it was read");
  std::vector<std::byte> out(static_cast<std::size_t>(header.bytes()));
  if (!runJpeg(handle, bytes, data.size(), reinterpret_cast<unsigned char*>(out.data()))) failJpeg(path, handle);
  jpeg_destroy_decompress(&handle.jpeg);
  if (handle.warned) failJpeg(path, handle);
  return out;
}

}  // namespace kiln
