// DICOM files written element by element from PS3.5, independently of the tested reader; only compression uses GDCM.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kiln::test {

enum class DicomSyntax { kExplicitLittle, kImplicitLittle, kExplicitBig, kDeflated };
/// Bytes before the elements: 128 zeros or the header of a TIFF, then DICM and the first group; or none.
enum class DicomPreamble { kZeros, kTiff, kNone };
enum class DicomCodec { kRle, kJpegLossless, kJpegLs, kJpeg2000 };

/// Attributes that tests vary; the default is a CT slice of 5 x 4 signed 16-bit pixels at the origin. Numbers that
/// DICOM writes as text are text; empty texts are left out.
struct DicomSpec {
  DicomSyntax syntax = DicomSyntax::kExplicitLittle;
  DicomPreamble preamble = DicomPreamble::kZeros;
  int columns = 5, rows = 4, frames = 1;
  int bits_allocated = 16, bits_stored = 16, high_bit = -1;  // -1: stored - 1
  bool is_signed = true;
  int samples = 1;
  std::string photometric = "MONOCHROME2";
  std::string series = "1.2.3.4", description = "a series", modality = "CT", instance;
  std::string position = "0\\0\\0", orientation = "1\\0\\0\\0\\1\\0", spacing = "1\\1", thickness, slope, intercept;
  /// Position of each frame, in functional groups; frames share all other attributes.
  std::vector<std::string> frame_positions;
  bool pixels = true;
  bool image = true;  // false: without rows and columns, as reports are
  /// BINARY for a segmentation object; the segment of each frame, in functional groups.
  std::string segmentation;
  std::vector<int> frame_segments;
  /// The modality's table: three numbers, and the entries, as bytes of the syntax.
  std::string lut_descriptor, lut_data;
  bool in_words = false;  // pixels of 8 bits in words
  /// Attributes of a dose grid.
  std::string frame_offsets, dose_scaling;
  /// Elements right before the pixels, as bytes of the syntax.
  std::string elements;
  /// Pixels in the byte order of the syntax.
  std::string pixel_bytes;
};

/// The bytes of the file.
std::string dicomFile(const DicomSpec& spec);

/// Returns the DICOMDIR of a CD with these files, each as FOLDER\\FILE.
std::string dicomDirectory(const std::vector<std::string>& files);

/// Compresses the pixels of the file at `path`.
void compressDicom(const std::filesystem::path& path, DicomCodec codec);

}  // namespace kiln::test
