// NIfTI-1, NIfTI-2 and ANALYZE 7.5: a header, then voxels x fastest, in the header's file (.nii, .nii.gz) or in a
// second file (.hdr and .img). A series over time is one volume for each time. ANALYZE has spacings and no directions,
// and programs disagree on its left and right, so its frame stays unknown. Invariant: every field is checked before it
// is used as a size, an offset or a factor. Sources: nifti1.h and nifti2.h, the formats' defining headers,
// https://nifti.nimh.nih.gov.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/text.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/bytes/value_map.h"
#include "ingest/nifti/nifti_geometry.h"
#include "ingest/nifti/nifti_header.h"
#include "ingest/nifti/nifti_pair.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

using enum NiftiField;

struct NiftiFiles {
  fs::path header, voxels;
  bool gzip_voxels = false;
};

bool isNamedSingle(const fs::path& path) {
  return lowered((endsInGz(path) ? path.stem() : path.filename()).extension().string()) == ".nii";
}

// throws: Error kNotFound if one file of a pair is missing.
void requirePartner(const fs::path& path, const fs::path& input, const char* half) {
  std::error_code unknown;
  if (path != input && !fs::exists(path, unknown))
    throw Error(ErrorCode::kNotFound, input, "",
                fmt::format("the {} of this pair, {}, is missing; put it beside this file", half,
                            inQuotes(path.filename().string())));
}

NiftiFiles filesOf(const fs::path& input) {
  NiftiFiles files;
  files.header = isNamed(PairFile::kImage, input) ? besideInPair(PairFile::kHeader, input) : input;
  requirePartner(files.header, input, "header");
  return files;
}

void findVoxels(NiftiFiles& files, const NiftiHeader& header, const fs::path& input) {
  if (!header.pair() && files.header != input) {
    header.refuse("holds its own voxels, but an .img stands beside it");
  }
  files.voxels = !header.pair() ? files.header : files.header == input ? besideInPair(PairFile::kImage, input) : input;
  requirePartner(files.voxels, input, "image");
  std::error_code unknown;
  if (header.pair() && fs::equivalent(files.header, files.voxels, unknown))
    header.refuse(inQuotes(files.voxels.filename().string()) +
                  ", the file of its voxels, is this header itself; put the voxels there");
  // The voxels of a plain .img may begin with gzip's magic number, so the file name decides.
  files.gzip_voxels = header.pair() ? endsInGz(files.voxels) : header.inGzip();
}

void refuseIntent(const NiftiHeader& header) {
  const auto name = [&]() -> const char* {
    switch (header.integer(kIntentCode)) {
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

StoredType typeOf(const NiftiHeader& header) {
  switch (header.integer(kDatatype)) {
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
    case 1024:
      return StoredType::wide(true);
    case 1280:
      return StoredType::wide(false);
    case 1:
      header.refuse("holds single bits, which Kiln does not read; save it as 8-bit integers");
    case 32:
      header.refuse("holds complex numbers; save the real part or the magnitude");
    case 128:
      header.refuse("holds RGB24 colours, not one value a voxel");
    case 1536:
      header.refuse("holds 128-bit floats, which Kiln does not read; save it as float or double");
    case 1792:
      header.refuse("holds complex numbers of 128 bits; save the real part or the magnitude");
    case 2048:
      header.refuse("holds complex numbers of 256 bits; save the real part or the magnitude");
    case 2304:
      header.refuse("holds RGBA32 colours, not one value a voxel");
    default:
      header.fail(kDatatype, 0, fmt::format("data type {} is not one of NIfTI's", header.integer(kDatatype)));
  }
}

void takeScale(const NiftiHeader& header, LinearData& data, VoxelType& type, std::vector<std::string>& notes) {
  const double slope = header.real(kSclSlope), intercept = header.real(kSclInter);
  if (!std::isfinite(slope))
    notes.push_back(fmt::format("scl_slope is {}, which is no factor; values are taken as they are stored", slope));
  if (!std::isfinite(slope) || slope == 0 || (slope == 1 && intercept == 0)) return;
  if (!std::isfinite(intercept))
    header.fail(kSclInter, 0, fmt::format("scl_inter is {}, not a finite number, but scl_slope is", intercept));
  data.slope = slope;
  data.intercept = intercept;
  // The 24 bits of a float hold a 16-bit stored value and most of the factor; 32-bit integers need a double.
  const bool narrow = sizeOf(data.stored_type) <= 2 || data.stored_type.voxel() == VoxelType::f32;
  const ValueMap map = {data.stored_type, VoxelType::f32, false, slope, intercept};
  type = narrow && !map.mergesInFloat() ? VoxelType::f32 : VoxelType::f64;
  if (narrow && map.leavesFloat())
    header.fail(kSclSlope, 0,
                fmt::format("scl_slope {:g} and scl_inter {:g} take values beyond what a float can hold, "
                            "{:g} to {:g}; correct the header",
                            slope, intercept, std::numeric_limits<float>::min(), std::numeric_limits<float>::max()));
}

void takeOffset(const NiftiHeader& header, const NiftiFiles& files, LinearData& data) {
  const double offset = header.real(kVoxOffset);
  const std::int64_t least = header.pair() ? 0 : header.leastOffset();
  // 2^62 leaves room for later additions to the offset.
  if (!(offset >= static_cast<double>(least) && offset < 0x1p62) || offset != std::floor(offset)) {
    header.fail(kVoxOffset, 0, fmt::format("vox_offset is {}; a whole number from {} is legal", offset, least));
  }
  data.file = files.voxels;
  data.beginAt(static_cast<std::uint64_t>(offset), files.gzip_voxels);
}

void requireBits(const NiftiHeader& header, StoredType type) {
  const std::int64_t bits = header.integer(kBitpix), expected = static_cast<std::int64_t>(sizeOf(type) * 8);
  // Some writers leave bitpix at 0.
  if (bits != 0 && bits != expected) {
    header.fail(kBitpix, 0, fmt::format("bitpix is {}, but the data type has {} bits", bits, expected));
  }
}

}  // namespace

std::unique_ptr<VolumeSource> openNifti(const fs::path& input, const SourceOptions& options) {
  NiftiFiles files = filesOf(input);
  const NiftiHeader header(files.header);
  if (header.version() == NiftiVersion::kAnalyze && isNamedSingle(files.header))
    header.refuse("is ANALYZE 7.5 or damaged (no magic of NIfTI at byte 344); ANALYZE files are named .hdr and .img");
  findVoxels(files, header, input);
  refuseIntent(header);

  SourceInfo info;
  LinearData data;
  data.parts = niftiTimes(header);
  data.part = chosenTime(options, data.parts, input);
  info.format = header.name() + partOf("time", data.part, data.parts);
  info.geometry = niftiGeometry(header, options, info.notes);

  if (header.version() == NiftiVersion::kAnalyze)
    info.notes.push_back("ANALYZE 7.5 has no directions: its axes and values are taken as stored");
  data.stored_type = typeOf(header);
  info.type = data.stored_type.voxel();
  requireBits(header, data.stored_type);
  data.big_endian = header.bigEndian();
  takeScale(header, data, info.type, info.notes);
  takeOffset(header, files, data);
  return openDescribed(files.header, std::move(info), data);
}

}  // namespace kiln
