#include "sequence/frame_requests.h"

#include "frame/background.h"
#include "job/stereo.h"
#include "scene/camera/lens.h"

namespace kiln {

FrameRequest requestOf(const FrameScene& scene, const SpeedOptions& speed) {
  FrameRequest out = frameRequest(scene.picture, speed, scene.camera, scene.transfer_function);
  for (const VolumeScene& volume : scene.volumes)
    out.volumes.push_back({inWorld(volume.transfer_function, volume.world_per_own), volume.shading, volume.clipping});
  return out;
}

FrameRequest frameRequest(const PictureOptions& picture, const SpeedOptions& speed, const Camera& camera,
                          const TransferFunction& transfer_function) {
  FrameRequest request;
  request.view = resolve(camera, picture.stereo, picture.size);
  request.eyes = viewsThrough(picture.lens, request.view, camera);
  request.transfer_function = transfer_function;
  request.shading = picture.shading;
  request.clipping = picture.clipping;
  request.background = drawnBackground(picture, transfer_function);
  request.opacity_threshold = picture.opacity_threshold;
  request.mode = picture.mode;
  request.attenuation = picture.attenuation;
  request.lattice = picture.lattice;
  request.interpolation = picture.interpolation;
  request.sample_distance = picture.sample_distance;
  request.crop = picture.crop;
  request.samples = picture.samples.value_or(1);
  request.aovs = picture.aovs;
  request.level = picture.level;
  request.coarser = picture.coarser;
  request.visibility = speed.visibility;
  request.tile_px = speed.tile_px;
  return request;
}

}  // namespace kiln
