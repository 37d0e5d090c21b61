// NIfTI-1: a header of 348 bytes at documented offsets, then voxels x fastest, in one file (.nii, .nii.gz) or beside it
// (.hdr and .img). Every field is a number that somebody else wrote: each is checked before it is used as a size, an
// offset or a factor. Source: nifti1.h, the format's defining header, https://nifti.nimh.nih.gov/nifti-1.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/ext/matrix_transform.hpp>

#include "base/error.h"
#include "base/file.h"
#include "ingest/formats.h"
#include "ingest/inflate_stream.h"
#include "ingest/linear_source.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kHeaderBytes = 348;
// The four bytes of the extension flag stand between header and voxels.
constexpr double kFirstVoxelByte = 352;
constexpr std::int32_t kNifti2HeaderBytes = 540;

// Where the fields are, in bytes (nifti1.h, the comments beside struct nifti_1_header).
enum Field : std::size_t {
  kSizeofHdr = 0,
  kDim = 40,
  kIntentCode = 68,
  kDatatype = 70,
  kBitpix = 72,
  kPixdim = 76,
  kVoxOffset = 108,
  kSclSlope = 112,
  kSclInter = 116,
  kXyztUnits = 123,
  kQformCode = 252,
  kSformCode = 254,
  kQuaternB = 256,
  kQoffsetX = 268,
  kSrowX = 280,
  kMagic = 344,
};

class Header {
 public:
  /// requires: kHeaderBytes bytes.
  explicit Header(std::span<const std::byte> bytes) {
    std::copy_n(bytes.begin(), kHeaderBytes, bytes_.begin());
    swap_ = get<std::int32_t>(kSizeofHdr) != kHeaderBytes;
  }

  std::int16_t i16(std::size_t at) const { return get<std::int16_t>(at); }
  std::int32_t i32(std::size_t at) const { return get<std::int32_t>(at); }
  double f32(std::size_t at) const { return static_cast<double>(get<float>(at)); }
  int byteAt(std::size_t at) const { return std::to_integer<int>(bytes_[at]); }
  bool magicIs(const char (&magic)[4]) const { return std::memcmp(bytes_.data() + kMagic, magic, 4) == 0; }
  bool bigEndian() const { return swap_ == (std::endian::native == std::endian::little); }
  std::int32_t sizeAsWritten(bool swapped) const {
    Header other = *this;
    other.swap_ = swapped;
    return other.i32(kSizeofHdr);
  }

 private:
  template <class T>
  T get(std::size_t at) const {
    std::array<std::byte, sizeof(T)> raw;
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at), sizeof(T), raw.begin());
    if (swap_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

  std::array<std::byte, kHeaderBytes> bytes_;
  bool swap_ = false;
};

struct NiftiFiles {
  fs::path header, voxels;
  bool gzip_header = false, gzip_voxels = false;
};

[[noreturn]] void fail(const fs::path& path, const std::string& place, const std::string& what) {
  throw Error(ErrorCode::kFormat, path, place, what);
}

[[noreturn]] void refuse(const fs::path& path, const std::string& what) {
  throw Error(ErrorCode::kUnsupported, path, "", what);
}

// A header begins with its own length, which no byte order turns into gzip's magic number.
bool isGzip(const fs::path& path) {
  std::array<std::byte, 2> first{};
  return File(path).readSomeAt(0, first) == 2 && first[0] == std::byte{0x1f} && first[1] == std::byte{0x8b};
}

Header readHeader(const NiftiFiles& files) {
  std::array<std::byte, kHeaderBytes> bytes{};
  if (files.gzip_header) {
    InflateStream(File(files.header), 0, StreamWrapper::kGzip).read(bytes, "header");
  } else {
    File(files.header).readAt(0, bytes);
  }
  return Header(bytes);
}

void requireNifti1(const Header& header, const fs::path& path) {
  for (const bool swapped : {false, true}) {
    if (header.sizeAsWritten(swapped) == kNifti2HeaderBytes) {
      refuse(path, "is NIfTI-2, which Kiln does not read; save it as NIfTI-1");
    }
  }
  if (header.i32(kSizeofHdr) != kHeaderBytes) fail(path, "byte 0", "the header does not begin with its length, 348");
  if (!header.magicIs("n+1") && !header.magicIs("ni1")) {
    refuse(path, "is ANALYZE 7.5 or unknown (no NIfTI-1 magic at byte 344); convert it to NIfTI-1");
  }
}

// The image beside a .hdr, the header beside an .img.
fs::path partner(const fs::path& path, const char* extension) {
  const bool packed = path.extension() == ".gz";
  fs::path stem = packed ? fs::path(path).replace_extension() : path;
  const fs::path plain = stem.replace_extension(extension);
  const fs::path gzip = plain.string() + ".gz";
  std::error_code ignored;
  return !fs::exists(plain, ignored) && fs::exists(gzip, ignored) ? gzip : plain;
}

