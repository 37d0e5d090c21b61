// Names of the files of a store that are no bricks.
#pragma once

namespace kiln {

inline constexpr const char* kManifestFile = "manifest.json";
inline constexpr const char* kIndexFile = "index.bin";

}  // namespace kiln
