// Default cameras: from a side, turned, and fitted to the volume.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "grid/geometry.h"
#include "scene/camera/camera.h"

namespace kiln {

enum class Side { kFront, kBack, kTop, kBottom, kLeft, kRight };
/// Returns the direction from a volume to an eye that looks at this side. unit: world, of length 1.
glm::dvec3 towardsEye(PatientFrame frame, Side side);

/// Part of a volume that a framing fits into the picture.
/// - kVisible: what the transfer functions show after clipping.
/// - kRegion: the box of the clip region.
/// - kBox: the box of the whole volume.
enum class Fit { kVisible, kRegion, kBox };

/// Rotations of the world about an axis through the middle of the box that leave the outline in the picture.
struct Turns {
  std::vector<glm::dmat3> rotations = {};
  glm::dvec3 axis{0};        // of length 1, unless there is no rotation
  bool moves_target = true;  // the target may move along the axis
  bool empty() const { return rotations.empty(); }
};

/// Edges of a picture that a framing leaves free, for annotations. unit: pixels.
struct FreeEdges {
  double left = 0, right = 0, top = 0, bottom = 0;
  /// Returns the width and height of the rectangle between the edges.
  glm::dvec2 rectangle(const ImageSize& size) const;
  /// Returns the shift from the middle of the picture to the middle of the rectangle, right and up. unit: widths and
  /// heights of the picture.
  glm::dvec2 shift(const ImageSize& size) const;
  bool operator==(const FreeEdges&) const = default;
};

/// A box, the points that pictures contain, and how a framing fits the points. With kBox the margin is 1 % on each
/// side, and the first frame of a turntable is fitted, as earlier versions did; else it is 3 %, and all frames are
/// fitted. Cameras look at the middle of the box; with kVisible at the middle of what is seen. A turntable's camera
/// looks at the point of its axis that leaves equal margins at both ends of the axis, over all frames.
struct FramedBox {
  VolumeGeometry volume;
  Fit fit = Fit::kBox;
  std::vector<glm::dvec3> outline;  // unit: world
  /// Choices of edges, of which a CameraSpec takes those that leave the largest picture. Empty: no edge is free.
  std::vector<FreeEdges> free_edges = {};
  /// The outline is the box's corners.
  FramedBox(VolumeGeometry box, Fit how = Fit::kBox);
  FramedBox(VolumeGeometry box, std::vector<glm::dvec3> points, Fit how)
      : volume(std::move(box)), fit(how), outline(std::move(points)) {}
  /// Ratio of the picture's extent to the outline's.
  double margin() const { return fit == Fit::kBox ? 1.02 : 1.06; }
  bool isCentred(const Turns& turns) const { return fit == Fit::kVisible && turns.empty(); }
  bool isCentredAlongAxis(const Turns& turns) const {
    return fit == Fit::kVisible && !turns.empty() && turns.moves_target;
  }
};

struct Framing {
  /// Front is the patient's face; in a volume without a frame, the side towards -y with +z up (as in LPS).
  Side side = Side::kFront;
  /// Turns the eye about the up axis (positive: to the patient's left, seen from the front), then raises it. unit:
  /// degrees; elevation from -90 to 90.
  double azimuth_deg = 0, elevation_deg = 0;
  std::optional<glm::dvec3> up;  // default: the side's
  /// Turns the camera about its line of sight, clockwise as the camera sees. unit: degrees.
  double roll_deg = 0;
  /// 1 fits the outline into the image with a small margin; 2 is twice as large.
  double zoom = 1;
  Projection projection = Projection::kPerspective;
  double fov_deg = 30;
};

/// Default framing: three quarters from the front, slightly from above.
Framing defaultFraming();

/// Returns a camera whose image of size `size` contains the outline, also where the outline is turned about the box's
/// centre by one of `turns`; the eye is always outside the outline. Zoom narrows the field of view (or height) and
/// leaves the eye, so the perspective is unchanged. With `edges`, the outline is between them after `panned` by
/// edges.shift(size), and zoom is about the middle of their rectangle. throws: Error kUsage if zoom is not positive, or
/// an angle is out of range.
Camera frameVolume(const FramedBox& box, const Framing& framing, const ImageSize& size, const Turns& turns = {},
                   const FreeEdges& edges = {});

/// Returns the orthographic height at which the image of `camera` (eye, target and up) contains the outline, with the
/// margin of `frameVolume`. unit: world.
double fittingHeight(const FramedBox& box, const Camera& camera, const ImageSize& size);

/// throws: Error kUsage for an enlargement that is not a finite number above 0.
void requireZoom(double zoom);

/// Turns eye and up about an axis through the target, right-handed. unit: radians.
Camera turned(Camera camera, const glm::dvec3& axis, double angle);

/// Turns the camera about its line of sight, clockwise as the camera sees: the picture turns the other way.
Camera rolled(const Camera& camera, double degrees);

/// Moves the camera so that what is in the picture moves by `pan.x` widths of the picture to the right and `pan.y`
/// heights up, at the depth of the target. requires: no equirectangular camera.
Camera panned(const Camera& camera, const glm::dvec2& pan, const ImageSize& size);

/// Returns a box in the axes of the first volume that contains the boxes of all volumes; the first volume's own box if
/// that is enough. shape: whole voxels of the first volume. requires: at least one volume.
VolumeGeometry boxAround(const std::vector<VolumeGeometry>& volumes);

/// Returns a box of the volume's voxels as a volume. requires: a box that is not empty.
VolumeGeometry partOf(const VolumeGeometry& volume, const VoxelBox& box);

/// Returns the middle of the volume's box. unit: world.
glm::dvec3 centreOf(const VolumeGeometry& volume);

}  // namespace kiln
