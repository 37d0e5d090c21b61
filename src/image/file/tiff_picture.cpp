// libtiff calls back for bytes. Exceptions must not pass through libtiff: a callback keeps the exception and fails, and
// the caller of libtiff throws it again.
#include "image/file/tiff_picture.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "image/file/text_block.h"
#include "image/image_memory.h"
#include "image/pixel_rect.h"
#include "image/shown_row.h"
#include "image/srgb.h"

namespace kiln {
namespace {

constexpr int kRowsOfStrip = 16;
constexpr std::uint64_t kClassicBytes = 0xf0000000;  // larger files are BigTIFF
constexpr int kDeflateLevel = 3;

class PictureTiff {
 public:
  using Put = std::function<void(std::uint64_t, std::span<const std::byte>)>;

  PictureTiff(const std::filesystem::path& path, const char* mode, std::span<const std::byte> data, const Put* put)
      : path_(path), data_(data), put_(put), size_(data.size()) {
    const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(),
                                                                                   &TIFFOpenOptionsFree);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), &complain, this);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), &warn, this);
    tiff_ = TIFFClientOpenExt(path.c_str(), mode, this, &read, &write, &seek, &close, &size, nullptr, nullptr,
                              options.get());
    require(tiff_ != nullptr);
  }
  ~PictureTiff() {
    if (tiff_ != nullptr) TIFFClose(tiff_);
  }
  PictureTiff(const PictureTiff&) = delete;
  PictureTiff& operator=(const PictureTiff&) = delete;

  TIFF* get() const { return tiff_; }
  template <class... Values>
  void set(std::uint32_t tag, Values... values) {
    require(TIFFSetField(tiff_, tag, values...) == 1);
  }
  // Throws the error of the last call if the call failed.
  void require(bool done) const {
    if (failure_) std::rethrow_exception(failure_);
    if (done) return;
    throw Error(
        put_ ? ErrorCode::kIo : ErrorCode::kFormat, path_, "",
        fmt::format("{} (libtiff: {})",
                    put_ ? "libtiff cannot encode the picture" : "cannot be decoded; the file is cut short or damaged",
                    complaint_));
  }
  bool complained() const { return complaint_[0] != 0; }
  // Writes the directory.
  void finish() {
    require(TIFFWriteDirectory(tiff_) == 1);
    TIFFClose(std::exchange(tiff_, nullptr));
    require(true);
  }

 private:
  static PictureTiff& of(thandle_t handle) { return *static_cast<PictureTiff*>(handle); }
  static int complain(TIFF*, void* user, const char*, const char* format, va_list arguments) {
    auto& self = *static_cast<PictureTiff*>(user);
    if (self.complaint_[0] == 0) std::vsnprintf(self.complaint_, sizeof self.complaint_, format, arguments);
    return 1;
  }
  // An entry whose value lies beyond the end of the file is a mere warning to libtiff.
  static int warn(TIFF* tiff, void* user, const char* module, const char* format, va_list arguments) {
    return std::string_view(format).starts_with("IO error") ? complain(tiff, user, module, format, arguments) : 1;
  }
  static tmsize_t read(thandle_t handle, void* out, tmsize_t bytes) {
    PictureTiff& self = of(handle);
    if (self.place_ > self.data_.size()) return 0;
    const std::size_t count = std::min(static_cast<std::size_t>(bytes), self.data_.size() - self.place_);
    std::memcpy(out, self.data_.data() + self.place_, count);
    self.place_ += count;
    return static_cast<tmsize_t>(count);
  }
  static tmsize_t write(thandle_t handle, void* bytes, tmsize_t count) noexcept {
    PictureTiff& self = of(handle);
    if (self.put_ == nullptr || self.failure_) return -1;
    try {
      (*self.put_)(self.place_, std::span(static_cast<const std::byte*>(bytes), static_cast<std::size_t>(count)));
    } catch (...) {
      self.failure_ = std::current_exception();
      return -1;
    }
    self.place_ += static_cast<std::size_t>(count);
    self.size_ = std::max(self.size_, self.place_);
    return count;
  }
  static toff_t seek(thandle_t handle, toff_t offset, int whence) {
    PictureTiff& self = of(handle);
    const std::uint64_t from = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? self.place_ : self.size_;
    return self.place_ = from + offset;
  }
  static int close(thandle_t) { return 0; }
  static toff_t size(thandle_t handle) { return of(handle).size_; }

  const std::filesystem::path& path_;
  const std::span<const std::byte> data_;
  const Put* const put_;  // null: reads
  std::uint64_t place_ = 0, size_ = 0;
  std::exception_ptr failure_;
  char complaint_[160] = "";
  TIFF* tiff_ = nullptr;
};

