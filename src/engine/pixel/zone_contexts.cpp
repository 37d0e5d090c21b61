#include "engine/pixel/zone_contexts.h"

namespace kiln {

ZonedVolume zonedVolume(const Manifest& volume, const FrameLevels& levels, const Sampling& sampling) {
  return {&volume,           levels.projector(levels.finest()).nearDepth(),
          sampling.distance, sampling.quincunx,
          sampling.finest,   sampling.coarser};
}

std::optional<SampleTable> colorTable(const VolumeAppearance& look) {
  if (look.colors == nullptr) return std::nullopt;
  return SampleTable(look.colors->function, look.unit, look.colors->type, look.colors->range);
}

std::unique_ptr<SlabContext> zoneContext(const SlabZone& zone, const FrameLevels& levels, const VolumeTables& tables,
                                         const VolumeAppearance& look) {
  const Projector& projector = levels.projector(zone.level);
  const Appearance of_sample{look.shading,
                             Shader(look.shading, look.view, look.gradients, projector, look.illumination),
                             &levels.clipRegion(zone.level),
                             look.gradients,
                             look.interpolation,
                             !look.transfer_function.surfaces.empty(),
                             tables.colors,
                             tables.faces};
  return std::make_unique<SlabContext>(zone, projector, levels.dims(zone.level), tables.own, of_sample);
}

bool anyPartIn(const SlabContext& context, const VoxelBox& core, std::int64_t brick_size, const BrickEntry& entry,
               const RectTest& test) {
  const auto shows = [&](const ValueRange& range, const VoxelBox& samples) {
    return context.interesting(range) || context.coloursFace(samples, range);
  };
  if (!shows(entry.support, core)) return false;
  const auto passes = [&](const VoxelBox& samples) {
    if (context.cutOff(samples)) return false;
    const PixelRect rect = context.boundsOf(samples);
    return !rect.empty() && test(rect);
  };
  if (!entry.sub_ranges) return passes(core);
  const SubRanges& ranges = *entry.sub_ranges;
  return ranges.any([&](std::size_t i, const VoxelCoord& at) {
    const VoxelBox part = subBrickOf(core, brick_size, ranges.along(), at);
    return shows(ranges.at(i, entry.support), part) && passes(part);
  });
}

}  // namespace kiln
