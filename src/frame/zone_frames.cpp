#include "frame/zone_frames.h"

namespace kiln {
namespace {

// Where the samples of a sub-brick are, with those of the apron beside it, which no other has.
VoxelBox samplesOf(VoxelBox sub_brick, const VoxelBox& core, const VoxelBox& reach) {
  for (int axis = 0; axis < 3; ++axis) {
    if (sub_brick.lo[axis] == core.lo[axis]) sub_brick.lo[axis] = reach.lo[axis];
    if (sub_brick.hi[axis] == core.hi[axis]) sub_brick.hi[axis] = reach.hi[axis];
  }
  return sub_brick;
}

}  // namespace

ZonedVolume zonedVolume(const Manifest& volume, const FrameLevels& levels, const TransferFunction& transfer_function,
                        const SampleTable& table, const Sampling& sampling) {
  const double spacing = volume.geometry().meanSpacing();
  SoftSamples soft = table.thinAnywhere(spacing) ? SoftSamples::kAnyway : SoftSamples::kWhereFree;
  // Labels have edges, and gradients may take all of an opacity away.
  if (table.ofLabels() || !transfer_function.gradient_opacity.empty()) soft = SoftSamples::kNever;
  return {&volume,
          levels.projector(levels.finest()).nearDepth(),
          steepnessOf(transfer_function, spacing, volume.range),
          soft,
          sampling.distance,
          sampling.on_rays,
          sampling.quincunx};
}

std::unique_ptr<SlabFrame> zoneFrame(const SlabZone& zone, const FrameLevels& levels, const SampleTable& table,
                                     const VolumeLook& look, const SlabSharing& sharing) {
  const Projector& projector = levels.projector(zone.level);
  const SampleLook of_sample{look.shading,
                             Shader(look.shading, look.view, look.gradient_noise, projector),
                             GradientOpacity(look.transfer_function, look.unit, projector),
                             &levels.clipRegion(zone.level),
                             look.gradient_noise,
                             look.interpolation};
  return std::make_unique<SlabFrame>(zone, projector, levels.dims(zone.level), levels.endVoxels(zone.level), table,
                                     of_sample, sharing);
}

bool anyPartIn(const SlabFrame& frame, const VoxelBox& core, std::int64_t brick_size, const BrickEntry& entry,
               const BrickWalk::PartTest& test) {
  if (!frame.interesting(entry.support)) return false;
  const VoxelBox volume = boxOf(frame.dims()), reach = intersection(dilated(core, frame.ghosts()), volume);
  const auto passes = [&](const VoxelBox& samples) {
    if (frame.cutOff(samples)) return false;
    const SlabFrame::Bounds bounds = frame.boundsOf(samples);
    return !bounds.empty() && test(bounds.rect);
  };
  if (!entry.sub_ranges) return passes(reach);
  const SubRanges& ranges = *entry.sub_ranges;
  return ranges.any([&](std::size_t i, const VoxelCoord& at) {
    return frame.interesting(ranges.at(i, entry.support)) &&
           passes(samplesOf(subBrickOf(core, brick_size, ranges.along(), at), core, reach));
  });
}

std::vector<TilePixels> squaresOf(const TilePixels& tile, int edge) {
  std::vector<TilePixels> out;
  for (int y = tile.rect.y0; y < tile.rect.y1; y += edge) {
    for (int x = tile.rect.x0; x < tile.rect.x1; x += edge)
      out.push_back(tile.of(intersection(PixelRect{x, y, x + edge, y + edge}, tile.rect)));
  }
  return out;
}

}  // namespace kiln
