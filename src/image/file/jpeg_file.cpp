// libjpeg reports errors by longjmp, which must not pass over C++ objects with destructors: its calls are in small
// noexcept functions whose locals are plain data. Its warnings report missing or damaged data, so a warning is an
// error.
#include "image/file/jpeg_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <new>
#include <span>
#include <string_view>
#include <utility>

// jpeglib.h needs stdio.h in front.
#include <jpeglib.h>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "image/file/text_block.h"
#include "image/image_memory.h"
#include "image/srgb.h"

namespace kiln {
namespace {

constexpr int kRowsAtATime = 16;
constexpr int kFullColorQuality = 90;
// Begins the comments that hold texts.
constexpr std::string_view kTextMark = "kiln\n";
constexpr std::size_t kMostOfComment = 65533;

// The buffer belongs to Kiln: libjpeg's own destination in memory hands its buffer over at the end only, and an
// exception may end an encoding before.
struct JpegOutput {
  jpeg_error_mgr errors;
  jpeg_compress_struct jpeg;
  jpeg_destination_mgr destination;
  std::jmp_buf jump;
  char complaint[JMSG_LENGTH_MAX] = "";
  bool out_of_memory = false;
  std::vector<std::byte> file;     // what the buffer held when it was full
  std::array<JOCTET, 16384> full;  // the buffer
  JpegOutput() { jpeg = {}; }
  ~JpegOutput() { jpeg_destroy_compress(&jpeg); }
};

// Appends the first `count` bytes of the buffer to the file.
bool keep(JpegOutput& output, std::size_t count) noexcept {
  try {
    const auto bytes = std::as_bytes(std::span(output.full)).first(count);
    output.file.insert(output.file.end(), bytes.begin(), bytes.end());
  } catch (const std::bad_alloc&) {
    output.out_of_memory = true;
  }
  return !output.out_of_memory;
}

void emptyBuffer(JpegOutput& output) noexcept {
  output.destination.next_output_byte = output.full.data();
  output.destination.free_in_buffer = output.full.size();
}

JpegOutput& outputOf(j_compress_ptr jpeg) { return *static_cast<JpegOutput*>(jpeg->client_data); }

void onBegin(j_compress_ptr jpeg) { emptyBuffer(outputOf(jpeg)); }
boolean onFull(j_compress_ptr jpeg) {
  JpegOutput& output = outputOf(jpeg);
  if (!keep(output, output.full.size())) std::longjmp(output.jump, 1);
  emptyBuffer(output);
  return TRUE;
}
void onEnd(j_compress_ptr jpeg) {
  JpegOutput& output = outputOf(jpeg);
  if (!keep(output, output.full.size() - output.destination.free_in_buffer)) std::longjmp(output.jump, 1);
}

[[noreturn]] void onEncodeError(j_common_ptr jpeg) {
  auto& output = *static_cast<JpegOutput*>(jpeg->client_data);
  jpeg->err->format_message(jpeg, output.complaint);
  std::longjmp(output.jump, 1);
}
void onEncodeMessage(j_common_ptr) {}

// The functions below return false if libjpeg found an error. shape: 3 bytes a pixel.
bool begin(JpegOutput& output, int width, int height, int quality) noexcept {
  jpeg_compress_struct& jpeg = output.jpeg;
  jpeg.err = jpeg_std_error(&output.errors);
  output.errors.error_exit = &onEncodeError;
  output.errors.output_message = &onEncodeMessage;
  jpeg.client_data = &output;
  if (setjmp(output.jump) != 0) return false;
  jpeg_create_compress(&jpeg);
  output.destination.init_destination = &onBegin;
  output.destination.empty_output_buffer = &onFull;
  output.destination.term_destination = &onEnd;
  jpeg.dest = &output.destination;
  jpeg.image_width = static_cast<JDIMENSION>(width);
  jpeg.image_height = static_cast<JDIMENSION>(height);
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  if (quality >= kFullColorQuality) jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
  jpeg.dct_method = JDCT_ISLOW;
  jpeg_start_compress(&jpeg, TRUE);
  return true;
}

bool putComment(JpegOutput& output, const char* text, std::size_t bytes) noexcept {
  if (setjmp(output.jump) != 0) return false;
  jpeg_write_marker(&output.jpeg, JPEG_COM, reinterpret_cast<const JOCTET*>(text), static_cast<unsigned>(bytes));
  return true;
}

bool putRows(JpegOutput& output, std::uint8_t* pixels, int rows) noexcept {
  if (setjmp(output.jump) != 0) return false;
  for (int y = 0; y < rows; ++y) {
    JSAMPROW row = pixels + std::size_t{3} * static_cast<std::size_t>(y) * output.jpeg.image_width;
    jpeg_write_scanlines(&output.jpeg, &row, 1);
  }
  return true;
}

bool end(JpegOutput& output) noexcept {
  if (setjmp(output.jump) != 0) return false;
  jpeg_finish_compress(&output.jpeg);
  return true;
}

struct JpegInput {
  jpeg_error_mgr errors;
  jpeg_decompress_struct jpeg;
  std::jmp_buf jump;
  char complaint[JMSG_LENGTH_MAX] = "";
  bool warned = false;
  JpegInput() { jpeg = {}; }
  ~JpegInput() { jpeg_destroy_decompress(&jpeg); }
};

JpegInput& inputOf(j_common_ptr jpeg) { return *static_cast<JpegInput*>(jpeg->client_data); }

[[noreturn]] void onDecodeError(j_common_ptr jpeg) {
  jpeg->err->format_message(jpeg, inputOf(jpeg).complaint);
  std::longjmp(inputOf(jpeg).jump, 1);
}
void onDecodeMessage(j_common_ptr jpeg, int level) {
  if (level >= 0 || inputOf(jpeg).warned) return;
  inputOf(jpeg).warned = true;
  jpeg->err->format_message(jpeg, inputOf(jpeg).complaint);
}

bool readHead(JpegInput& input, std::span<const std::byte> data) noexcept {
  jpeg_decompress_struct& jpeg = input.jpeg;
  jpeg.err = jpeg_std_error(&input.errors);
  input.errors.error_exit = &onDecodeError;
  input.errors.emit_message = &onDecodeMessage;
  input.errors.output_message = &onEncodeMessage;
  jpeg.client_data = &input;
  if (setjmp(input.jump) != 0) return false;
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(data.data()), static_cast<unsigned long>(data.size()));
  jpeg_save_markers(&jpeg, JPEG_COM, 0xffff);
  jpeg_read_header(&jpeg, TRUE);
  return !input.warned;
}

bool startRows(JpegInput& input) noexcept {
  if (setjmp(input.jump) != 0) return false;
  input.jpeg.out_color_space = JCS_RGB;
  jpeg_start_decompress(&input.jpeg);
  return !input.warned;
}

bool readRow(JpegInput& input, std::uint8_t* pixels) noexcept {
  if (setjmp(input.jump) != 0) return false;
  JSAMPROW row = pixels;
  jpeg_read_scanlines(&input.jpeg, &row, 1);
  return !input.warned;
}

bool readEnd(JpegInput& input) noexcept {
  if (setjmp(input.jump) != 0) return false;
  jpeg_finish_decompress(&input.jpeg);
  return !input.warned;
}

// The coefficients of a file in several scans, such as a progressive one, which libjpeg holds until the last scan;
// whole blocks of all components. unit: bytes.
std::uint64_t coefficientBytes(JpegInput& input) {
  jpeg_decompress_struct& jpeg = input.jpeg;
  if (!jpeg_has_multiple_scans(&jpeg)) return 0;
  const auto roundedUp = [](std::uint64_t blocks, int unit) {
    const auto of = static_cast<std::uint64_t>(unit);
    return (blocks + of - 1) / of * of;
  };
  std::uint64_t blocks = 0;
  for (int i = 0; i < jpeg.num_components; ++i) {
    const jpeg_component_info& component = jpeg.comp_info[i];
    blocks += roundedUp(component.width_in_blocks, component.h_samp_factor) *
              roundedUp(component.height_in_blocks, component.v_samp_factor);
  }
  return blocks * sizeof(JBLOCK);
}

void requireRead(bool done, const JpegInput& input, const std::filesystem::path& path) {
  if (!done)
    throw Error(ErrorCode::kFormat, path, "",
                fmt::format("cannot be decoded; the file is cut short or damaged (libjpeg: {})", input.complaint));
}

// Passes each row, of 3 bytes a pixel, to `use`.
template <class Use>
void readRows(JpegInput& input, const std::filesystem::path& path, const Use& use) {
  requireRead(startRows(input), input, path);
  std::vector<std::uint8_t> row(std::size_t{3} * input.jpeg.output_width);
  for (unsigned y = 0; y < input.jpeg.output_height; ++y) {
    requireRead(readRow(input, row.data()), input, path);
    use(static_cast<int>(y), row);
  }
  requireRead(readEnd(input), input, path);
}

}  // namespace

