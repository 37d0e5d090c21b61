// What of the volume a picture shows: a box of voxels and any number of half-spaces of the world. Of both, every level
// of the pyramid has its own half-spaces in its own index space, so that a voxel is asked by products and sums alone. A
// voxel is shown where its centre is inside, and of a sample between voxels the part that is. Within a voxel of a face
// it is lit by the face's normal, so that a cut is plain (DESIGN §6): a voxel, because then there is a layer of voxels
// to show it, wherever the face runs between them.
#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

#include "grid/geometry.h"

namespace kiln {

/// Shows where normal·x + offset >= 0, x in the world. requires: a normal of finite, positive length; any is legal.
struct ClipPlane {
  glm::dvec3 normal{0, 0, 1};
  double offset = 0;
  bool operator==(const ClipPlane&) const = default;
};

/// All of it must hold; nothing said shows everything.
struct Clipping {
  std::optional<VoxelBox> region;  // of level 0
  std::vector<ClipPlane> planes;
  /// Of level 0. Not a cut: of the whole picture, what lies in the box is drawn as it is there, with what is beside the
  /// box known for interpolation and footprints, so that the pictures of boxes that fill the volume make the whole one.
  std::optional<VoxelBox> part = {};
  /// So many of the planes, the first ones, are the faces of a box of the world, which options replace by themselves.
  std::size_t box_faces = 0;
  /// Of what is shown.
  bool operator==(const Clipping& other) const {
    return region == other.region && planes == other.planes && part == other.part;
  }
};

/// The planes that show a box of the world, its faces included. requires: lo below hi along each axis.
std::vector<ClipPlane> facesOf(const glm::dvec3& lo, const glm::dvec3& hi);

/// throws: Error kUsage where the box of the world (Clipping::box_faces) holds nothing of the volume.
void requireWorldBox(const Clipping& clipping, const VolumeGeometry& volume);

class ClipRegion {
 public:
  enum class Overlap { kOutside, kCut, kInside };

  /// Shows everything.
  ClipRegion() = default;
  /// For a level whose voxels span `span` voxels of level 0 along each axis. Faces of the region at the volume's border
  /// or beyond clip nothing. throws: Error kUsage where no voxel of the volume is in the region, or in the part.
  ClipRegion(const Clipping& clipping, const VolumeGeometry& finest, const Extent3& span = {1, 1, 1});

  bool showsAll() const noexcept { return half_spaces_.empty(); }

  /// `index` is a place in the level's index space, voxel centres at whole numbers. Two regions that share a face share
  /// no point of it: like a box of voxels, a region holds its lower faces and not its upper ones.
  bool contains(const glm::dvec3& index) const noexcept;

  /// How much is inside of a stretch of a ray whose middle is `index`, and that is `along` from end to end: 1 where all
  /// of it is, and of regions that share a face 1 together. unit: voxels.
  double shareOf(const glm::dvec3& index, const glm::dvec3& along) const noexcept;

  /// The planes between the part and the rest of the volume, in the level's index space; infinite where there is no
  /// rest. The part holds its lower planes and not its upper ones.
  struct Part {
    glm::dvec3 lo{-std::numeric_limits<double>::infinity()}, hi{std::numeric_limits<double>::infinity()};
    bool all() const { return *this == Part(); }
    bool operator==(const Part&) const = default;
    /// Voxels whose centres lie in the part, and perhaps voxels beyond the volume.
    VoxelBox voxels() const noexcept;
    /// Whether any of the voxels' cubes reaches into it.
    bool touches(const VoxelBox& voxels) const noexcept;
  };
  const Part& part() const noexcept { return part_; }

  /// Leaves the t of [lo, hi] at which base + t · slope, in the level's index space, is inside; its ends may be on
  /// faces that are not.
  void cutLine(const glm::dvec3& base, const glm::dvec3& slope, double& lo, double& hi) const noexcept;

  /// For all points of the voxels' cubes: none is inside (kOutside), or all are, and none has a
  /// `cutGradient` (kInside).
  Overlap classify(const VoxelBox& voxels) const noexcept;

  /// What the shader takes for the gradient of a sample less than a voxel's extent (along the normal) inside of a face:
  /// the normal of the nearest such face, in the level's index space, any length above zero; null where there is none.
  /// requires: some of what is at `index` is inside.
  const glm::vec3* cutGradient(const glm::dvec3& index) const noexcept;

 private:
  // Shows where normal·p + offset >= least.
  struct HalfSpace {
    glm::dvec3 normal;
    double offset, least;
    double voxel;           // how far normal·p changes over a voxel's cube
    double world_distance;  // of a unit of normal·p
    glm::vec3 gradient;
  };
  void add(const glm::dvec3& normal, double offset, double least, const VolumeGeometry& finest, const Extent3& span);
  std::vector<HalfSpace> half_spaces_;
  Part part_;
};

}  // namespace kiln
