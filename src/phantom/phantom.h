// The phantoms by name: which figure, seen through which window, by which machine.
#pragma once

#include <span>
#include <string_view>

#include "grid/geometry.h"
#include "grid/voxel_type.h"
#include "phantom/sampler.h"

namespace kiln::phantom {

struct PhantomKind {
  std::string_view name;
  /// The box that the voxels divide, whatever their number: spacing = extent / dims, axis by axis. unit: mm.
  glm::dvec3 corner_mm, extent_mm;
  /// The size of the published volume whose place this one takes.
  Extent3 usual_dims;
  VoxelType type;
  PatientFrame frame;
  const ValueTable& (*values)();
  PartList (*parts)();
};

/// body, head, brain, engine.
std::span<const PhantomKind> phantomKinds();
/// Null where there is none of that name.
const PhantomKind* findPhantom(std::string_view name);

/// A phantom at one size. thread: any number may read at once.
class Phantom {
 public:
  Phantom(const PhantomKind& kind, const Extent3& dims);

  const PhantomKind& kind() const { return kind_; }
  const Figure& figure() const { return figure_; }
  const Lattice& lattice() const { return lattice_; }
  const ValueTable& values() const { return kind_.values(); }
  /// Voxel to world, in the phantom's own millimetres.
  VolumeGeometry geometry() const;
  /// Fills `out` as VolumeSource::read does. requires: box inside; `out` of box.count() voxels of kind().type.
  void read(const VoxelBox& box, std::span<std::byte> out) const;

 private:
  const PhantomKind& kind_;
  Figure figure_;
  Lattice lattice_;
};

}  // namespace kiln::phantom