// Converts a row of linear premultiplied light to straight sRGB. NaN becomes 0.
void encodeTiffRow(const float* rgba, std::size_t width, std::uint16_t* out) noexcept {
  for (std::size_t x = 0; x < width; ++x, rgba += 4) out = std::ranges::copy(shownPixel16(rgba), out).out;
}

struct TiffLayout {
  std::uint32_t width = 0, height = 0, rows_of_strip = 0;
};

// Returns false for premultiplied alpha, which other programs write.
bool hasStraightAlpha(const PictureTiff& tiff) {
  std::uint16_t count = 0;
  const std::uint16_t* kinds = nullptr;
  return TIFFGetField(tiff.get(), TIFFTAG_EXTRASAMPLES, &count, &kinds) == 1 && count == 1 &&
         kinds[0] == EXTRASAMPLE_UNASSALPHA;
}

TiffLayout requiredLayout(const PictureTiff& tiff, const std::filesystem::path& path) {
  TiffLayout out;
  std::uint16_t bits = 0, samples = 0, photometric = 0, planes = 0;
  const bool known = TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &out.width) == 1 &&
                     TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &out.height) == 1 &&
                     TIFFGetField(tiff.get(), TIFFTAG_PHOTOMETRIC, &photometric) == 1;
  TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, &samples);
  TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_PLANARCONFIG, &planes);
  TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_ROWSPERSTRIP, &out.rows_of_strip);
  if (!known || bits != 16 || samples != 4 || photometric != PHOTOMETRIC_RGB || !hasStraightAlpha(tiff) ||
      planes != PLANARCONFIG_CONTIG || TIFFIsTiled(tiff.get()) != 0 || out.rows_of_strip > kRowsOfStrip ||
      out.width > 2 * kLargestSide_px || out.height > kLargestSide_px)
    throw Error(ErrorCode::kUnsupported, path, "", "is a TIFF of another program; Kiln reads pictures of its own");
  out.rows_of_strip = std::min(out.rows_of_strip, out.height);
  return out;
}

// Passes the rows of each strip, of 4 numbers a pixel, to `use`.
template <class Use>
void readStrips(PictureTiff& tiff, const TiffLayout& layout, const Use& use) {
  const std::size_t row = std::size_t{4} * layout.width;
  tiff.require(static_cast<std::uint64_t>(TIFFStripSize64(tiff.get())) == 2 * row * layout.rows_of_strip);
  std::vector<std::uint16_t> strip(row * layout.rows_of_strip);
  for (std::uint32_t y = 0; y < layout.height; y += layout.rows_of_strip) {
    const std::uint32_t rows = std::min(layout.rows_of_strip, layout.height - y);
    const auto bytes = static_cast<tmsize_t>(2 * row * rows);
    tiff.require(TIFFReadEncodedStrip(tiff.get(), TIFFComputeStrip(tiff.get(), y, 0), strip.data(), bytes) == bytes);
    use(static_cast<int>(y), static_cast<int>(rows), strip);
  }
}

}  // namespace

bool looksLikeTiff(std::span<const std::byte> data) {
  if (data.size() < 4) return false;
  const auto starts = [&](std::string_view with) { return std::memcmp(data.data(), with.data(), with.size()) == 0; };
  return starts({"II*\0", 4}) || starts({"II+\0", 4}) || starts({"MM\0*", 4}) || starts({"MM\0+", 4});
}

