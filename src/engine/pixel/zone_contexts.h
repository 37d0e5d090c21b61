// Per-zone state of a volume, and visible bricks in a zone: shared by frames of one volume and of several.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/brick_selection.h"
#include "engine/pixel/slab_context.h"
#include "engine/shared/tile_pixels.h"
#include "engine/shared/volume_appearance.h"
#include "scene/sampling.h"
#include "traverse/frame_levels.h"

namespace kiln {

/// Parameters of a volume's slabs. requires: the manifest outlives the result.
ZonedVolume zonedVolume(const Manifest& volume, const FrameLevels& levels, const Sampling& sampling);

/// Tables of a volume: of its own values, of the values of the companion that colours it, and of its cut faces, if
/// there are any.
struct VolumeTables {
  const SampleTable& own;
  const SampleTable* colors = nullptr;
  const CutFaces* faces = nullptr;  // null: none that show values
};
inline VolumeTables tablesOf(const SampleTable& own, const std::optional<SampleTable>& colors, const CutFaces* faces) {
  return {own, colors ? &*colors : nullptr, faces};
}
/// Returns the table of the companion's colours; nothing without such a companion.
std::optional<SampleTable> colorTable(const VolumeAppearance& look);

/// requires: all outlive the result.
std::unique_ptr<SlabContext> zoneContext(const SlabZone& zone, const FrameLevels& levels, const VolumeTables& tables,
                                         const VolumeAppearance& look);

/// Implements VisiblePart for a brick with the voxels of `core` in the context's zone; parts are sub-bricks
/// (store/ranges/sub_bricks.h).
bool anyPartIn(const SlabContext& context, const VoxelBox& core, std::int64_t brick_size, const BrickEntry& entry,
               const RectTest& test);

}  // namespace kiln
