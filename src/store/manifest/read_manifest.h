// The manifest of a store alone, without the index: a few KiB, whatever the size of the volume.
#pragma once

#include <filesystem>

#include "store/manifest/manifest.h"

namespace kiln {

/// throws: Error kNotFound, kFormat (no manifest: an unfinished conversion or not a store), kDamaged.
Manifest readManifest(const std::filesystem::path& store);

}  // namespace kiln