NiftiFiles filesOf(const fs::path& input) {
  const fs::path name = input.extension() == ".gz" ? input.stem() : input.filename();
  NiftiFiles files;
  files.header = name.extension() == ".img" ? partner(input, ".hdr") : input;
  files.gzip_header = isGzip(files.header);
  return files;
}

void findVoxels(NiftiFiles& files, const Header& header, const fs::path& input) {
  const bool pair = header.magicIs("ni1");
  if (!pair && files.header != input)
    fail(files.header, "byte 344", "holds its own voxels, but an .img stands beside it");
  files.voxels = !pair ? files.header : files.header == input ? partner(input, ".img") : input;
  // The voxels of a plain .img may begin with gzip's magic number; its name decides.
  files.gzip_voxels = pair ? files.voxels.extension() == ".gz" : files.gzip_header;
}

void refuseIntent(const Header& header, const fs::path& path) {
  const auto name = [&]() -> const char* {
    switch (header.i16(kIntentCode)) {
      case 1004:
        return "matrix";
      case 1005:
        return "symmetric matrix";
      case 1006:
        return "displacement vector";
      case 1007:
        return "vector";
      case 1008:
        return "point set";
      case 1009:
        return "triangle";
      case 1010:
        return "quaternion";
      case 2003:
        return "RGB";
      case 2004:
        return "RGBA";
      default:
        return nullptr;
    }
  }();
  if (name != nullptr) refuse(path, fmt::format("holds {} data (by its intent), not one value a voxel", name));
}

Extent3 dimsOf(const Header& header, const fs::path& path) {
  const int count = header.i16(kDim);
  if (count < 1 || count > 7) fail(path, "byte 40", fmt::format("dim[0] is {}; 1 to 7 are legal", count));
  std::array<std::int64_t, 8> dim{};
  for (std::size_t i = 1; i <= static_cast<std::size_t>(count); ++i) {
    dim[i] = header.i16(kDim + 2 * i);
    if (dim[i] < 1) fail(path, fmt::format("byte {}", kDim + 2 * i), fmt::format("dim[{}] is {}", i, dim[i]));
  }
  if (count < 3) refuse(path, fmt::format("has {} dimensions; Kiln reads volumes", count));
  if (count >= 4 && dim[4] > 1)
    refuse(path, fmt::format("is a time series of {} volumes; extract one of them", dim[4]));
  for (std::size_t i = 5; i <= static_cast<std::size_t>(count); ++i) {
    if (dim[i] > 1)
      refuse(path, fmt::format("holds {} values a voxel (dim[{}]); Kiln reads scalar volumes", dim[i], i));
  }
  return {dim[1], dim[2], dim[3]};
}

VoxelType typeOf(const Header& header, const fs::path& path) {
  switch (header.i16(kDatatype)) {
    case 2:
      return VoxelType::u8;
    case 4:
      return VoxelType::i16;
    case 8:
      return VoxelType::i32;
    case 16:
      return VoxelType::f32;
    case 64:
      return VoxelType::f64;
    case 256:
      return VoxelType::i8;
    case 512:
      return VoxelType::u16;
    case 768:
      return VoxelType::u32;
    case 1:
      refuse(path, "holds single bits, which Kiln does not read; save it as 8-bit integers");
    case 32:
      refuse(path, "holds complex numbers; save the real part or the magnitude");
    case 128:
      refuse(path, "holds RGB24 colours, not one value a voxel");
    case 1024:
      refuse(path, "holds 64-bit integers, which Kiln does not read; save it as 32-bit integers or float");
    case 1280:
      refuse(path, "holds unsigned 64-bit integers, which Kiln does not read; save it as 32-bit integers or float");
    case 1536:
      refuse(path, "holds 128-bit floats, which Kiln does not read; save it as float or double");
    case 1792:
      refuse(path, "holds complex numbers of 128 bits; save the real part or the magnitude");
    case 2048:
      refuse(path, "holds complex numbers of 256 bits; save the real part or the magnitude");
    case 2304:
      refuse(path, "holds RGBA32 colours, not one value a voxel");
    default:
      fail(path, "byte 70", fmt::format("data type {} is not one of NIfTI-1's", header.i16(kDatatype)));
  }
}

// nifti1.h, METHOD 2: the quaternion's rotation, with the third axis mirrored where qfac (pixdim[0]) is negative.
glm::dmat4 quaternionAffine(const Header& header, const glm::dvec3& spacing) {
  double b = header.f32(kQuaternB), c = header.f32(kQuaternB + 4), d = header.f32(kQuaternB + 8);
  double a = 1 - (b * b + c * c + d * d);
  if (a < 1e-7) {  // a half turn, but for rounding
    const double length = std::sqrt(b * b + c * c + d * d);
    b /= length, c /= length, d /= length;
    a = 0;
  } else {
    a = std::sqrt(a);
  }
  const double qfac = header.f32(kPixdim) < 0 ? -1 : 1;
  const glm::dvec3 x(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c));
  const glm::dvec3 y(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b));
  const glm::dvec3 z(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b);
  const glm::dvec3 origin(header.f32(kQoffsetX), header.f32(kQoffsetX + 4), header.f32(kQoffsetX + 8));
  return glm::dmat4(glm::dvec4(x * spacing.x, 0), glm::dvec4(y * spacing.y, 0), glm::dvec4(z * (spacing.z * qfac), 0),
                    glm::dvec4(origin, 1));
}

