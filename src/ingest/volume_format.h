// What a file is, for commands that take a store or a picture and were given a volume.
#pragma once

#include <filesystem>
#include <string>

namespace kiln {

struct VolumeFormat {
  /// With its article, "a NRRD"; empty where the file is of no known format of volumes.
  std::string name;
  /// Whether openSource reads it.
  bool read = false;
};

/// By the file's first bytes, then by its name; none for what is no regular file. throws: Error kIo.
VolumeFormat volumeFormatOf(const std::filesystem::path& path);

}  // namespace kiln
