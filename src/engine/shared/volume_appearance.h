// Colours, light and scales of a volume as a frame shows it.
#pragma once

#include "engine/shared/companion_colors.h"
#include "engine/shared/shade.h"
#include "scene/camera/camera.h"
#include "scene/clipping.h"
#include "scene/render_options.h"
#include "scene/shading.h"
#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// requires: the references outlive the engines made of this.
struct VolumeAppearance {
  const TransferFunction& transfer_function;
  Shading shading;  // as the function reflects or scatters it
  const View& view;
  double unit = 1;  // length that opacities refer to. unit: world
  GradientSense gradients;
  Interpolation interpolation = Interpolation::kLinear;
  const Illumination* illumination = nullptr;  // null without shadows
  const CompanionColors* colors = nullptr;     // colours of another volume's values; null: the function's own
  const Section* section = nullptr;            // look of cut faces, with a window for a colour map; null: as elsewhere

  /// requires: as above; not the manifest.
  VolumeAppearance(const Manifest& volume, const TransferFunction& function, const Shading& light, const View& from,
                   Interpolation between = Interpolation::kLinear, const Illumination* shadows = nullptr)
      : transfer_function(function),
        shading(shadingOf(function, light)),
        view(from),
        unit(function.unitIn(volume.geometry().meanSpacing())),
        gradients(gradientSenseOf(volume, function)),
        interpolation(between),
        illumination(shadows) {}
};

}  // namespace kiln