glm::dmat4 rowsAffine(const Header& header) {
  glm::dmat4 out(1.0);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      out[column][row] = header.f32(kSrowX + 16 * static_cast<std::size_t>(row) + 4 * static_cast<std::size_t>(column));
    }
  }
  return out;
}

std::string unitOf(const Header& header) {
  switch (header.byteAt(kXyztUnits) & 7) {
    case 1:
      return "m";
    case 2:
      return "mm";
    case 3:
      return "um";
    default:
      return "";
  }
}

VolumeGeometry geometryOf(const Header& header, const fs::path& path, const SourceOptions& options) {
  VolumeGeometry out;
  out.dims = dimsOf(header, path);
  out.unit = unitOf(header);
  // The format wants lengths; a sign in them is a known mistake of writers, and means nothing.
  const glm::dvec3 spacing(std::abs(header.f32(kPixdim + 4)), std::abs(header.f32(kPixdim + 8)),
                           std::abs(header.f32(kPixdim + 12)));
  const bool rows = header.i16(kSformCode) > 0, quaternion = header.i16(kQformCode) > 0;
  if (rows || quaternion) {
    if (options.spacing) {
      throw Error(ErrorCode::kUsage, path, "", "says where its voxels are; --spacing is for files that do not");
    }
    out.world_from_index = rows ? rowsAffine(header) : quaternionAffine(header, spacing);
    out.frame = PatientFrame::kRas;
  } else {
    out.world_from_index = glm::scale(glm::dmat4(1.0), options.spacing.value_or(spacing));
  }
  requireInvertible(out.world_from_index, path.string());
  return out;
}

void takeScale(const Header& header, const fs::path& path, LinearData& data, VoxelType& type) {
  const double slope = header.f32(kSclSlope), intercept = header.f32(kSclInter);
  if (!std::isfinite(slope) || slope == 0 || (slope == 1 && intercept == 0)) return;
  if (!std::isfinite(intercept)) fail(path, "byte 116", "scl_inter is not a finite number, but scl_slope is");
  data.slope = slope;
  data.intercept = intercept;
  // 24 bits of a float hold the 16 of the stored value and most of the factor's; 32-bit integers need a double.
  const bool narrow = sizeOf(data.stored_type) <= 2 || data.stored_type == VoxelType::f32;
  type = narrow ? VoxelType::f32 : VoxelType::f64;
}

void takeOffset(const Header& header, const NiftiFiles& files, LinearData& data) {
  const double offset = header.f32(kVoxOffset);
  const double least = header.magicIs("n+1") ? kFirstVoxelByte : 0;
  // 2^62 leaves room for what is added to an offset.
  if (!(offset >= least && offset < 0x1p62) || offset != std::floor(offset)) {
    fail(files.header, "byte 108", fmt::format("vox_offset is {}; a whole number from {} is legal", offset, least));
  }
  data.file = files.voxels;
  data.encoding = files.gzip_voxels ? DataEncoding::kGzip : DataEncoding::kRaw;
  (files.gzip_voxels ? data.skip_decompressed_bytes : data.offset_bytes) = static_cast<std::uint64_t>(offset);
}

void requireBits(const Header& header, VoxelType type, const fs::path& path) {
  const int bits = header.i16(kBitpix), expected = static_cast<int>(sizeOf(type) * 8);
  // Some writers leave it 0.
  if (bits != 0 && bits != expected) {
    fail(path, "byte 72", fmt::format("bitpix is {}, but the data type has {} bits", bits, expected));
  }
}

}  // namespace

std::unique_ptr<VolumeSource> openNifti(const fs::path& input, const SourceOptions& options) {
  NiftiFiles files = filesOf(input);
  const Header header = readHeader(files);
  requireNifti1(header, files.header);
  findVoxels(files, header, input);
  refuseIntent(header, files.header);

  SourceInfo info;
  info.format = "NIfTI-1";
  info.geometry = geometryOf(header, files.header, options);

  LinearData data;
  data.stored_type = info.type = typeOf(header, files.header);
  requireBits(header, data.stored_type, files.header);
  data.big_endian = header.bigEndian();
  takeScale(header, files.header, data, info.type);
  takeOffset(header, files, data);
  return openDescribed(files.header, std::move(info), data);
}

}  // namespace kiln
