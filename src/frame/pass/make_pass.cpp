#include "frame/pass/make_pass.h"

#include <utility>

#include "engine/pixel/multi_volume.h"
#include "engine/pixel/pixel_engine.h"
#include "engine/projection/value_projection.h"
#include "engine/voxel/voxel_engine.h"
#include "frame/pass/brick_pass.h"
#include "frame/pass/channels_pass.h"
#include "frame/pass/value_pass.h"
#include "frame/pass/zone_pass.h"

namespace kiln {
namespace {

// The octree above bricks takes some 16 bytes a brick and a seventh; a list of bricks in view comes on top. unit:
// bytes.
constexpr std::uint64_t kWalkBytes = 19 + sizeof(BrickInView);

// The picture of one of several channels, beside their sum. unit: bytes of a pixel.
constexpr std::uint64_t kChannelBytes = 16;

// The quadtree tests nodes only (VisibilityOptions::test_samples).
bool testsSamples(const VisibilityOptions& options) {
  return options.test_samples && options.method != VisibilityMethod::kNone &&
         options.method != VisibilityMethod::kQuadtree;
}

std::unique_ptr<FramePass> makeZonePass(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request) {
  std::vector<MixedVolume> volumes;
  for (std::size_t i = 0; i < request.volumes.size(); ++i) {
    const VolumeRequest& volume = request.volumes[i];
    volumes.push_back({stores.at(i), volume.transfer_function, volume.shading, volume.clipping, volume.colors});
  }
  return std::make_unique<ZonePass>(
      std::move(volumes),
      MixView{request.view, request.visibility.area, request.sampling(), request.illumination.get()}, request.tile_px);
}

PixelValue projectedBy(Mode mode) {
  switch (mode) {
    case Mode::kMinip:
      return PixelValue::kLeast;
    case Mode::kAverage:
      return PixelValue::kMean;
    case Mode::kAttenuatedMip:
      return PixelValue::kAttenuated;
    case Mode::kComposite:
    case Mode::kMip:
      break;
  }
  return PixelValue::kGreatest;
}

// Values count from the function's first point to its last, as colours do.
Attenuation attenuationOf(const FrameRequest& request, const Manifest& volume) {
  Attenuation out;
  const std::vector<TransferPoint>& points = request.transfer_function.points;
  out.per_length = request.attenuation / volume.geometry().meanSpacing();
  if (!points.empty()) out.lo = points.front().value, out.hi = points.back().value;
  return out;
}

std::unique_ptr<ValuePass> makeValuePass(const BrickedVolume& store, const FrameRequest& request, int place) {
  auto levels = std::make_unique<const FrameLevels>(store.manifest(), request.level, request.view,
                                                    request.visibility.area, request.clipping);
  auto projection =
      std::make_unique<ValueProjection>(store, *levels, request.view,
                                        ProjectionOptions{projectedBy(request.mode), request.level, request.coarser,
                                                          request.visibility.method != VisibilityMethod::kNone,
                                                          attenuationOf(request, store.manifest())});
  return std::make_unique<ValuePass>(store, request, std::move(levels), std::move(projection), place);
}

}  // namespace

EngineMemory passMemory(const EngineChoice& engine, bool layers, const ImageSize& tile, std::int64_t brick_size) {
  EngineMemory out;
  switch (engine.kind()) {
    case EngineKind::kPixel:
      out = PixelEngine::memory(brick_size);
      out.stored_brick = kWalkBytes;
      break;
    case EngineKind::kVoxel:
      out = VoxelEngine::memory(tile);
      out.stored_brick = kWalkBytes;
      break;
    case EngineKind::kProjection:
      out = ValueProjection::memory(projectedBy(engine.mode));
      out.stored_brick = kWalkBytes + sizeof(BrickInView);  // a second list, in the order of values
      if (engine.several_volumes) out.pixel += kChannelBytes;
      break;
    case EngineKind::kMultiVolume:
      out = MultiVolume::memory(brick_size, layers);
      break;
  }
  return out;
}

std::unique_ptr<FramePass> makePass(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request) {
  const EngineKind kind = request.engine().kind();
  if (kind == EngineKind::kMultiVolume) return makeZonePass(stores, request);
  if (kind == EngineKind::kProjection) {
    if (!request.volumes.empty()) return std::make_unique<ChannelsPass>(stores, request, &makeValuePass);
    return makeValuePass(*stores.front(), request, 0);
  }
  const BrickedVolume& store = *stores.front();
  const Manifest& volume = store.manifest();
  auto levels = std::make_unique<const FrameLevels>(volume, request.level, request.view, request.visibility.area,
                                                    request.clipping);
  VolumeAppearance appearance(volume, request.transfer_function, request.shading, request.view, request.interpolation,
                              request.illumination.get());
  appearance.colors = request.colors.get();
  if (request.clipping.section) appearance.section = &*request.clipping.section;
  std::unique_ptr<VolumeEngine> engine;
  if (kind == EngineKind::kVoxel)
    engine = std::make_unique<VoxelEngine>(volume, *levels, appearance,
                                           VoxelTests{testsSamples(request.visibility), request.node_log});
  else
    engine = std::make_unique<PixelEngine>(volume, *levels, request.sampling(), appearance);
  return std::make_unique<BrickPass>(store, request, std::move(levels), std::move(engine));
}

}  // namespace kiln
