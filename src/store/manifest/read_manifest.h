// Reads the manifest of a store without its index: a few KiB for a volume of any size.
#pragma once

#include <filesystem>

#include "store/manifest/manifest.h"

namespace kiln {

/// throws: Error kNotFound, kFormat (no manifest: an unfinished conversion or no store), kDamaged.
Manifest readManifest(const std::filesystem::path& store);

}  // namespace kiln
