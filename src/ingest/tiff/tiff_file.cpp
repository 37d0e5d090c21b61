// Confines libtiff: libtiff reads through Kiln's own file, its messages become the text of an Error, and its global
// handlers are never called. Tags for viewers (orientation, white zeros) change no values: the first row of the file is
// row 0.
// Source: TIFF 6.0, Adobe 1992; libtiff 4.5's tiffio.h.
#include "ingest/tiff/tiff_file.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <optional>

#include "base/error.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/source/header_text.h"
#include "ingest/tiff/tiff_kind.h"

namespace kiln {
namespace {

// Upper bound for the expansion by any supported codec (Zstandard's runs: 128 KiB from 4 bytes).
constexpr std::uint64_t kMostUnpacking = 40000;

}  // namespace

// libtiff's callbacks. No exception may pass through libtiff's frames, so the first exception is kept. libtiff takes a
// failed or short read for the last page, or drops a tag; checkDirectory() after each directory turns both into errors.
struct TiffFile::Handle {
  File file;
  std::uint64_t at = 0;
  std::string complaint;
  std::exception_ptr thrown;
  /// Position of the first byte that libtiff needed beyond the end of the file.
  std::optional<std::uint64_t> missing;
  TIFF* tiff = nullptr;

  explicit Handle(const std::filesystem::path& path) : file(path) {}
  ~Handle() {
    if (tiff != nullptr) TIFFClose(tiff);
  }

  static Handle& of(void* data) { return *static_cast<Handle*>(data); }

  static tmsize_t read(thandle_t data, void* out, tmsize_t size) {
    Handle& handle = of(data);
    try {
      const std::size_t got = handle.file.readSomeAt(
          handle.at, {static_cast<std::byte*>(out), static_cast<std::size_t>(std::max<tmsize_t>(size, 0))});
      handle.at += got;
      if (got < static_cast<std::size_t>(size) && !handle.missing) handle.missing = handle.at;
      return static_cast<tmsize_t>(got);
    } catch (...) {
      if (!handle.thrown) handle.thrown = std::current_exception();
      // Not -1: libtiff would add the result to a length and clear a byte in front of its buffer.
      return 0;
    }
  }
  static tmsize_t write(thandle_t, void*, tmsize_t) { return -1; }
  static toff_t seek(thandle_t data, toff_t offset, int from) {
    Handle& handle = of(data);
    handle.at = from == SEEK_SET ? offset : (from == SEEK_CUR ? handle.at : handle.file.size()) + offset;
    return handle.at;
  }
  static int close(thandle_t) { return 0; }
  static toff_t size(thandle_t data) { return of(data).file.size(); }
  static int map(thandle_t, void**, toff_t*) { return 0; }
  static void unmap(thandle_t, void*, toff_t) {}

  // Returns non-zero, so that libtiff does not call its global handlers, which print.
  static int error(TIFF*, void* data, const char*, const char* format, va_list arguments) {
    Handle& handle = of(data);
    if (!handle.complaint.empty()) return 1;
    std::array<char, 512> text{};
    std::vsnprintf(text.data(), text.size(), format, arguments);
    handle.complaint = text.data();
    return 1;
  }
  static int warning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

  void begin() {
    complaint.clear();
    missing.reset();
  }

  void rethrow() {
    if (thrown) std::rethrow_exception(std::exchange(thrown, nullptr));
  }

  // requires: a libtiff call failed. throws: the kept exception, else Error kFormat.
  [[noreturn]] void fail(const std::string& place, const std::string& what) {
    rethrow();
    throw Error(ErrorCode::kFormat, file.path(), place,
                complaint.empty() ? what : what + " (libtiff: " + inQuotes(complaint) + ")");
  }

