// Voxels as most formats store them: x fastest, at an offset of a file, in a compressed stream or as text. Either byte
// order, and an optional linear map from stored to real values.
#pragma once

#include "ingest/bytes/stored_type.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// kDecimal, kShare and kHex are text; kShare is for u8 (text_stream.h).
enum class DataEncoding { kRaw, kGzip, kZlib, kBzip2, kDecimal, kShare, kHex };

struct LinearData {
  std::filesystem::path file;
  DataEncoding encoding = DataEncoding::kRaw;
  /// Begin of the data, of the compressed stream or of the text. unit: bytes into the file.
  std::uint64_t offset_bytes = 0;
  /// Bytes of the decompressed stream to drop before the first voxel.
  std::uint64_t skip_decompressed_bytes = 0;
  StoredType stored_type = VoxelType::u8;
  bool big_endian = false;
  /// value = stored * slope + intercept, in double, rounded once to `info.type`. Exactly (1, 0) copies the bytes.
  double slope = 1;
  double intercept = 0;
  /// The data hold `parts` volumes of `info.geometry.dims`, one behind the other; volume `part` is read.
  std::int64_t part = 0, parts = 1;
  /// True if the format has further fields behind the voxels, which are then passed over without a note.
  bool has_trailer = false;

  /// Places raw voxels at `offset` of the file, or of the decompressed file if the whole file is in gzip. unit: bytes.
  void beginAt(std::uint64_t offset, bool in_gzip);
};

/// Opens the voxels that a header describes. The finish() of a compressed source adds a note to `info().notes` for
/// unread bytes behind the voxels.
/// throws: Error kFormat if a raw file is too short for the header's dimensions, or sizes overflow.
std::unique_ptr<VolumeSource> openLinear(SourceInfo info, const LinearData& data);

/// Calls openLinear and records the source's files: the header and, if the data lie in another file, the data file.
std::unique_ptr<VolumeSource> openDescribed(const std::filesystem::path& header, SourceInfo info,
                                            const LinearData& data);

/// Returns the size of `dims` voxels of `type`. unit: bytes.
/// throws: Error kFormat naming `path` if a dimension is not positive or above 2³¹-1 (OpenVDB's coordinates), or the
/// product overflows 63 bits.
std::uint64_t checkedBytes(const Extent3& dims, StoredType type, const std::filesystem::path& path);

}  // namespace kiln
