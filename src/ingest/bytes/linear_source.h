// What raw, NRRD, MetaImage and NIfTI have in common once their headers are read: voxels x fastest at an offset of a
// file or in a gzip or zlib stream, in one of two byte orders, perhaps with a linear map to the values that are meant.
#pragma once

#include "ingest/source/volume_source.h"

namespace kiln {

enum class DataEncoding { kRaw, kGzip, kZlib };

struct LinearData {
  std::filesystem::path file;
  DataEncoding encoding = DataEncoding::kRaw;
  /// Where the data, or its compressed stream, begins. unit: bytes into the file.
  std::uint64_t offset_bytes = 0;
  /// Bytes of the decompressed stream to drop before the first voxel.
  std::uint64_t skip_decompressed_bytes = 0;
  VoxelType stored_type = VoxelType::u8;
  bool big_endian = false;
  /// value = stored * slope + intercept, in double, rounded once to `info.type`; exactly (1, 0) copies.
  double slope = 1;
  double intercept = 0;
};

/// A compressed source's finish() adds a note to `info().notes` for bytes behind the voxels, which are not read.
/// throws: Error kFormat where a raw file is too short for the header's dimensions, or sizes overflow; kUnsupported
/// never.
std::unique_ptr<VolumeSource> openLinear(SourceInfo info, const LinearData& data);

/// openLinear for what the header at `header` describes: the files are that one and, where it is another, the data's.
std::unique_ptr<VolumeSource> openDescribed(const std::filesystem::path& header, SourceInfo info,
                                            const LinearData& data);

/// The bytes that `dims` voxels of `type` take. throws: Error kFormat naming `path` where a dimension is not positive,
/// is above 2³¹-1 (OpenVDB's coordinates) or the product overflows 63 bits.
std::uint64_t checkedBytes(const Extent3& dims, VoxelType type, const std::filesystem::path& path);

}  // namespace kiln
