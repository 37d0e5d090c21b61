// NIfTI-1: a header of 348 bytes, then voxels x fastest, in the header's file (.nii, .nii.gz) or in a second file (.hdr
// and .img).
// Invariant: every field is checked before it is used as a size, an offset or a factor.
// Source: nifti1.h, the format's defining header, https://nifti.nimh.nih.gov/nifti-1.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/error.h"
#include "base/file.h"
#include "ingest/bytes/inflate_stream.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/bytes/value_map.h"
#include "ingest/nifti/nifti_geometry.h"
#include "ingest/nifti/nifti_header.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

using enum NiftiHeader::Field;

// The four bytes of the extension flag lie between header and voxels.
constexpr double kFirstVoxelByte = 352;

struct NiftiFiles {
  fs::path header, voxels;
  bool gzip_header = false, gzip_voxels = false;
};

// A header begins with its own length, which differs from gzip's magic number in either byte order.
bool isGzip(const fs::path& path) {
  std::array<std::byte, 2> first{};
  return File(path).readSomeAt(0, first) == 2 && first[0] == std::byte{0x1f} && first[1] == std::byte{0x8b};
}

NiftiHeader readHeader(const NiftiFiles& files) {
  std::array<std::byte, NiftiHeader::kBytes> bytes{};
  if (files.gzip_header) {
    InflateStream(File(files.header), 0, StreamWrapper::kGzip).read(bytes, "header");
  } else {
    File(files.header).readAt(0, bytes);
  }
  return NiftiHeader(bytes, files.header);
}

// Returns the image beside a .hdr, or the header beside an .img.
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

void findVoxels(NiftiFiles& files, const NiftiHeader& header, const fs::path& input) {
  if (!header.pair() && files.header != input) {
    header.fail("byte 344", "holds its own voxels, but an .img stands beside it");
  }
  files.voxels = !header.pair() ? files.header : files.header == input ? partner(input, ".img") : input;
  std::error_code unknown;
  if (header.pair() && fs::equivalent(files.header, files.voxels, unknown))
    header.fail("byte 344", inQuotes(files.voxels.filename().string()) +
                                ", the file of its voxels, is this header itself; put the voxels there");
  // The voxels of a plain .img may begin with gzip's magic number, so the file name decides.
  files.gzip_voxels = header.pair() ? files.voxels.extension() == ".gz" : files.gzip_header;
}

void refuseIntent(const NiftiHeader& header) {
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
  if (name != nullptr) header.refuse(fmt::format("holds {} data (by its intent), not one value a voxel", name));
}

VoxelType typeOf(const NiftiHeader& header) {
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
      header.refuse("holds single bits, which Kiln does not read; save it as 8-bit integers");
    case 32:
      header.refuse("holds complex numbers; save the real part or the magnitude");
    case 128:
      header.refuse("holds RGB24 colours, not one value a voxel");
    case 1024:
      header.refuse("holds 64-bit integers, which Kiln does not read; save it as 32-bit integers or float");
    case 1280:
      header.refuse("holds unsigned 64-bit integers, which Kiln does not read; save it as 32-bit integers or float");
    case 1536:
      header.refuse("holds 128-bit floats, which Kiln does not read; save it as float or double");
    case 1792:
      header.refuse("holds complex numbers of 128 bits; save the real part or the magnitude");
    case 2048:
      header.refuse("holds complex numbers of 256 bits; save the real part or the magnitude");
    case 2304:
      header.refuse("holds RGBA32 colours, not one value a voxel");
    default:
      header.fail("byte 70", fmt::format("data type {} is not one of NIfTI-1's", header.i16(kDatatype)));
  }
}

void takeScale(const NiftiHeader& header, LinearData& data, VoxelType& type, std::vector<std::string>& notes) {
  const double slope = header.f32(kSclSlope), intercept = header.f32(kSclInter);
  if (!std::isfinite(slope))
    notes.push_back(fmt::format("scl_slope is {}, which is no factor; values are taken as they are stored", slope));
  if (!std::isfinite(slope) || slope == 0 || (slope == 1 && intercept == 0)) return;
  if (!std::isfinite(intercept))
    header.fail("byte 116", fmt::format("scl_inter is {}, not a finite number, but scl_slope is", intercept));
  data.slope = slope;
  data.intercept = intercept;
  // The 24 bits of a float hold a 16-bit stored value and most of the factor; 32-bit integers need a double.
  const bool narrow = sizeOf(data.stored_type) <= 2 || data.stored_type == VoxelType::f32;
  const ValueMap map = {data.stored_type, VoxelType::f32, false, slope, intercept};
  type = narrow && !map.mergesInFloat() ? VoxelType::f32 : VoxelType::f64;
  if (narrow && map.leavesFloat())
    header.fail("byte 112",
                fmt::format("scl_slope {:g} and scl_inter {:g} take values beyond what a float can hold, "
                            "{:g} to {:g}; correct the header",
                            slope, intercept, std::numeric_limits<float>::min(), std::numeric_limits<float>::max()));
}

void takeOffset(const NiftiHeader& header, const NiftiFiles& files, LinearData& data) {
  const double offset = header.f32(kVoxOffset);
  const double least = header.pair() ? 0 : kFirstVoxelByte;
  // 2^62 leaves room for later additions to the offset.
  if (!(offset >= least && offset < 0x1p62) || offset != std::floor(offset)) {
    header.fail("byte 108", fmt::format("vox_offset is {}; a whole number from {} is legal", offset, least));
  }
  data.file = files.voxels;
  data.encoding = files.gzip_voxels ? DataEncoding::kGzip : DataEncoding::kRaw;
  (files.gzip_voxels ? data.skip_decompressed_bytes : data.offset_bytes) = static_cast<std::uint64_t>(offset);
}

void requireBits(const NiftiHeader& header, VoxelType type) {
  const int bits = header.i16(kBitpix), expected = static_cast<int>(sizeOf(type) * 8);
  // Some writers leave bitpix at 0.
  if (bits != 0 && bits != expected) {
    header.fail("byte 72", fmt::format("bitpix is {}, but the data type has {} bits", bits, expected));
  }
}

}  // namespace

std::unique_ptr<VolumeSource> openNifti(const fs::path& input, const SourceOptions& options) {
  NiftiFiles files = filesOf(input);
  const NiftiHeader header = readHeader(files);
  findVoxels(files, header, input);
  refuseIntent(header);

  SourceInfo info;
  info.format = "NIfTI-1";
  info.geometry = niftiGeometry(header, options, info.notes);

  LinearData data;
  data.stored_type = info.type = typeOf(header);
  requireBits(header, data.stored_type);
  data.big_endian = header.bigEndian();
  takeScale(header, data, info.type, info.notes);
  takeOffset(header, files, data);
  return openDescribed(files.header, std::move(info), data);
}

}  // namespace kiln