void encodeTiff(ImageRows& rows, const std::filesystem::path& path, const std::map<std::string, std::string>& text,
                const std::function<void(std::uint64_t, std::span<const std::byte>)>& put) {
  const auto width = static_cast<std::size_t>(rows.width);
  const bool big = 8 * width * static_cast<std::size_t>(rows.height) > kClassicBytes;
  PictureTiff tiff(path, big ? "wl8" : "wl", {}, &put);
  tiff.set(TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(rows.width));
  tiff.set(TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(rows.height));
  tiff.set(TIFFTAG_BITSPERSAMPLE, 16);
  tiff.set(TIFFTAG_SAMPLESPERPIXEL, 4);
  tiff.set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  const std::uint16_t alpha = EXTRASAMPLE_UNASSALPHA;
  tiff.set(TIFFTAG_EXTRASAMPLES, 1, &alpha);
  tiff.set(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  tiff.set(TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  tiff.set(TIFFTAG_ROWSPERSTRIP, static_cast<std::uint32_t>(kRowsOfStrip));
  tiff.set(TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  tiff.set(TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
  tiff.set(TIFFTAG_ZIPQUALITY, kDeflateLevel);
  if (!text.empty()) tiff.set(TIFFTAG_IMAGEDESCRIPTION, textBlock(text).c_str());
  std::vector<std::uint16_t> strip(4 * width * kRowsOfStrip);
  std::uint32_t number = 0;
  for (int y = 0; y < rows.height; y += kRowsOfStrip, ++number) {
    const int count = std::min(kRowsOfStrip, rows.height - y);
    for (int done = 0; done < count;) {
      const ImageRows::Band band = rows.bandAt(y + done);
      const int from_band = std::min(count - done, band.end() - (y + done));
      parallelFor(static_cast<std::size_t>(from_band), [&](std::size_t i) {
        const int row = y + done + static_cast<int>(i);
        encodeTiffRow(band.image->pixel(0, row - band.first_row), width,
                      strip.data() + 4 * width * static_cast<std::size_t>(row - y));
      });
      done += from_band;
    }
    const auto bytes = static_cast<tmsize_t>(8 * width * static_cast<std::size_t>(count));
    tiff.require(TIFFWriteEncodedStrip(tiff.get(), number, strip.data(), bytes) == bytes);
  }
  tiff.finish();
}

std::map<std::string, std::string> decodeTiffText(std::span<const std::byte> data, const std::filesystem::path& path) {
  const PictureTiff tiff(path, "rm", data, nullptr);
  const char* description = nullptr;
  // The directory is behind the pixels: in a shortened file the description is unreadable.
  if (TIFFGetField(tiff.get(), TIFFTAG_IMAGEDESCRIPTION, &description) != 1) {
    tiff.require(!tiff.complained());
    return {};
  }
  return textsOfBlock(description).value_or(std::map<std::string, std::string>());
}

Image decodeTiff(std::span<const std::byte> data, const std::filesystem::path& path, std::uint64_t memory_bytes) {
  PictureTiff tiff(path, "rm", data, nullptr);
  const TiffLayout layout = requiredLayout(tiff, path);
  requireMemory(std::uint64_t{layout.width} * layout.height * 4 * sizeof(float), memory_bytes, path);
  Image out(static_cast<int>(layout.width), static_cast<int>(layout.height));
  std::vector<double> light(65536);
  for (std::size_t v = 0; v < light.size(); ++v) light[v] = linearFromSrgb(static_cast<double>(v) / 65535.0);
  readStrips(tiff, layout, [&](int y, int rows, const std::vector<std::uint16_t>& strip) {
    float* pixel = out.pixel(0, y);
    const std::size_t count = static_cast<std::size_t>(rows) * layout.width;
    for (std::size_t i = 0; i < count; ++i, pixel += 4) {
      const double alpha = strip[4 * i + 3] / 65535.0;
      for (std::size_t channel = 0; channel < 3; ++channel)
        pixel[channel] = static_cast<float>(alpha * light[strip[4 * i + channel]]);
      pixel[3] = static_cast<float>(alpha);
    }
  });
  return out;
}

void checkTiff(std::span<const std::byte> data, const std::filesystem::path& path) {
  PictureTiff tiff(path, "rm", data, nullptr);
  readStrips(tiff, requiredLayout(tiff, path), [](int, int, const std::vector<std::uint16_t>&) {});
}

}  // namespace kiln
