// libpng reports errors by longjmp. A jump over a C++ object with a destructor is undefined behaviour.
// All calls of libpng are therefore in small noexcept functions whose locals are plain data; callers own the filled
// buffers.
#include "image/file/png_file.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <exception>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "image/image_memory.h"
#include "image/pixel_rect.h"
#include "image/srgb.h"

namespace kiln {
namespace {

// Deflate compresses at most 1032 : 1; a header that claims a larger ratio is damaged.
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
  const std::function<void(std::span<const std::byte>)>* put = nullptr;
  std::exception_ptr failure;  // exception of `put`
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

bool put(Writer& writer, const png_byte* data, std::size_t count) noexcept {
  try {
    (*writer.put)(std::as_bytes(std::span(data, count)));
    return true;
  } catch (...) {
    writer.failure = std::current_exception();
    return false;
  }
}

void onWrite(png_structp png, png_bytep data, png_size_t count) {
  if (!put(*static_cast<Writer*>(png_get_io_ptr(png)), data, count)) png_error(png, "its bytes are not taken");
}
void onFlush(png_structp) {}

void onRead(png_structp png, png_bytep out, png_size_t count) {
  auto* reader = static_cast<Reader*>(png_get_io_ptr(png));
  if (count > reader->data.size() - reader->place) png_error(png, "the file ends too early");
  std::memcpy(out, reader->data.data() + reader->place, count);
  reader->place += count;
}

// Filter and deflate strategy: three times as fast as the libraries' defaults, with files equally large within some per
// cent (figures: image/file/decisions/compression.md). The lower byte of 16-bit samples is close to noise, in which
// only runs are worth a search.
void setCompression(png_structp png, int bits) noexcept {
  png_set_filter(png, PNG_FILTER_TYPE_BASE, bits == 16 ? PNG_FILTER_PAETH : PNG_FILTER_UP);
  png_set_compression_strategy(png, bits == 16 ? Z_RLE : Z_FILTERED);
  png_set_compression_level(png, 3);
}

// The functions below return false if libpng failed; the message is in the writer.
bool writeHead(png_structp png, png_infop info, std::span<png_text> texts, int width, int height, int bits) noexcept {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits,
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

struct PngLayout {
  png_uint_32 width = 0, height = 0;
  std::size_t stored_row_bytes = 0;  // as in the file
  std::size_t row_bytes = 0;         // as RGBA of 8 or 16 bits
  int bits = 8, passes = 1;
};

bool readLayout(png_structp png, png_infop info, PngLayout* layout) noexcept {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_user_limits(png, 2 * kLargestSide_px, kLargestSide_px);  // side-by-side stereo pictures
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

bool readRow(png_structp png, png_byte* row) noexcept {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_row(png, row, nullptr);
  return true;
}

bool readEnd(png_structp png) noexcept {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_end(png, nullptr);
  return true;
}

// libpng only reads the texts.
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

// Converts samples of 8 or 16 bits to linear premultiplied light.
class RowConverter {
 public:
  explicit RowConverter(int bits) : bits_(bits), linear_((std::size_t{1} << bits)) {
    for (std::size_t v = 0; v < linear_.size(); ++v)
      linear_[v] = static_cast<float>(linearFromSrgb(static_cast<double>(v) / static_cast<double>(linear_.size() - 1)));
  }
  void convert(const png_byte* row, int width, float* rgba) const {
    const auto sample = [&](std::size_t i) -> std::size_t {
      return bits_ == 16 ? row[2 * i] * std::size_t{256} + row[2 * i + 1] : row[i];
    };
    const auto largest = static_cast<float>(linear_.size() - 1);
    for (std::size_t i = 0; i < static_cast<std::size_t>(width) * 4; i += 4) {
      const float alpha = static_cast<float>(sample(i + 3)) / largest;
      for (std::size_t channel = 0; channel < 3; ++channel) rgba[i + channel] = linear_[sample(i + channel)] * alpha;
      rgba[i + 3] = alpha;
    }
  }

 private:
  int bits_;
  std::vector<float> linear_;
};

Error notPng(const std::filesystem::path& path, const std::string& why) {
  return Error(ErrorCode::kFormat, path, "", "cannot be read as PNG: " + why);
}

// Chunks in front of the pixels that libpng unpacks, each within its memory limit. unit: bytes. Source: PNG 1.2, 3.2.
struct Head {
  std::uint64_t packed_chunks = 0;  // profiles and compressed texts
  std::uint64_t texts = 0;          // compressed or not
  std::uint64_t longest = 0;        // longest chunk
  std::uint64_t bytes = 0;          // up to the first chunk of pixels
};

// throws: Error kFormat if a chunk exceeds the file.
Head readHead(std::span<const std::byte> data, const std::filesystem::path& path) {
  constexpr std::size_t kSignature = 8, kFrame = 12;  // length, type and checksum of a chunk
  Head out;
  for (std::size_t at = kSignature; data.size() - at >= kFrame;) {
    std::uint64_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | std::to_integer<std::uint64_t>(data[at + i]);
    const std::string_view type(reinterpret_cast<const char*>(&data[at + 4]), 4);
    out.bytes = at;
    if (type == "IDAT") break;
    if (length > data.size() - at - kFrame)
      throw notPng(path, "its chunk '" + std::string(type) + "' goes beyond the file");
    if (type == "zTXt" || type == "iTXt" || type == "iCCP") ++out.packed_chunks;
    if (type == "zTXt" || type == "iTXt" || type == "tEXt") ++out.texts;
    out.longest = std::max(out.longest, length);
    at += kFrame + length;
  }
  return out;
}

// Reads everything in front of the pixels. throws: Error kFormat, kBudget.
PngLayout begin(Reader& reader, std::span<const std::byte> data, const std::filesystem::path& path,
                std::uint64_t memory_bytes) {
  // A text exists in memory stored, unpacked, in libpng's copy and in Kiln's copy.
  constexpr std::uint64_t kCopies = 4, kMostChunkBytes = std::uint64_t{1} << 28;
  if (!looksLikePng(data)) throw notPng(path, "it does not begin as a PNG does");
  const Head head = readHead(data, path);
  requireMemory(kCopies * head.bytes, memory_bytes, path);
  // The limit covers the longest stored chunk; libpng refuses longer chunks and skips chunks that unpack beyond the
  // limit.
  const std::uint64_t share =
      (memory_bytes - kCopies * head.bytes) / (kCopies * std::max<std::uint64_t>(head.packed_chunks, 1));
  const std::uint64_t each = std::max(std::clamp<std::uint64_t>(share, 1, kMostChunkBytes), head.longest + 1);
  reader.data = data;
  reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader.messages, onError, onWarning);
  if (reader.png) reader.info = png_create_info_struct(reader.png);
  if (!reader.info) throw notPng(path, "libpng could not be started");
  png_set_read_fn(reader.png, &reader, onRead);
  png_set_chunk_malloc_max(reader.png, static_cast<png_alloc_size_t>(each));
  PngLayout layout;
  if (!readLayout(reader.png, reader.info, &layout)) throw notPng(path, reader.messages.text);
  return layout;
}

// Calls f(y, samples) for each row from top to bottom; RGBA of layout.bits each. Interlaced files are held in memory
// whole.
template <class F>
void forEachRow(Reader& reader, const PngLayout& layout, const std::filesystem::path& path, F&& f) {
  const bool interlaced = layout.passes > 1;
  std::vector<png_byte> samples(layout.row_bytes * (interlaced ? layout.height : 1));
  for (int pass = 0; pass < layout.passes; ++pass) {
    for (png_uint_32 y = 0; y < layout.height; ++y) {
      png_byte* const row = samples.data() + (interlaced ? y * layout.row_bytes : 0);
      if (!readRow(reader.png, row)) throw notPng(path, reader.messages.text);
      if (pass + 1 == layout.passes) f(y, row);
    }
  }
  if (!readEnd(reader.png)) throw notPng(path, reader.messages.text);
}

// Memory of the samples that forEachRow holds. unit: bytes.
std::uint64_t bytesOfRows(const PngLayout& layout) {
  return std::uint64_t{layout.row_bytes} * (layout.passes > 1 ? layout.height : 1);
}

void requirePlausible(const PngLayout& layout, std::span<const std::byte> data, const std::filesystem::path& path) {
  if (std::uint64_t{layout.stored_row_bytes} * layout.height <= kLargestRatio * data.size()) return;
  throw notPng(path, "its header promises " + std::to_string(layout.width) + "x" + std::to_string(layout.height) +
                         " pixels, more than a file of " + std::to_string(data.size()) + " bytes can hold");
}

}  // namespace

bool looksLikePng(std::span<const std::byte> data) {
  return data.size() >= 8 && png_sig_cmp(reinterpret_cast<png_const_bytep>(data.data()), 0, 8) == 0;
}

std::vector<std::byte> encodePng(const Image& image, int bits, const std::filesystem::path& path,
                                 const std::map<std::string, std::string>& text, const PatternPlace& place) {
  std::vector<std::byte> out;
  RowsOfImage rows(image);
  encodePng(rows, bits, path, text, place,
            [&](std::span<const std::byte> bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); });
  return out;
}

void encodePng(ImageRows& picture, int bits, const std::filesystem::path& path,
               const std::map<std::string, std::string>& text, const PatternPlace& place,
               const std::function<void(std::span<const std::byte>)>& put) {
  Writer writer;
  writer.put = &put;
  writer.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &writer.messages, onError, onWarning);
  if (writer.png) writer.info = png_create_info_struct(writer.png);
  if (!writer.info) throw Error(ErrorCode::kIo, path, "", "libpng could not be started");
  png_set_write_fn(writer.png, &writer, onWrite, onFlush);
  const auto require = [&](bool done) {
    if (writer.failure) std::rethrow_exception(writer.failure);
    if (!done)
      throw Error(ErrorCode::kIo, path, "", std::string("libpng cannot write this picture: ") + writer.messages.text);
  };
  std::vector<png_text> texts = pngTexts(text);
  require(writeHead(writer.png, writer.info, texts, picture.width, picture.height, bits));
  // Rows converted in parallel at a time.
  constexpr int kRows = 64;
  const auto pixel_bytes = static_cast<std::size_t>(bits / 2);
  const std::size_t row_bytes = static_cast<std::size_t>(picture.width) * pixel_bytes;
  std::vector<png_byte> samples(row_bytes * static_cast<std::size_t>(std::min(kRows, picture.height)));
  for (int y = 0; y < picture.height;) {
    const ImageRows::Band band = picture.bandAt(y);
    const int rows = std::min(kRows, band.end() - y);
    parallelFor(static_cast<std::size_t>(rows), [&](std::size_t i) {
      const int row = y + static_cast<int>(i);
      encodeShownRow(*band.image, row - band.first_row, row, place, bits, samples.data() + i * row_bytes);
    });
    require(writeRows(writer.png, samples.data(), rows, row_bytes));
    y += rows;
  }
  require(writeEnd(writer.png, writer.info));
}

