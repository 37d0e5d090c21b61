// libpng reports errors by longjmp, which must not pass over C++ objects with destructors: all of its calls are in
// small functions whose locals are plain data. The header is parsed here, so libpng gets files of known kinds and sizes
// only. Source: Portable Network Graphics, w3.org/TR/png.
#include <fmt/format.h>
#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstring>

#include "base/error.h"
#include "base/file/file.h"
#include "ingest/bytes/header_bytes.h"
#include "ingest/pictures/picture_slice.h"

namespace kiln {
namespace {

// Deflate compresses at most 1032 : 1.
constexpr std::uint64_t kMostOfDeflate = 1040;
// Signature, length and name of the first chunk, then width, height, depth and colour type.
constexpr std::size_t kStartBytes = 26;

struct PngMemory {
  std::span<const std::byte> data;
  std::size_t place = 0;
  char complaint[160] = "";
};

[[noreturn]] void onPngError(png_structp png, png_const_charp message) {
  std::strncpy(static_cast<PngMemory*>(png_get_error_ptr(png))->complaint, message, sizeof(PngMemory::complaint) - 1);
  png_longjmp(png, 1);
}
void onPngWarning(png_structp, png_const_charp) {}

void onPngRead(png_structp png, png_bytep out, png_size_t count) {
  auto* const memory = static_cast<PngMemory*>(png_get_io_ptr(png));
  if (count > memory->data.size() - memory->place) png_error(png, "the file ends too early");
  std::memcpy(out, memory->data.data() + memory->place, count);
  memory->place += count;
}

// Decodes rows of `row_bytes` bytes to `out`. Returns false if libpng found an error.
bool decodeRows(png_structp png, png_infop info, png_bytep out, std::size_t row_bytes, std::uint32_t height) noexcept {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_read_info(png, info);
  png_set_packing(png);
  if (std::endian::native == std::endian::little) png_set_swap(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != row_bytes) png_error(png, "its rows have another length");
  for (int pass = 0; pass < passes; ++pass)
    for (std::uint32_t y = 0; y < height; ++y) png_read_row(png, out + y * row_bytes, nullptr);
  png_read_end(png, info);
  return true;
}

}  // namespace

PictureHeader readPngHeader(const std::filesystem::path& path) {
  const File file(path);
  std::vector<std::byte> bytes(kStartBytes);
  file.readAt(0, bytes);
  HeaderBytes start(path, std::move(bytes));
  start.setBigEndian(true);
  if (!start.holds(12, "IHDR")) start.fail("", "is no PNG file, or is damaged");
  const int depth = start.get<std::uint8_t>(24), colour = start.get<std::uint8_t>(25);
  if (colour == PNG_COLOR_TYPE_GRAY_ALPHA) start.refuse("holds grey and alpha, not one value a pixel");
  if (colour != PNG_COLOR_TYPE_GRAY)
    start.refuse(colour == PNG_COLOR_TYPE_PALETTE ? "holds indices into a palette of colours, not one value a pixel"
                                                  : "holds RGB colours, not one value a pixel");
  PictureSlice out;
  out.width = start.get<std::uint32_t>(16), out.height = start.get<std::uint32_t>(20);
  out.type = depth == 16 ? VoxelType::u16 : VoxelType::u8;
  if (out.width < 1 || out.height < 1 || out.width > INT32_MAX || out.height > INT32_MAX)
    start.fail("", fmt::format("has {} x {} pixels", out.width, out.height));
  // Packed bits expand to bytes, eight times at most.
  if (out.bytes() / (8 * kMostOfDeflate) > file.size())
    start.fail("", fmt::format("is {} x {}, more than its {} bytes can hold", out.width, out.height, file.size()));
  return {out, file.size()};
}

std::vector<std::byte> decodePng(const std::filesystem::path& path, const PictureSlice& slice,
                                 std::uint64_t limit_bytes) {
  const std::vector<std::byte> data = readFile(path, limit_bytes);
  PngMemory memory;
  memory.data = data;
  std::vector<std::byte> out(static_cast<std::size_t>(slice.bytes()));
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &memory, &onPngError, &onPngWarning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  bool decoded = false;
  if (info != nullptr) {
    png_set_read_fn(png, &memory, &onPngRead);
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    decoded = decodeRows(png, info, reinterpret_cast<png_bytep>(out.data()),
                         static_cast<std::size_t>(slice.width) * sizeOf(slice.type),
                         static_cast<std::uint32_t>(slice.height));
  }
  png_destroy_read_struct(&png, &info, nullptr);
  if (!decoded)
    throw Error(ErrorCode::kFormat, path, "",
                fmt::format("cannot be decoded; the file is cut short or damaged (libpng: {})", memory.complaint));
  return out;
}

}  // namespace kiln
