// libjpeg reports errors by longjmp, which must not pass over C++ objects with destructors: all of its calls are in
// small functions whose locals are plain data. Its warnings report missing or damaged data, which it fills with grey.
// A warning is therefore an error.
#include <fmt/format.h>

#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <optional>

// jpeglib.h needs stdio.h in front.
#include <jpeglib.h>

#include "base/error.h"
#include "base/file/file.h"
#include "ingest/pictures/picture_slice.h"

namespace kiln {
namespace {

// A block of 64 equal pixels takes two bits or more, in progressive files some less.
constexpr std::uint64_t kMostOfJpeg = 2048;
constexpr std::uint64_t kFrontBytes = 64 << 10, kMostHeaderBytes = 64 << 20;

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
bool runJpeg(JpegHandle& handle, std::span<const std::byte> data, unsigned char* out) noexcept {
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
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(data.data()), static_cast<unsigned long>(data.size()));
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

struct JpegHeader {
  PictureSlice slice;
  int components = 0, bits = 0;
};

// Parses the header at the front of `data`; nothing if libjpeg found an error.
std::optional<JpegHeader> headerIn(JpegHandle& handle, std::span<const std::byte> data) {
  if (!runJpeg(handle, data, nullptr)) return std::nullopt;
  const jpeg_decompress_struct& jpeg = handle.jpeg;
  const JpegHeader out = {
      {static_cast<std::int64_t>(jpeg.image_width), static_cast<std::int64_t>(jpeg.image_height), VoxelType::u8},
      jpeg.num_components,
      jpeg.data_precision};
  jpeg_destroy_decompress(&handle.jpeg);
  return out;
}

// The front holds the header, unless long segments, such as profiles of colour, precede it.
JpegHeader headerOf(const File& file) {
  std::optional<JpegHeader> out;
  JpegHandle handle;
  for (const std::uint64_t most : {kFrontBytes, kMostHeaderBytes}) {
    std::vector<std::byte> data(static_cast<std::size_t>(std::min(file.size(), most)));
    data.resize(file.readSomeAt(0, data));
    handle = {};
    out = headerIn(handle, data);
    // libjpeg completes data that end inside the header, with a warning.
    if (out && !handle.warned) break;
  }
  if (!out) failJpeg(file.path(), handle);
  return *out;
}

}  // namespace

PictureHeader readJpegHeader(const std::filesystem::path& path) {
  const File file(path);
  const auto [slice, components, bits] = headerOf(file);
  if (components != 1)
    throw Error(ErrorCode::kUnsupported, path, "",
                fmt::format("holds {} colours a pixel, not one value; save it as grey", components));
  if (bits != 8)
    throw Error(ErrorCode::kUnsupported, path, "", fmt::format("holds values of {} bits; 8 are read", bits));
  if (slice.bytes() / kMostOfJpeg > file.size())
    throw Error(ErrorCode::kFormat, path, "",
                fmt::format("is {} x {}, more than its {} bytes can hold", slice.width, slice.height, file.size()));
  return {slice, file.size()};
}

std::vector<std::byte> decodeJpeg(const std::filesystem::path& path, const PictureSlice& slice,
                                  std::uint64_t limit_bytes) {
  const std::vector<std::byte> data = readFile(path, limit_bytes);
  JpegHandle handle;
  // The file may have changed since its header was read.
  const std::optional<JpegHeader> found = headerIn(handle, data);
  if (!found) failJpeg(path, handle);
  if (!(found->slice == slice) || found->components != 1)
    throw Error(ErrorCode::kFormat, path, "", "has changed while it was read");
  std::vector<std::byte> out(static_cast<std::size_t>(slice.bytes()));
  if (!runJpeg(handle, data, reinterpret_cast<unsigned char*>(out.data()))) failJpeg(path, handle);
  jpeg_destroy_decompress(&handle.jpeg);
  if (handle.warned) failJpeg(path, handle);
  return out;
}

}  // namespace kiln
