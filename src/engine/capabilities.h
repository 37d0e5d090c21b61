// The engines, the choice among them, and a table of what each engine can do.
// Every refusal of an option by an engine, and the table of limits of the manual, are made of this table.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/render_options.h"
#include "scene/sampling.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

/// - kPixel, kVoxel: light of one volume, by the positions of samples (Lattice).
/// - kProjection: a value along each ray, of each volume in its own colours.
/// - kMultiVolume: light of several volumes.
enum class EngineKind { kPixel, kVoxel, kProjection, kMultiVolume };

/// A row names what the engine can do.
struct EngineCapabilities {
  EngineKind kind;
  std::string_view chosen_by;     // options of the command line
  bool several_volumes = false;   // draws several volumes in one picture
  bool composites = false;        // draws light that opacity attenuates; opaque pixels hide bricks
  bool labels = false;            // draws volumes of labels
  bool gradient_opacity = false;  // opacity can depend on the gradient
  bool surfaces = false;          // draws iso-surfaces
  bool cubic = false;             // interpolates by cubics, besides linearly
  bool sample_distance = false;   // the distance of samples along a ray can be chosen
  bool coarser_levels = false;    // the automatic level can be made coarser
  bool filters_rays = false;      // samples of a pixel are rays of light: automatic number, pixel filter, two a pixel
  bool depth_and_normal = false;  // has planes of depth and normals
  bool value = false;             // has a plane of values
  bool companions = false;        // draws volumes with masks or colours of another volume
  bool sections = false;          // cut faces can show the values there
  bool deep = false;              // draws deep images
  bool parts = false;             // draws partial images, also of ranks that share bricks
};

/// The table: one row per engine.
const std::vector<EngineCapabilities>& engineCapabilities();

/// The options that choose an engine.
struct EngineChoice {
  Mode mode = Mode::kComposite;
  Lattice lattice = Lattice::kPixel;
  bool several_volumes = false;

  EngineKind kind() const;
  const EngineCapabilities& capabilities() const;
  /// Returns the engine in the words of the command line: "--mode mip".
  std::string text() const;
};

/// A column of the table.
using Capability = bool EngineCapabilities::*;

/// throws: Error kUsage unless the chosen engine has the capability: "SUBJECT ENGINES (found ENGINE); REMEDY".
/// `subject` ends with a verb: "--part: needs".
void requireCapability(const EngineChoice& engine, Capability capability, std::string_view subject,
                       std::string_view remedy);

/// Options of a picture whose support depends on the engine.
struct EngineOptions {
  Interpolation interpolation = Interpolation::kLinear;
  int samples = 1;                           // per pixel
  double sample_distance = kSampleDistance;  // unit: voxels
  Aovs aovs;
  int coarser = 0;  // unit: levels
};
/// throws: Error kUsage if the engine lacks an option, if the choice of the engine contradicts itself, or if the
/// distance of samples is out of range.
void requireOptions(const EngineChoice& engine, const EngineOptions& options);

/// throws: Error kUsage if the function has surfaces and the chosen engine draws none.
void requireSurfaces(const EngineChoice& engine, const TransferFunction& function);

/// Returns the table as Markdown: a row per capability, a column per engine.
std::string capabilityTable();

}  // namespace kiln
