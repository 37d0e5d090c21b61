// The table that maps stored values to the values of a modality, in files without a slope and an intercept.
// Source: DICOM PS3.3, C.11.1.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "grid/voxel_type.h"
#include "ingest/dicom/dicom_elements.h"

namespace kiln {

inline constexpr DicomTag kModalityLut = 0x00283000, kLutDescriptor = 0x00283002, kLutData = 0x00283006;

struct DicomLut {
  /// The stored value of the first entry. Lesser values map to the first entry, greater ones to the last.
  std::int64_t first = 0;
  /// Bits of the values: 8 to 16.
  int bits = 16;
  std::vector<std::uint16_t> values;

  /// The type that holds the values.
  VoxelType type() const { return bits > 8 ? VoxelType::u16 : VoxelType::u8; }
  /// Maps `count` values of `from` to values of `to`, u8 or u16. requires: integers, and `to` holds the values.
  void apply(VoxelType from, const std::byte* in, std::size_t count, VoxelType to, std::byte* out) const;

  bool operator==(const DicomLut&) const = default;
};

/// Returns the table of a file; nothing if the file has none. `is_signed` is true for signed pixels.
/// throws: Error kFormat if the table contradicts its descriptor.
std::optional<DicomLut> modalityLut(const DicomSet& file, bool is_signed, const std::filesystem::path& path);

}  // namespace kiln
