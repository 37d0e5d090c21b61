// The phantoms by name: figure, box and value table of each.
#pragma once

#include <span>
#include <string_view>

#include "grid/geometry.h"
#include "grid/voxel_type.h"
#include "phantom/sampler.h"

namespace kiln::phantom {

struct PhantomKind {
  std::string_view name;
  /// The box divided into voxels at any size: spacing = extent / dims along each axis. unit: mm.
  glm::dvec3 corner_mm, extent_mm;
  /// Size of the published volume that the phantom replaces.
  Extent3 usual_dims;
  VoxelType type;
  PatientFrame frame;
  const ValueTable& (*values)();
  PartList (*parts)();
};

/// body, head, brain, engine.
std::span<const PhantomKind> phantomKinds();
/// Returns null if no phantom has this name.
const PhantomKind* findPhantom(std::string_view name);

/// A phantom at one size. thread: const members are safe.
class Phantom {
 public:
  Phantom(const PhantomKind& kind, const Extent3& dims);

  const PhantomKind& kind() const { return kind_; }
  const Figure& figure() const { return figure_; }
  const Lattice& lattice() const { return lattice_; }
  const ValueTable& values() const { return kind_.values(); }
  /// Maps voxels to the world, in millimetres.
  VolumeGeometry geometry() const;
  /// Fills `out` as VolumeSource::read does. requires: box inside; `out` of box.count() voxels of kind().type.
  void read(const VoxelBox& box, std::span<std::byte> out) const;

 private:
  const PhantomKind& kind_;
  Figure figure_;
  Lattice lattice_;
};

}  // namespace kiln::phantom