  template <class T>
  T field(std::uint32_t tag, T otherwise) const {
    T value{};
    return TIFFGetFieldDefaulted(tiff, tag, &value) == 1 ? value : otherwise;
  }
};

TiffFile::TiffFile(const std::filesystem::path& path, TiffColours colours)
    : handle_(std::make_unique<Handle>(path)), colours_(colours) {
  using Options = std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)>;
  const Options options(TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), &Handle::error, handle_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), &Handle::warning, handle_.get());
  // c: strips as in the file; D, O: load only the needed entries of the strip table; h: no page yet.
  handle_->tiff = TIFFClientOpenExt(path.c_str(), "rmcDOh", handle_.get(), &Handle::read, &Handle::write, &Handle::seek,
                                    &Handle::close, &Handle::size, &Handle::map, &Handle::unmap, options.get());
  if (handle_->tiff == nullptr) handle_->fail("", "is not a TIFF file, or is damaged at its beginning");
  handle_->rethrow();
  if (!advance()) throw Error(ErrorCode::kFormat, path, "", "a TIFF file without a page that holds an image");
}

TiffFile::~TiffFile() = default;

const File& TiffFile::file() const { return handle_->file; }

std::string TiffFile::description() const {
  const char* text = nullptr;
  return TIFFGetField(handle_->tiff, TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr ? text : "";
}

bool TiffFile::next() { return advance(); }

bool TiffFile::advance() {
  while (true) {
    handle_->begin();
    const bool first = page_.number == 0;
    if (!first && TIFFLastDirectory(handle_->tiff) != 0) return false;
    ++page_.number;
    checkDirectory(TIFFReadDirectory(handle_->tiff) == 1);
    if ((handle_->field<std::uint32_t>(TIFFTAG_SUBFILETYPE, 0) & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0)
      continue;
    readPage();
    return true;
  }
}

void TiffFile::select(int number, std::uint64_t directory) {
  if (page_.directory == directory) return;
  handle_->begin();
  page_.number = number;
  page_.directory = 0;
  checkDirectory(TIFFSetSubDirectory(handle_->tiff, directory) == 1);
  readPage();
}

void TiffFile::checkDirectory(bool is_read) const {
  handle_->rethrow();
  if (handle_->missing) {
    handle_->fail(fmt::format("page {}", page_.number),
                  fmt::format("the TIFF directory needs byte {}, but the file has {} bytes; it is cut short or damaged",
                              *handle_->missing, handle_->file.size()));
  }
  if (!is_read || !handle_->complaint.empty())
    fail("the TIFF directory cannot be read; the file is cut short or damaged");
}

void TiffFile::fail(const std::string& what) const { handle_->fail(fmt::format("page {}", page_.number), what); }

void TiffFile::readPage() {
  const Handle& h = *handle_;
  const TiffKind kind = {h.field<std::uint16_t>(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK),
                         h.field<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL, 1),
                         static_cast<int>(std::min(h.field<std::uint32_t>(TIFFTAG_IMAGEDEPTH, 1), 1u << 30)),
                         h.field<std::uint16_t>(TIFFTAG_COMPRESSION, COMPRESSION_NONE),
                         h.field<std::uint16_t>(TIFFTAG_BITSPERSAMPLE, 1),
                         h.field<std::uint16_t>(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT),
                         h.field<std::uint16_t>(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG)};
  if (const std::string refusal = refusalOf(kind, colours_); !refusal.empty()) {
    throw Error(ErrorCode::kUnsupported, h.file.path(), fmt::format("page {}", page_.number), refusal);
  }
  TiffPage page;
  page.number = page_.number;
  page.directory = TIFFCurrentDirOffset(h.tiff);
  page.type = *storedTypeOf(kind);
  page.samples = kind.samples;
  page.width = h.field<std::uint32_t>(TIFFTAG_IMAGEWIDTH, 0);
  page.height = h.field<std::uint32_t>(TIFFTAG_IMAGELENGTH, 0);
  page.tiled = TIFFIsTiled(h.tiff) != 0;
  page.block_width = page.tiled ? h.field<std::uint32_t>(TIFFTAG_TILEWIDTH, 0) : page.width;
  page.block_height = page.tiled ? h.field<std::uint32_t>(TIFFTAG_TILELENGTH, 0)
                                 : std::min<std::int64_t>(h.field<std::uint32_t>(TIFFTAG_ROWSPERSTRIP, 0), page.height);
  page_ = page;
  checkedBytes({page.width, page.height, 1}, page.type, h.file.path());
  if (page.block_width < 1 || page.block_height < 1) fail("has strips or tiles of no size");
  checkedBytes({page.block_width, page.block_height, 1}, page.type, h.file.path());
  page_.packed = kind.compression != COMPRESSION_NONE || page_.samples > 1 ||
                 h.field<std::uint16_t>(TIFFTAG_FILLORDER, FILLORDER_MSB2LSB) != FILLORDER_MSB2LSB;
  page_.swapped = TIFFIsByteSwapped(h.tiff) != 0 && sizeOf(page_.type) > 1;
  page_.x_resolution = static_cast<double>(h.field<float>(TIFFTAG_XRESOLUTION, 0));
  page_.y_resolution = static_cast<double>(h.field<float>(TIFFTAG_YRESOLUTION, 0));
  page_.resolution_unit = h.field<std::uint16_t>(TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);

  page_.orientation = std::max<int>(h.field<std::uint16_t>(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT), 1);
  page_.smallest_is_white = kind.photometric == PHOTOMETRIC_MINISWHITE;

  const std::uint64_t size = h.file.size(), bytes = page_.bytes();
  if (page_.packed ? bytes / kMostUnpacking > size : bytes > size) {
    fail(fmt::format("is {} x {} of {}, more than the file's {} bytes can hold", page.width, page.height,
                     nameOf(page.type), size));
  }
  // Tests the last block now: a file that is cut short should fail before hours of conversion.
  if (!page_.packed) blockOffset(page_.blocksAcross() * page_.blocksDown() - 1);
}

std::uint64_t TiffFile::rowsBytes(std::int64_t block) const {
  const std::uint64_t pixel = static_cast<std::uint64_t>(page_.samples) * sizeOf(page_.type);
  const std::int64_t height = page_.block_height,
                     rows = page_.tiled ? height : std::min(height, page_.height - block * height);
  return static_cast<std::uint64_t>(rows * page_.block_width) * pixel;
}

std::uint64_t TiffFile::blockOffset(std::int64_t block) const {
  handle_->begin();
  int failed = 0;
  const auto index = static_cast<std::uint32_t>(block);
  const std::uint64_t offset = TIFFGetStrileOffsetWithErr(handle_->tiff, index, &failed);
  const char* const kind = page_.tiled ? "tile" : "strip";
  handle_->rethrow();
  if (failed != 0) fail(fmt::format("the place of {} {} cannot be read", kind, block));
  const std::uint64_t size = handle_->file.size(), needed = rowsBytes(block);
  if (offset == 0 || offset > size || needed > size - offset) {
    fail(fmt::format("{} {} should be {} bytes from byte {}, but the file has {}", kind, block, needed, offset, size));
  }
  return offset;
}

std::vector<std::byte> TiffFile::decodeBlock(std::int64_t block) const {
  handle_->begin();
  int failed = 0;
  const auto index = static_cast<std::uint32_t>(block);
  const char* const kind = page_.tiled ? "tile" : "strip";
  const std::uint64_t stored = TIFFGetStrileByteCountWithErr(handle_->tiff, index, &failed), needed = rowsBytes(block);
  handle_->rethrow();
  if (failed != 0) fail(fmt::format("the length of {} {} cannot be read", kind, block));
  if (stored > handle_->file.size() || needed / kMostUnpacking > stored) {
    fail(fmt::format("{} {} has {} bytes in the file, which cannot be the {} of its pixels", kind, block, stored,
                     needed));
  }
  std::vector<std::byte> out(static_cast<std::size_t>(needed));
  const auto length = static_cast<tmsize_t>(out.size());
  const tmsize_t got = page_.tiled ? TIFFReadEncodedTile(handle_->tiff, index, out.data(), length)
                                   : TIFFReadEncodedStrip(handle_->tiff, index, out.data(), length);
  // Frees libtiff's buffer of packed bytes: there are many open files, and a strip may be a whole slice.
  TIFFReadBufferSetup(handle_->tiff, nullptr, 1024);
  handle_->rethrow();
  if (got != length || !handle_->complaint.empty())
    fail(fmt::format("{} {} cannot be decoded; the file is cut short or damaged", kind, block));
  if (page_.samples > 1) return luminanceOf(std::move(out), page_.type.voxel(), page_.samples);
  return out;
}

}  // namespace kiln
