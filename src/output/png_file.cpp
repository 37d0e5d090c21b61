// libpng leaves its own functions by longjmp where something is wrong. A jump over a C++ object with a destructor is
// undefined, so everything that libpng is asked for happens in small noexcept functions whose locals are plain data;
// what they fill is owned by their callers.
#include "output/png_file.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "base/pixel_rect.h"
#include "base/srgb.h"

namespace kiln {
namespace {

// Deflate shrinks no further than 1 : 1032, so a header that promises more than this lies.
constexpr std::uint64_t kLargestRatio = 1040;

struct Messages {
  char text[160] = "unknown failure";
};

[[noreturn]] void onError(png_structp png, png_const_charp message) {
  std::strncpy(static_cast<Messages*>(png_get_error_ptr(png))->text, message, sizeof(Messages::text) - 1);
  png_longjmp(png, 1);
}
void onWarning(png_structp, png_const_charp) {}

struct Writer {
  Messages messages;
  std::vector<std::byte> out;
  png_structp png = nullptr;
  png_infop info = nullptr;
  ~Writer() { png_destroy_write_struct(&png, &info); }
};

struct Reader {
  Messages messages;
  std::span<const std::byte> data;
  std::size_t place = 0;
  png_structp png = nullptr;
  png_infop info = nullptr;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
};

bool append(std::vector<std::byte>& out, const png_byte* data, std::size_t count) noexcept {
  try {
    const auto* bytes = reinterpret_cast<const std::byte*>(data);
    out.insert(out.end(), bytes, bytes + count);
    return true;
  } catch (...) {
    return false;
  }
}

void onWrite(png_structp png, png_bytep data, png_size_t count) {
  if (!append(static_cast<Writer*>(png_get_io_ptr(png))->out, data, count)) png_error(png, "out of memory");
}
void onFlush(png_structp) {}

void onRead(png_structp png, png_bytep out, png_size_t count) {
  auto* reader = static_cast<Reader*>(png_get_io_ptr(png));
  if (count > reader->data.size() - reader->place) png_error(png, "the file ends too early");
  std::memcpy(out, reader->data.data() + reader->place, count);
  reader->place += count;
}

// A sample of 16 bits, big-endian; what is behind it.
png_byte* putSixteen(double v, png_byte* out) noexcept {
  const auto sample = static_cast<unsigned>(v * 65535 + 0.5);
  *out++ = static_cast<png_byte>(sample >> 8);
  *out++ = static_cast<png_byte>(sample & 255);
  return out;
}

// The row's pixels of linear premultiplied light as straight sRGB. shape: 4 samples of `bits` a pixel, big-endian. NaN
// becomes 0.
void encodeRow(const Image& image, int y, int bits, png_byte* out) noexcept {
  const SrgbBytes& bytes = SrgbBytes::all();
  for (int x = 0; x < image.width; ++x) {
    const float* const rgba = image.pixel(x, y);
    const double alpha = rgba[3] > 0 ? std::min<double>(rgba[3], 1) : 0;
    for (int channel = 0; channel < 3; ++channel) {
      const double straight = alpha > 0 ? rgba[channel] / alpha : 0;
      if (bits == 8)
        *out++ = bytes.of(straight);
      else
        out = putSixteen(straight > 0 ? srgbFromLinear(std::min(straight, 1.0)) : 0, out);
    }
    if (bits == 8)
      *out++ = static_cast<png_byte>(alpha * 255 + 0.5);
    else
      out = putSixteen(alpha, out);
  }
}

// How rows are foretold and what is left is deflated: three times as fast as the libraries' own choices, and files as
// large within some per cent (ARCHITECTURE.md has the figures). Of 16 bits the lower ones are as good as noise, in
// which only runs are worth a search.
void setCompression(png_structp png, int bits) noexcept {
  png_set_filter(png, PNG_FILTER_TYPE_BASE, bits == 16 ? PNG_FILTER_PAETH : PNG_FILTER_UP);
  png_set_compression_strategy(png, bits == 16 ? Z_RLE : Z_FILTERED);
  png_set_compression_level(png, 3);
}

// Each of these returns false where libpng refused; the message is in the writer.
bool writeHead(png_structp png, png_infop info, std::span<png_text> texts, const Image& image, int bits) noexcept {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), bits,
               PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  setCompression(png, bits);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  if (!texts.empty()) png_set_text(png, info, texts.data(), static_cast<int>(texts.size()));
  png_write_info(png, info);
  return true;
}

bool writeRows(png_structp png, const png_byte* rows, int count, std::size_t row_bytes) noexcept {
  if (setjmp(png_jmpbuf(png))) return false;
  for (int y = 0; y < count; ++y) png_write_row(png, rows + static_cast<std::size_t>(y) * row_bytes);
  return true;
}

bool writeEnd(png_structp png, png_infop info) noexcept {
  if (setjmp(png_jmpbuf(png))) return false;
  png_write_end(png, info);
  return true;
}

struct Layout {
  png_uint_32 width = 0, height = 0;
  std::size_t stored_row_bytes = 0;  // as in the file
  std::size_t row_bytes = 0;         // as RGBA of 8 or 16 bits
  int bits = 8, passes = 1;
};

bool readLayout(png_structp png, png_infop info, Layout* layout) noexcept {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_user_limits(png, 2 * kLargestSide_px, kLargestSide_px);  // both eyes of a pair, one beside the other
  png_read_info(png, info);
  layout->width = png_get_image_width(png, info);
  layout->height = png_get_image_height(png, info);
  layout->stored_row_bytes = png_get_rowbytes(png, info);
  png_set_expand(png);  // palettes, fewer than 8 bits, transparent colours
  png_set_gray_to_rgb(png);
  layout->bits = png_get_bit_depth(png, info) == 16 ? 16 : 8;
  png_set_add_alpha(png, 0xffff, PNG_FILLER_AFTER);
  layout->passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  layout->row_bytes = png_get_rowbytes(png, info);
  return true;
}

bool readAll(png_structp png, const Layout& layout, png_byte* pixels) noexcept {
  if (setjmp(png_jmpbuf(png))) return false;
  for (int pass = 0; pass < layout.passes; ++pass) {
    for (png_uint_32 y = 0; y < layout.height; ++y) png_read_row(png, pixels + y * layout.row_bytes, nullptr);
  }
  png_read_end(png, nullptr);
  return true;
}

// libpng reads these; it does not write to them.
std::vector<png_text> pngTexts(const std::map<std::string, std::string>& text) {
  static char nothing[] = "";
  std::vector<png_text> out;
  for (const auto& [key, value] : text) {
    png_text entry{};
    entry.compression = value.size() < 200 ? PNG_ITXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_zTXt;
    entry.key = const_cast<char*>(key.c_str());
    entry.text = const_cast<char*>(value.c_str());
    entry.itxt_length = value.size();
    entry.lang = entry.lang_key = nothing;
    out.push_back(entry);
  }
  return out;
}

Image imageFrom(const Layout& layout, const std::vector<png_byte>& samples) {
  const std::size_t largest = layout.bits == 16 ? 65535 : 255;
  std::vector<float> linear(largest + 1);
  for (std::size_t v = 0; v <= largest; ++v) {
    linear[v] = static_cast<float>(linearFromSrgb(static_cast<double>(v) / static_cast<double>(largest)));
  }
  Image image(static_cast<int>(layout.width), static_cast<int>(layout.height));
  const auto sample = [&](std::size_t i) -> std::size_t {
    return layout.bits == 16 ? samples[2 * i] * std::size_t{256} + samples[2 * i + 1] : samples[i];
  };
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    const float alpha = static_cast<float>(sample(i + 3)) / static_cast<float>(largest);
    for (std::size_t channel = 0; channel < 3; ++channel) image.rgba[i + channel] = linear[sample(i + channel)] * alpha;
    image.rgba[i + 3] = alpha;
  }
  return image;
}

