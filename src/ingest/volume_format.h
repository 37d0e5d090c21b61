// Names a volume's format, for commands that were given one in place of a store or a picture.
#pragma once

#include <filesystem>
#include <string>

namespace kiln {

struct VolumeFormat {
  /// The name with its article, "a NRRD"; empty where the file is of no known format of volumes.
  std::string name;
  /// Whether openSource reads it.
  bool read = false;
};

/// Returns the format by the file's first bytes, then by its name; none for what is no regular file. throws: Error kIo.
VolumeFormat volumeFormatOf(const std::filesystem::path& path);

}  // namespace kiln
