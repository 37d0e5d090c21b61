// Names the format of a file that a command got in place of a store or a picture.
#pragma once

#include <filesystem>
#include <string>

namespace kiln {

struct VolumeFormat {
  /// The name with its article, "a NRRD"; empty if the format is unknown.
  std::string name;
  /// True if openSource can read the format.
  bool read = false;
};

/// Returns the format by the file's first bytes, then by its name; empty for anything but a regular file. throws: Error
/// kIo.
VolumeFormat volumeFormatOf(const std::filesystem::path& path);

}  // namespace kiln
