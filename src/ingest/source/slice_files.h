// The files of a volume that is stored slice by slice.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kiln {

enum class SliceFormat { kNone, kTiff, kDicom };

/// The files of one volume.
struct SliceFiles {
  /// The user's input: the directory, or the only file.
  std::filesystem::path input;
  SliceFormat format = SliceFormat::kNone;
  /// In natural order of their names.
  std::vector<std::filesystem::path> files;
  /// Sentences about the files passed over.
  std::vector<std::string> notes;
  /// ", channel 1" if the names of the files chose one of several stacks.
  std::string part = {};
};

}  // namespace kiln
