// ParaView's colour-map JSON, as its editor exports it and as collections of maps are shared: an object, or a list of
// them, with RGBPoints [value, r, g, b, …], ColorSpace, and where it has opacity Points [value, opacity, midpoint,
// sharpness, …].
#pragma once

#include <optional>
#include <string>

#include "job/job_json.h"
#include "scene/transfer/color_map.h"

namespace kiln {

struct ParaViewMap {
  ColorMap colors;
  std::optional<OpacityCurve> opacity;
  /// Whether the colours run from 0 to 1: such a map is made for any data and is stretched over the data's range, with
  /// its opacity.
  bool normalised() const;
};

/// Returns whether the object has the keys of a ParaView colour map.
bool isParaViewMap(const JobObject& object);

/// Keys that say nothing about colour or opacity are passed over, NanColor too, for NaN is transparent here. throws:
/// Error kUsage naming the key (wrong counts, colours outside 0..1, nothing but categories), kUnsupported for a
/// logarithmic scale.
ParaViewMap paraViewMapFrom(const JobObject& object);

}  // namespace kiln
