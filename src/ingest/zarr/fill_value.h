// The value of chunks that do not exist.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "ingest/chunks/stored_number.h"
#include "ingest/zarr/zarr_json.h"

namespace kiln {

/// Returns the voxel that `value` stands for; 0 without a value. throws: Error kFormat if the value is no number of the
/// array's type.
std::array<std::byte, 8> fillOf(const std::optional<JsonNode>& value, const StoredNumber& number);

}  // namespace kiln
