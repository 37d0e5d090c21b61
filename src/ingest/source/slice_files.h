// The files of a volume that is stored slice by slice.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kiln {

enum class SliceFormat { kNone, kTiff, kDicom, kPng, kJpeg, kJpeg2000 };

/// Formats of one picture a file, which says nothing of its place.
inline constexpr SliceFormat kPictureFormats[] = {SliceFormat::kPng, SliceFormat::kJpeg, SliceFormat::kJpeg2000};

/// "TIFF", "DICOM", "PNG", "JPEG", "JPEG 2000"; empty for kNone.
constexpr const char* nameOf(SliceFormat format) {
  constexpr const char* kNames[] = {"", "TIFF", "DICOM", "PNG", "JPEG", "JPEG 2000"};
  return kNames[static_cast<int>(format)];
}

/// The files of one volume.
struct SliceFiles {
  /// The user's input: the directory, or the only file.
  std::filesystem::path input;
  SliceFormat format = SliceFormat::kNone;
  /// In natural order of their names.
  std::vector<std::filesystem::path> files;
  /// Logs beside TIFF slices, which may state the size of a voxel.
  std::vector<std::filesystem::path> logs;
  /// Sentences about the files passed over.
  std::vector<std::string> notes;
  /// ", channel 1" if the names of the files chose one of several stacks.
  std::string part = {};
};

}  // namespace kiln
