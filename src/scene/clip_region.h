// The visible part of a volume: a box of voxels and any number of half-spaces of the world.
// Method. Both become half-spaces in the index space of each level, so that testing a voxel takes only products and
// sums. A voxel is shown if its centre is inside; a sample between voxels is shown by the share inside.
// Shading. Within a voxel of a face, samples are lit by the face's normal, so that a cut looks flat. The distance is a
// whole voxel, because only then is there a layer of voxels to show the face, wherever it runs between voxels. The
// border of the volume is lit as a face, too: beyond the border there are no values, and gradients at the border are
// noise. Beside two faces, the face through which the ray entered lights the sample, so that an edge between faces is
// as sharp as the picture; by the shortest distance, samples would alternate along the edge with the period of the
// slabs. A face that looks away from the eye lights nothing: a ray that leaves through the face would show a dark line.
// Samples that stand for a piece of a ray are lit by the face in part (engine/pixel/decisions/pieces.md).
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <vector>

#include "grid/geometry.h"
#include "scene/clipping.h"

namespace kiln {

/// Returns the planes that show a box of the world, its faces included. requires: lo below hi along each axis.
std::vector<ClipPlane> facesOf(const glm::dvec3& lo, const glm::dvec3& hi);

/// throws: Error kUsage if the box of the world (Clipping::box_faces) contains no part of the volume.
void requireWorldBox(const Clipping& clipping, const VolumeGeometry& volume);

class ClipRegion {
 public:
  enum class Overlap { kOutside, kCut, kInside };

  /// Shows everything, of a volume without a border.
  ClipRegion() = default;
  /// Builds the region for a level whose voxels span `span` voxels of level 0 along each axis. Faces at the volume's
  /// border or beyond clip nothing. The border of the volume clips nothing, but is lit as a face. throws: Error kUsage
  /// if no voxel of the volume is in the region, or in the part.
  ClipRegion(const Clipping& clipping, const VolumeGeometry& finest, const Extent3& span = {1, 1, 1});

  bool showsAll() const noexcept { return half_spaces_.empty(); }

  /// Returns the half-spaces in the level's index space: points p with normal·p + w >= 0, normal the first three.
  std::vector<glm::dvec4> halfSpaces() const;
  /// A face that ends or lights samples.
  struct Face {
    glm::dvec4 half_space;  // in the level's index space, as of halfSpaces()
    bool cuts;              // matter ends at the face; the volume's border only lights samples
    bool open;              // the points of the face are outside: an upper face of a region
  };
  /// Returns the faces of the region, then those of the volume's border.
  std::vector<Face> faces() const;

  /// `index` is a position in the level's index space, with voxel centres at integers. Adjacent regions share no point:
  /// a region contains its lower faces and not its upper faces, like a box of voxels.
  bool contains(const glm::dvec3& index) const noexcept;

  /// The planes between the part and the rest of the volume, in the level's index space; infinite if there is no rest.
  /// The part contains its lower planes and not its upper planes.
  struct Part {
    glm::dvec3 lo{-std::numeric_limits<double>::infinity()}, hi{std::numeric_limits<double>::infinity()};
    bool all() const { return *this == Part(); }
    bool operator==(const Part&) const = default;
    /// Returns voxels whose centres lie in the part, possibly beyond the volume.
    VoxelBox voxels() const noexcept;
    /// True if a voxel's cube reaches into the part.
    bool touches(const VoxelBox& voxels) const noexcept;
  };
  const Part& part() const noexcept { return part_; }

  /// Reduces [lo, hi] to the t at which base + t · slope, in the level's index space, is inside. The ends may lie on
  /// faces that are not part of the region.
  void cutLine(const glm::dvec3& base, const glm::dvec3& slope, double& lo, double& hi) const noexcept;

  /// Classifies the voxels' cubes: kOutside if no point is inside; kInside if all points are inside and without a
  /// `cutGradient`; else kCut.
  Overlap classify(const VoxelBox& voxels) const noexcept;

  /// Cosine of the angle to the eye below which a face counts as seen edge-on.
  static constexpr double kEdgeOn = 1e-6;

  /// Returns the shading gradient of a sample: the normal of the face, of a cut or of the volume's border, that is
  /// nearest towards the eye, in the level's index space, of any positive length. Null if the sample is a voxel's
  /// extent (along the normal) or more inside that face. `to_eye`: direction in the level's index space; faces that
  /// look away from the eye, or are seen edge-on, light no sample. requires: a part of the sample at `index` is inside.
  const glm::vec3* cutGradient(const glm::dvec3& index, const glm::dvec3& to_eye) const noexcept;

 private:
  // Shows points with normal·p + offset >= least.
  struct HalfSpace {
    glm::dvec3 normal;
    double offset, least;
    double voxel;  // change of normal·p over a voxel's cube
    glm::vec3 gradient;
  };
  static HalfSpace halfSpace(const glm::dvec3& normal, double offset, double least, const Extent3& span);
  // The face that is nearest to a sample towards the eye; its gradient if the sample is less than a voxel inside.
  struct Nearest {
    const glm::vec3* gradient = nullptr;
    double distance = std::numeric_limits<double>::infinity();
    void compare(const std::vector<HalfSpace>& faces, const glm::dvec3& index, const glm::dvec3& to_eye) noexcept;
  };
  std::vector<HalfSpace> half_spaces_;
  std::vector<HalfSpace> border_;  // lights samples and clips nothing
  // Points farther than a voxel from the border, which need no comparison with the faces of the border.
  glm::dvec3 core_lo_{-std::numeric_limits<double>::infinity()}, core_hi_{std::numeric_limits<double>::infinity()};
  Part part_;
};

}  // namespace kiln
