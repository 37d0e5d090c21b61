// The header of one DICOM file as plain data: its series, the storage of its pixels, and the place of each frame in the
// patient.
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "grid/voxel_type.h"
#include "ingest/bytes/value_map.h"
#include "ingest/dicom/dicom_fragments.h"
#include "ingest/dicom/dicom_lut.h"

namespace kiln {

/// Storage of pixels. Slices of one volume may differ in compression, bits and place.
struct DicomPixels {
  std::int64_t columns = 0, rows = 0, frames = 1;
  int bits_allocated = 0, bits_stored = 0, high_bit = 0;
  bool is_signed = false;
  /// True if the smallest value is shown white (MONOCHROME1).
  bool smallest_is_white = false;
  bool big_endian = false;
  /// True for bytes in big-endian words: the first of two pixels is the second byte of a word.
  bool in_words = false;
  /// True for compressed pixels, decoded frame by frame. Uncompressed frames lie at `offset_bytes`, x fastest: in the
  /// file, or, if `deflated_offset_bytes` is not 0, in the elements inflated from there.
  bool packed = false;
  std::uint64_t offset_bytes = 0, deflated_offset_bytes = 0;
  /// The unique identifier of the encoding (a UID).
  std::string transfer_syntax;

  /// The type of the stored values. requires: 1, 8, 16 or 32 bits allocated.
  VoxelType storedType() const;
  std::uint64_t frameBytes() const { return static_cast<std::uint64_t>(columns * rows) * sizeOf(storedType()); }
};

/// Place of a frame, as far as the file gives it. unit: mm, in DICOM's patient space (LPS).
struct DicomFrame {
  /// The centre of the first pixel.
  std::optional<glm::dvec3> position;
  /// Unit vectors along which the column number and the row number grow.
  std::optional<glm::dvec3> along_row, along_column;
  /// Distance between columns, and between rows.
  std::optional<glm::dvec2> spacing;
  /// Distance between slices, and the thickness of a slice; 0 if the file does not have it.
  double between = 0, thickness = 0;
  /// The best guess of the distance between slices; 0 if the file has neither number.
  double distance() const { return between > 0 ? between : thickness; }
  /// value = stored * slope + intercept. Empty if the file has no value; a slope of 0, which would erase all values,
  /// counts as none.
  std::optional<double> slope, intercept;
  bool slope_is_zero = false;
  ValueMap map(VoxelType stored, VoxelType to) const {
    return {stored, to, false, slope.value_or(1), intercept.value_or(0)};
  }
  /// The bytes of a compressed frame.
  std::vector<ByteRange> fragments;
};

struct DicomHeader {
  std::filesystem::path path;
  /// Shown to the user and matched by --series.
  std::string series, description, modality;
  std::optional<std::int64_t> instance;
  /// False for reports, structures and a DICOMDIR.
  bool has_pixels = false;
  /// True if the header describes an image, even if its pixels are missing.
  bool is_image = false;
  /// Reason why the pixels are not supported ("holds RGB colours"); empty if they are supported.
  std::string refusal;
  /// The reason why the file cannot be parsed; empty if it can. Of a damaged file only path and identifiers are known,
  /// as far as they precede the damage, and `has_pixels` is false.
  std::optional<Error> damage;
  /// An invalid number in the header, thrown only if the file is taken as a slice; empty if all numbers are valid.
  std::optional<Error> fault;
  DicomPixels pixels;
  std::vector<DicomFrame> frames;
  /// The segment of each frame of a segmentation object; empty for images. Pixels are bits, or, with
  /// `largest_fraction`, bytes.
  std::vector<int> segments;
  /// The pixel of a fractional segmentation object that stands for the whole; nothing for other objects.
  std::optional<int> largest_fraction;
  /// Null for values with a slope and an intercept. Slices with equal tables share one.
  std::shared_ptr<const DicomLut> lut;
};

/// The damage is of kFormat if the file is cut short or its header contradicts itself; kUnsupported if fragments cannot
/// be assigned to frames.
/// throws: Error kNotFound, kIo, kFormat if the file is not DICOM.
/// cost: the header, not the pixels.
DicomHeader readDicomHeader(const std::filesystem::path& path);

}  // namespace kiln
