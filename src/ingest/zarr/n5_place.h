// The axes of an N5 array, as the programs around N5 describe them: names, units, sizes and places.
#pragma once

#include <optional>
#include <vector>

#include "ingest/chunks/array_volume.h"
#include "ingest/zarr/zarr_array.h"

namespace kiln {

/// Describes `axes` by the attributes of the array or of `above`, the group of its scales; its own attributes have
/// precedence. `scale` is the array's number in the group. Returns false if there is no size.
/// throws: Error kFormat for lists of other values than numbers or texts.
bool placeN5(const ZarrArray& array, const std::optional<JsonNode>& above, std::optional<std::size_t> scale,
             std::vector<ArrayAxis>& axes);

}  // namespace kiln
