// The keys of manifest.json that describe a volume, whatever holds it: a store or a volume file.
// Internal, not installed.
#pragma once

#include <nlohmann/json.hpp>

#include "store/manifest/manifest.h"

namespace kiln {

/// Returns the keys from "dimensions" to "frame". A range without values is null; strings may not be UTF-8 (jsonText).
nlohmann::ordered_json volumeJson(const Manifest& manifest);

}  // namespace kiln
