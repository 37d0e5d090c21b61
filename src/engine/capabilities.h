// The engines by name, and the choice among them.
#pragma once

#include "scene/render_options.h"

namespace kiln {

/// - kPixel, kVoxel: light of one volume, by the positions of samples (Lattice).
/// - kProjection: a value of one volume along each ray.
/// - kMultiVolume: light of several volumes.
enum class EngineKind { kPixel, kVoxel, kProjection, kMultiVolume };

/// The options that choose an engine.
struct EngineChoice {
  Mode mode = Mode::kComposite;
  Lattice lattice = Lattice::kPixel;
  bool several_volumes = false;

  EngineKind kind() const;
};

}  // namespace kiln
