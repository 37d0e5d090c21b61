#include "engine/capabilities.h"

namespace kiln {

EngineKind EngineChoice::kind() const {
  if (mode != Mode::kComposite) return EngineKind::kProjection;
  if (lattice == Lattice::kVoxel) return EngineKind::kVoxel;
  return several_volumes ? EngineKind::kMultiVolume : EngineKind::kPixel;
}

}  // namespace kiln