bool looksLikeJpeg(std::span<const std::byte> data) {
  return data.size() >= 3 && data[0] == std::byte{0xff} && data[1] == std::byte{0xd8} && data[2] == std::byte{0xff};
}

std::vector<std::byte> encodeJpeg(ImageRows& rows, int quality, const std::map<std::string, std::string>& text) {
  JpegOutput output;
  const auto require = [&](bool done) {
    if (output.out_of_memory) throw std::bad_alloc();
    if (!done) throw Error(ErrorCode::kIo, std::string("libjpeg cannot encode a picture: ") + output.complaint);
  };
  require(begin(output, rows.width, rows.height, quality));
  const std::string block = textBlock(text);
  for (std::size_t at = 0; at < block.size(); at += kMostOfComment - kTextMark.size()) {
    const std::string comment = std::string(kTextMark) + block.substr(at, kMostOfComment - kTextMark.size());
    require(putComment(output, comment.data(), comment.size()));
  }
  const SrgbBytes& srgb = SrgbBytes::all();
  const auto width = static_cast<std::size_t>(rows.width);
  std::vector<std::uint8_t> pixels(3 * width * kRowsAtATime);
  for (int y = 0; y < rows.height;) {
    const ImageRows::Band band = rows.bandAt(y);
    const int count = std::min({band.end() - y, rows.height - y, kRowsAtATime});
    parallelFor(static_cast<std::size_t>(count), [&](std::size_t i) {
      std::uint8_t* out = pixels.data() + 3 * width * i;
      const float* rgba = band.image->pixel(0, y + static_cast<int>(i) - band.first_row);
      for (std::size_t x = 0; x < width; ++x, rgba += 4) {
        for (int channel = 0; channel < 3; ++channel) *out++ = srgb.of(rgba[channel]);
      }
    });
    require(putRows(output, pixels.data(), count));
    y += count;
  }
  require(end(output));
  return std::move(output.file);
}

