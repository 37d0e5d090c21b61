// The request of one frame: every choice about the picture made, and the number of bricks, rows and pixels at a time.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/capabilities.h"
#include "engine/shared/companion_colors.h"
#include "engine/shared/extinction_lattice.h"
#include "engine/shared/illumination.h"
#include "image/deep_samples.h"
#include "image/pixel_rect.h"
#include "scene/camera/camera.h"
#include "scene/clipping.h"
#include "scene/render_options.h"
#include "scene/sampling.h"
#include "scene/shading.h"
#include "scene/transfer/transfer_function.h"
#include "traverse/node_log.h"

namespace kiln {

/// The appearance of one of several volumes in a frame.
struct VolumeRequest {
  TransferFunction transfer_function;
  Shading shading;
  Clipping clipping;
  std::shared_ptr<const CompanionColors> colors{};  // of another volume's values; null: the function's own
};

/// Most bricks drawn together. After each set, threads wait for the last tile of the set: with four bricks for up to a
/// tenth of the time.
inline constexpr int kMostBricksTogether = 32;
/// Bricks that keep the threads busy. Fewer bricks wait for more, even if memory is short or the waiting bricks may
/// hide the next brick.
inline constexpr int kEnoughBricksTogether = 4;

/// The request of a frame: everything but the volume, with every choice made.
struct FrameRequest {
  View view;
  /// The views of a lens, whose mean is the picture; the planes are the first view's. Empty: `view` alone.
  std::vector<View> eyes;
  TransferFunction transfer_function;
  Shading shading;
  Clipping clipping;
  std::shared_ptr<const CompanionColors> colors;  // VolumeRequest::colors
  Background background;
  double opacity_threshold = 0.998;
  Mode mode{};
  double attenuation = kAttenuation;  // PictureOptions'
  Lattice lattice{};
  Interpolation interpolation = Interpolation::kLinear;
  double sample_distance = kSampleDistance;  // Sampling's
  std::optional<PixelRect> crop;             // the pixels of the whole picture to draw; all if absent
  int samples = 1;                           // sub-pixels of a pixel: 1, 2, 4 or 16
  bool filters_rays = true;       // rays: pixels are made by PixelFilter; else pixels are means of sub-pixels
  Aovs aovs;                      // planes of the image
  std::optional<DeepBound> deep;  // the image has deep samples, too; of light in slabs, samples == 1, unfiltered
  std::optional<int> level;       // one level for the frame; if absent, levels with voxels of about a pixel
  int coarser = 0;                // levels by which the picture is coarser (Sampling); not of the voxel engine
  Sampling sampling() const { return {level, interpolation, sample_distance, samples == 2, samples == 16, coarser}; }
  VisibilityOptions visibility;
  int tile_px = 64;                           // as in SpeedOptions
  int bricks_together = kMostBricksTogether;  // bricks in memory drawn together; no bit depends on the number
  int band_px = 1024;  // rows of sub-pixels drawn together, in steps of kVisibilityTile; no bit depends on the number
  /// Shadows of the lights, drawn before the frame; null: none yet, or no shadows.
  std::shared_ptr<const Illumination> illumination;
  /// The shadows of an earlier frame, replaced by this frame's: lights that stay have equal shadows. Null: none.
  std::shared_ptr<const Illumination>* last_illumination = nullptr;
  DeepShadowMap* shadows = nullptr;  // the map to draw instead of a picture; requires: its view, samples == 1
  /// The lattice to draw instead of a picture; requires: its view, and `volumes`, perhaps of one.
  ExtinctionLattice* extinction = nullptr;
  NodeLog* node_log = nullptr;  // requires: tile_px == 0 and a level
  EngineChoice engine() const { return {mode, lattice, !volumes.empty()}; }
  /// All of several volumes; transfer function, shading and clipping above are then ignored.
  std::vector<VolumeRequest> volumes;
};

}  // namespace kiln