Error notPng(const std::filesystem::path& path, const std::string& why) {
  return Error(ErrorCode::kFormat, path, "", "cannot be read as PNG: " + why);
}

// Reads all in front of the pixels. throws: Error kFormat.
Layout begin(Reader& reader, std::span<const std::byte> data, const std::filesystem::path& path) {
  reader.data = data;
  reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader.messages, onError, onWarning);
  if (reader.png) reader.info = png_create_info_struct(reader.png);
  if (!reader.info) throw notPng(path, "libpng could not be started");
  png_set_read_fn(reader.png, &reader, onRead);
  Layout layout;
  if (!readLayout(reader.png, reader.info, &layout)) throw notPng(path, reader.messages.text);
  return layout;
}

}  // namespace

bool looksLikePng(std::span<const std::byte> data) {
  return data.size() >= 8 && png_sig_cmp(reinterpret_cast<png_const_bytep>(data.data()), 0, 8) == 0;
}

std::vector<std::byte> encodePng(const Image& image, int bits, const std::filesystem::path& path,
                                 const std::map<std::string, std::string>& text) {
  Writer writer;
  writer.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &writer.messages, onError, onWarning);
  if (writer.png) writer.info = png_create_info_struct(writer.png);
  if (!writer.info) throw Error(ErrorCode::kIo, path, "", "libpng could not be started");
  png_set_write_fn(writer.png, &writer, onWrite, onFlush);
  const auto require = [&](bool done) {
    if (!done)
      throw Error(ErrorCode::kIo, path, "", std::string("libpng cannot write this picture: ") + writer.messages.text);
  };
  std::vector<png_text> texts = pngTexts(text);
  require(writeHead(writer.png, writer.info, texts, image, bits));
  // Some rows at a time, of which several threads convert one each.
  constexpr int kRows = 64;
  const auto pixel_bytes = static_cast<std::size_t>(bits / 2);
  const std::size_t row_bytes = static_cast<std::size_t>(image.width) * pixel_bytes;
  std::vector<png_byte> samples(row_bytes * static_cast<std::size_t>(std::min(kRows, image.height)));
  for (int y = 0; y < image.height; y += kRows) {
    const int rows = std::min(kRows, image.height - y);
    parallelFor(static_cast<std::size_t>(rows), [&](std::size_t i) {
      encodeRow(image, y + static_cast<int>(i), bits, samples.data() + i * row_bytes);
    });
    require(writeRows(writer.png, samples.data(), rows, row_bytes));
  }
  require(writeEnd(writer.png, writer.info));
  return std::move(writer.out);
}

std::map<std::string, std::string> decodePngText(std::span<const std::byte> data, const std::filesystem::path& path) {
  Reader reader;
  begin(reader, data, path);
  png_textp texts = nullptr;
  const int count = png_get_text(reader.png, reader.info, &texts, nullptr);
  std::map<std::string, std::string> out;
  for (int i = 0; i < count; ++i) out[texts[i].key] = texts[i].text;
  return out;
}

Image decodePng(std::span<const std::byte> data, const std::filesystem::path& path) {
  Reader reader;
  const Layout layout = begin(reader, data, path);
  const auto refuse = [&](const std::string& why) { return notPng(path, why); };
  if (std::uint64_t{layout.stored_row_bytes} * layout.height > kLargestRatio * data.size()) {
    throw refuse("its header promises " + std::to_string(layout.width) + "x" + std::to_string(layout.height) +
                 " pixels, more than a file of " + std::to_string(data.size()) + " bytes can hold");
  }
  std::vector<png_byte> samples(layout.row_bytes * layout.height);
  if (!readAll(reader.png, layout, samples.data())) throw refuse(reader.messages.text);
  return imageFrom(layout, samples);
}

}  // namespace kiln
