// The value of chunks that do not exist.
#pragma once

#include <optional>

#include "ingest/chunks/chunked_array.h"
#include "ingest/source/json_node.h"

namespace kiln {

/// Sets `out.fill` to the voxel that `value` stands for, 0 without a value, or `out.fill_fault`. requires: `out.number`
/// is set. throws: Error kFormat if the value is no number.
void readFill(const std::optional<JsonNode>& value, ChunkLayout& out);

}  // namespace kiln
