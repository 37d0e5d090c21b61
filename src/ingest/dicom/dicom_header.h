// What one DICOM file says of itself, as plain data: which series it belongs to, how its pixels are stored and where,
// and where each of its frames lies in the patient.
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "grid/voxel_type.h"
#include "ingest/bytes/value_map.h"
#include "ingest/dicom/dicom_fragments.h"

namespace kiln {

/// How pixels are stored; slices of one volume may differ in compression, bits and place.
struct DicomPixels {
  std::int64_t columns = 0, rows = 0, frames = 1;
  int bits_allocated = 0, bits_stored = 0, high_bit = 0;
  bool is_signed = false;
  /// The smallest value is shown white (MONOCHROME1).
  bool smallest_is_white = false;
  bool big_endian = false;
  /// Compressed: a frame is decoded as one. Else frames lie at the offset, x fastest, in the file or, where
  /// `deflated_offset_bytes` is not 0, in the elements that the stream from there on inflates to.
  bool packed = false;
  std::uint64_t offset_bytes = 0, deflated_offset_bytes = 0;
  /// The unique identifier of the encoding.
  std::string transfer_syntax;

  /// The type of the stored values. requires: 8, 16 or 32 bits allocated.
  VoxelType storedType() const;
  std::uint64_t frameBytes() const { return static_cast<std::uint64_t>(columns * rows) * sizeOf(storedType()); }
};

/// Where a frame lies, as far as the file says. unit: mm, in DICOM's patient space (LPS).
struct DicomFrame {
  /// The centre of the first pixel.
  std::optional<glm::dvec3> position;
  /// The directions in which the column's and the row's number grow: unit vectors.
  std::optional<glm::dvec3> along_row, along_column;
  /// The distance of columns, and of rows.
  std::optional<glm::dvec2> spacing;
  /// From slice to slice, or the thickness of one; 0 where neither is said.
  double distance = 0;
  /// value = stored * slope + intercept. Empty where the file says none; a slope of 0, which no value survives, is
  /// none.
  std::optional<double> slope, intercept;
  bool slope_is_zero = false;
  ValueMap map(VoxelType stored, VoxelType to) const {
    return {stored, to, false, slope.value_or(1), intercept.value_or(0)};
  }
  /// Where a compressed frame's bytes are.
  std::vector<ByteRange> fragments;
};

struct DicomHeader {
  std::filesystem::path path;
  /// For people and --series.
  std::string series, description, modality;
  std::optional<std::int64_t> instance;
  /// False for reports, structures and a DICOMDIR.
  bool has_pixels = false;
  /// Whether the header describes an image, though its pixels may be missing.
  bool is_image = false;
  /// Why the pixels are not read ("holds RGB colours"); empty where they are.
  std::string refusal;
  /// A number of the header that no slice can have; thrown once the file is taken as a slice. Empty where all are
  /// right.
  std::optional<Error> fault;
  DicomPixels pixels;
  std::vector<DicomFrame> frames;
};

/// throws: Error kNotFound, kIo, kFormat where the file is not DICOM, is cut short, or its header contradicts itself;
/// kUnsupported where it cannot be told whose fragments are whose.
/// cost: the header, not the pixels.
DicomHeader readDicomHeader(const std::filesystem::path& path);

}  // namespace kiln
