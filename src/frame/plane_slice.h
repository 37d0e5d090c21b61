// Draws the slice of a volume along any plane, thin or thick, from the bricks that the slice meets.
// Method. Multiplanar reformatting: values between voxels are trilinear, labels are of the nearest voxel. The greatest
// and the least value across a thick slice are exact; samples of means and labels are at most a voxel's shortest edge
// apart.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "frame/slice.h"
#include "grid/geometry.h"
#include "image/image.h"

namespace kiln {

struct PlaneSliceRequest {
  /// The plane is where normal·x + offset = 0, as of clip planes. The picture shows the plane as seen along the normal.
  glm::dvec3 normal{0, 0, 1};
  double offset = 0;
  double thickness = 0;               // of the slice, centred on the plane. unit: world
  std::optional<double> pixel;        // edge of a pixel; the shortest edge of a voxel if absent. unit: world
  std::string statistic = "average";  // the value of a pixel of a thick slice, a name of sliceStatistic()
  int level = 0;                      // 0 is finest
  std::optional<Window> window;
  std::string colormap = "gray";   // one of displayMapNames()
  std::vector<LabelStyle> labels;  // as SliceRequest::labels
  std::uint64_t memory_bytes = std::uint64_t{2} << 30;
};

/// The pixels of a slice in the world.
struct PlanePixels {
  glm::dvec3 first;               // centre of the upper left pixel
  glm::dvec3 right, down, along;  // from a pixel, or a sample, to the next
  std::int64_t width, height;
  int samples;   // across the slice; sample k is at `first` + (k - (samples - 1) / 2) · `along`
  double reach;  // of the slice to either side of the plane. unit: `along`
  double edge;   // of a pixel. unit: world
  glm::dvec3 at(double x, double y) const { return first + x * right + y * down; }
};

/// Returns the pixels that cover the slice of the volume's box. z is up; where the normal is nearer to z than to x and
/// y, y is down, or up in RAS. throws: Error kUsage: no normal, a plane beside the volume, too many pixels.
PlanePixels pixelsOfPlane(const VolumeGeometry& level, const PlaneSliceRequest& request);

/// True if pixels hold the exact greatest or least value across a thick slice, not that of samples.
bool isExactAcross(const BrickedVolume& store, const PlaneSliceRequest& request);

/// Draws a slice. Pixels of NaN, of labels without opacity or style, and outside the volume are transparent. Equal bits
/// for all numbers of threads; sizes of bricks change the order of sums. memory: 32 bytes a pixel and one brick.
/// throws: Error kUsage, kBudget; as BrickedVolume::read.
Image renderPlaneSlice(const BrickedVolume& store, const PlaneSliceRequest& request, Progress& progress);

}  // namespace kiln