std::map<std::string, std::string> decodeJpegText(std::span<const std::byte> data, const std::filesystem::path& path) {
  JpegInput input;
  requireRead(readHead(input, data), input, path);
  std::string block;
  for (auto* marker = input.jpeg.marker_list; marker != nullptr; marker = marker->next) {
    const std::string_view comment(reinterpret_cast<const char*>(marker->data), marker->data_length);
    if (comment.starts_with(kTextMark)) block += comment.substr(kTextMark.size());
  }
  return textsOfBlock(block).value_or(std::map<std::string, std::string>());
}

Image decodeJpeg(std::span<const std::byte> data, const std::filesystem::path& path, std::uint64_t memory_bytes) {
  JpegInput input;
  requireRead(readHead(input, data), input, path);
  const std::uint64_t pixels = std::uint64_t{input.jpeg.image_width} * input.jpeg.image_height;
  requireMemory(pixels * 4 * sizeof(float) + coefficientBytes(input), memory_bytes, path);
  std::array<float, 256> light;
  for (std::size_t i = 0; i < light.size(); ++i) light[i] = static_cast<float>(linearFromSrgb(double(i) / 255));
  Image out(static_cast<int>(input.jpeg.image_width), static_cast<int>(input.jpeg.image_height));
  readRows(input, path, [&](int y, const std::vector<std::uint8_t>& row) {
    float* pixel = out.pixel(0, y);
    for (std::size_t i = 0; i < row.size(); i += 3, pixel += 4) {
      for (std::size_t channel = 0; channel < 3; ++channel) pixel[channel] = light[row[i + channel]];
      pixel[3] = 1;
    }
  });
  return out;
}

void checkJpeg(std::span<const std::byte> data, const std::filesystem::path& path, std::uint64_t memory_bytes) {
  JpegInput input;
  requireRead(readHead(input, data), input, path);
  requireMemory(coefficientBytes(input), memory_bytes, path);
  readRows(input, path, [](int, const std::vector<std::uint8_t>&) {});
}

}  // namespace kiln
