// Supported pages have one value per pixel of 8 to 64 bits, in a common codec of libtiff. Values are taken as stored,
// even if zero means white: here they are measurements, not greys, and a note reports the fact.
#include "ingest/tiff/tiff_kind.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <type_traits>

namespace kiln {
namespace {

struct Compression {
  int code;
  const char* name;
  bool read;
};
// Codecs marked false are untested, or occur only with unsupported pixel formats.
constexpr Compression kCompressions[] = {
    {COMPRESSION_NONE, "none", true},
    {COMPRESSION_LZW, "LZW", true},
    {COMPRESSION_ADOBE_DEFLATE, "Deflate", true},
    {COMPRESSION_DEFLATE, "Deflate", true},
    {COMPRESSION_PACKBITS, "PackBits", true},
    {COMPRESSION_JPEG, "JPEG", true},
    {COMPRESSION_LZMA, "LZMA", true},
    {COMPRESSION_ZSTD, "Zstandard", true},
    {COMPRESSION_LERC, "LERC", true},
    {COMPRESSION_OJPEG, "JPEG, the old style", false},
    {COMPRESSION_CCITTRLE, "CCITT run length", false},
    {COMPRESSION_CCITTFAX3, "CCITT fax 3", false},
    {COMPRESSION_CCITTFAX4, "CCITT fax 4", false},
    {COMPRESSION_JP2000, "JPEG 2000", false},
    {COMPRESSION_WEBP, "WebP", false},
    {COMPRESSION_JXL, "JPEG XL", false},
    {COMPRESSION_SGILOG, "SGI LogL", false},
    {COMPRESSION_PIXARLOG, "PixarLog", false},
};

const char* colourName(int photometric) {
  switch (photometric) {
    case PHOTOMETRIC_RGB:
      return "RGB colours";
    case PHOTOMETRIC_PALETTE:
      return "indices into a palette of colours";
    case PHOTOMETRIC_SEPARATED:
      return "CMYK inks";
    case PHOTOMETRIC_YCBCR:
      return "YCbCr colours";
    case PHOTOMETRIC_CIELAB:
    case PHOTOMETRIC_ICCLAB:
    case PHOTOMETRIC_ITULAB:
      return "L*a*b* colours";
    case PHOTOMETRIC_CFA:
      return "a camera's colour mosaic";
    case PHOTOMETRIC_LOGL:
    case PHOTOMETRIC_LOGLUV:
      return "logarithmic luminances";
    default:
      return nullptr;
  }
}

const char* formatName(int format) {
  switch (format) {
    case SAMPLEFORMAT_INT:
      return "signed integers";
    case SAMPLEFORMAT_IEEEFP:
      return "floating-point numbers";
    case SAMPLEFORMAT_COMPLEXINT:
    case SAMPLEFORMAT_COMPLEXIEEEFP:
      return "complex numbers";
    default:
      return "integers";
  }
}

}  // namespace

std::optional<StoredType> storedTypeOf(const TiffKind& kind) {
  const bool plain = kind.sample_format == SAMPLEFORMAT_UINT || kind.sample_format == SAMPLEFORMAT_VOID;
  const bool is_signed = kind.sample_format == SAMPLEFORMAT_INT, real = kind.sample_format == SAMPLEFORMAT_IEEEFP;
  if (kind.bits == 8 && (plain || is_signed)) return plain ? VoxelType::u8 : VoxelType::i8;
  if (kind.bits == 16 && (plain || is_signed)) return plain ? VoxelType::u16 : VoxelType::i16;
  if (kind.bits == 32 && (plain || is_signed)) return plain ? VoxelType::u32 : VoxelType::i32;
  if (kind.bits == 16 && real) return StoredType::half();
  if (kind.bits == 32 && real) return VoxelType::f32;
  if (kind.bits == 64 && (plain || is_signed)) return StoredType::wide(is_signed);
  if (kind.bits == 64 && real) return VoxelType::f64;
  return std::nullopt;
}

bool TiffKind::hasLuminance() const {
  const bool unsigned_integers = sample_format == SAMPLEFORMAT_UINT || sample_format == SAMPLEFORMAT_VOID;
  return photometric == PHOTOMETRIC_RGB && (samples == 3 || samples == 4) && (bits == 8 || bits == 16) &&
         unsigned_integers && planes == PLANARCONFIG_CONTIG;
}

std::string refusalOf(const TiffKind& kind, TiffColours colours) {
  const bool as_luminance = colours == TiffColours::kLuminance && kind.hasLuminance();
  if (const char* colour = colourName(kind.photometric); colour != nullptr && !as_luminance)
    return fmt::format("holds {}, not one value a pixel{}", colour,
                       kind.hasLuminance()                    ? "; --luminance reads their luminance"
                       : kind.planes == PLANARCONFIG_SEPARATE ? ", in planes of their own; save them pixel by pixel"
                                                              : "");
  if (colours == TiffColours::kLuminance && !as_luminance)
    return "holds no colours, of which --luminance could be read; leave the option out";
  if (kind.samples != 1 && !as_luminance) return fmt::format("holds {} samples a pixel; Kiln reads one", kind.samples);
  if (kind.depth != 1) return "is a page with a depth of its own; save its slices as pages";
  const auto known = std::find_if(std::begin(kCompressions), std::end(kCompressions),
                                  [&](const Compression& c) { return c.code == kind.compression; });
  const bool named = known != std::end(kCompressions);
  if (!named || !known->read || TIFFIsCODECConfigured(static_cast<std::uint16_t>(kind.compression)) == 0) {
    return fmt::format("is compressed with {}{}, which is not read; save it with LZW, Deflate or none",
                       named ? std::string(known->name) + " " : "", fmt::format("(scheme {})", kind.compression));
  }
  if (!storedTypeOf(kind)) {
    return fmt::format("holds {}-bit {}; 8, 16, 32 and 64-bit integers, half, float and double are read", kind.bits,
                       formatName(kind.sample_format));
  }
  return "";
}

std::vector<std::byte> luminanceOf(std::vector<std::byte> pixels, VoxelType type, int samples) {
  withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_integral_v<T> && sizeof(T) <= 2) {
      const std::size_t pixel = static_cast<std::size_t>(samples) * sizeof(T), count = pixels.size() / pixel;
      for (std::size_t i = 0; i < count; ++i) {
        T rgb[3];
        std::memcpy(rgb, pixels.data() + i * pixel, sizeof rgb);
        const auto value = static_cast<T>((2126u * rgb[0] + 7152u * rgb[1] + 722u * rgb[2] + 5000u) / 10000u);
        std::memcpy(pixels.data() + i * sizeof(T), &value, sizeof value);
      }
      pixels.resize(count * sizeof(T));
    }
  });
  pixels.shrink_to_fit();
  return pixels;
}

}  // namespace kiln