std::map<std::string, std::string> decodePngText(std::span<const std::byte> data, const std::filesystem::path& path,
                                                 std::uint64_t memory_bytes) {
  Reader reader;
  begin(reader, data, path, memory_bytes);
  png_textp texts = nullptr;
  const int count = png_get_text(reader.png, reader.info, &texts, nullptr);
  if (const std::uint64_t all = readHead(data, path).texts; static_cast<std::uint64_t>(count) < all)
    throw Error(ErrorCode::kBudget, path, "",
                std::to_string(all - static_cast<std::uint64_t>(count)) + " of its " + std::to_string(all) +
                    " texts are damaged, or unpack to more than the memory that is left; give more by --memory");
  std::map<std::string, std::string> out;
  for (int i = 0; i < count; ++i) out[texts[i].key] = texts[i].text;
  return out;
}

Image decodePng(std::span<const std::byte> data, const std::filesystem::path& path, std::uint64_t memory_bytes) {
  Reader reader;
  const PngLayout layout = begin(reader, data, path, memory_bytes);
  requirePlausible(layout, data, path);
  const std::uint64_t pixels = std::uint64_t{layout.width} * layout.height;
  requireMemory(pixels * 4 * sizeof(float) + bytesOfRows(layout), memory_bytes, path);
  const RowConverter converter(layout.bits);
  Image image(static_cast<int>(layout.width), static_cast<int>(layout.height));
  forEachRow(reader, layout, path, [&](png_uint_32 y, const png_byte* row) {
    converter.convert(row, image.width, image.pixel(0, static_cast<int>(y)));
  });
  return image;
}

void checkPng(std::span<const std::byte> data, const std::filesystem::path& path, std::uint64_t memory_bytes) {
  Reader reader;
  const PngLayout layout = begin(reader, data, path, memory_bytes);
  requirePlausible(layout, data, path);
  requireMemory(bytesOfRows(layout), memory_bytes, path);
  forEachRow(reader, layout, path, [](png_uint_32, const png_byte*) {});
}

}  // namespace kiln
