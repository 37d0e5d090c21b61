// ParaView's colour-map JSON, as exported by its editor and shared in collections: an object or a list of objects, with
// RGBPoints [value, r, g, b, …], ColorSpace, and for opacity Points [value, opacity, midpoint, sharpness, …].
#pragma once

#include <optional>
#include <string>

#include "job/json/job_json.h"
#include "scene/transfer/color_map.h"

namespace kiln {

struct ParaViewMap {
  ColorMap colors;
  std::optional<OpacityCurve> opacity;
  /// True if the colours run from 0 to 1. Such a map, with its opacity, is stretched over the range of the data.
  bool normalised() const;
};

/// Returns whether the object has the keys of a ParaView colour map.
bool isParaViewMap(const JobObject& object);

/// Ignores keys without effect on colour or opacity, and NanColor, because NaN is transparent. throws: Error kUsage
/// naming the key (wrong counts, colours outside 0..1, categories only), kUnsupported for a logarithmic scale.
ParaViewMap paraViewMapFrom(const JobObject& object);

}  // namespace kiln
