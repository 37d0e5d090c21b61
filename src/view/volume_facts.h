// Facts about a session's volumes as JSON, for the page.
#pragma once

#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>

#include "sequence/opened_volumes.h"

namespace kiln {

/// Returns [x, y, z].
nlohmann::ordered_json vectorJson(const glm::dvec3& v);

/// Returns name, size, type, spacing, unit, affine, views of slices, range, levels, histogram and labels of each
/// volume.
nlohmann::ordered_json volumeFacts(const OpenedVolumes& volumes);

/// Returns the box of the world around all volumes: {"min", "max"}.
nlohmann::ordered_json worldBox(const OpenedVolumes& volumes);

}  // namespace kiln
