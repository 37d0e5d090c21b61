// The files of a volume that is stored slice by slice.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kiln {

enum class SliceFormat { kNone, kTiff, kDicom };

/// The files of one volume.
struct SliceFiles {
  /// What the user named: the directory, or the only file.
  std::filesystem::path input;
  SliceFormat format = SliceFormat::kNone;
  /// In natural order of their names.
  std::vector<std::filesystem::path> files;
  /// Says which other files were passed over; empty where there were none.
  std::vector<std::string> notes;
};

}  // namespace kiln
