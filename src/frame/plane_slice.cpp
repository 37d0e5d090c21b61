#include "frame/plane_slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <type_traits>
#include <vector>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "engine/shared/brick_extremum.h"
#include "engine/shared/draw_counts.h"
#include "engine/shared/index_ray.h"
#include "engine/shared/interpolated_brick.h"
#include "frame/slice_palette.h"
#include "frame/slice_statistic.h"
#include "grid/value_range.h"
#include "scene/half_spaces.h"
#include "scene/transfer/display_map.h"
#include "store/brick_index.h"
#include "store/codec/brick_block.h"
#include "store/codec/brick_codec.h"

namespace kiln {
namespace {

// Share of a pixel by which a side may exceed a whole number of pixels: rounding of products in the world.
constexpr double kSideRounding = 1e-6;
// The corners of the part of the volume's box between two planes across `normal`, `half` to either side of `on`.
std::vector<glm::dvec3> cornersBetween(const VolumeGeometry& level, const glm::dvec3& on, const glm::dvec3& normal,
                                       double half) {
  std::vector<glm::dvec4> half_spaces;
  addBox(glm::dvec3(-0.5), glm::dvec3(level.dims.x, level.dims.y, level.dims.z) - 0.5, half_spaces);
  for (const double side : {1.0, -1.0})
    half_spaces.push_back(inIndexSpace(side * glm::dvec4(normal, -glm::dot(on, normal)) + glm::dvec4(0, 0, 0, half),
                                       level.world_from_index));
  std::vector<glm::dvec3> out;
  for (const auto& [begin, end] : edgesOf(half_spaces)) {
    out.push_back(level.worldOf(begin));
    out.push_back(level.worldOf(end));
  }
  return out;
}

// Down along the picture: to the feet, or to the back where the normal is nearest to head or feet. An axial slice that
// is tilted thus has the sides of the axial slice, whichever way the tilt.
glm::dvec3 downOf(const glm::dvec3& normal, PatientFrame frame) {
  const bool axial = std::abs(normal.z) > std::max(std::abs(normal.x), std::abs(normal.y));
  const glm::dvec3 down = axial ? -patientAxes(frame).anterior : glm::dvec3(0, 0, -1);
  return glm::normalize(down - glm::dot(down, normal) * normal);
}

// Samples of a plane's pixels in the index space of a level.
class PlaneSampler {
 public:
  PlaneSampler(const VolumeGeometry& level, const PlanePixels& pixels, bool labels, bool exact)
      : pixels_(pixels),
        labels_(labels),
        exact_(exact),
        last_(glm::dvec3(level.dims.x - 1, level.dims.y - 1, level.dims.z - 1)) {
    const glm::dmat4 index_from_world = glm::inverse(level.world_from_index);
    const glm::dmat3 turn(index_from_world);
    first_ = glm::dvec3(index_from_world * glm::dvec4(pixels.first, 1.0));
    right_ = turn * pixels.right;
    down_ = turn * pixels.down;
    along_ = turn * pixels.along;
  }

  // Gathers what the brick adds to a row of pixels from `begin` to `end`.
  template <class T>
  void addRow(const BrickBlock& block, const SliceStatistic& statistic, std::int64_t y, std::int64_t begin,
              std::int64_t end, GatheredValue* row) const {
    if (!exact_)
      addSamples<T>(block, statistic, y, begin, end, row);
    else if (statistic.sign() > 0)
      addExtrema<T, false>(block, y, begin, end, row);
    else
      addExtrema<T, true>(block, y, begin, end, row);
  }

 private:
  // Raises pixels to the extremum on the line across the slice, in the brick.
  template <class T, bool kLeast>
  void addExtrema(const BrickBlock& block, std::int64_t y, std::int64_t begin, std::int64_t end,
                  GatheredValue* row) const {
    constexpr double kSign = kLeast ? -1 : 1, kNoneYet = -std::numeric_limits<double>::infinity();
    DrawCounts counts;
    BrickExtremum<T, kLeast> extremum(block, false, counts);
    const glm::dvec3 first(block.core.lo.x, block.core.lo.y, block.core.lo.z);
    const glm::dvec3 after(block.core.hi.x, block.core.hi.y, block.core.hi.z);
    for (std::int64_t x = begin; x < end; ++x) {
      const IndexRay line{first_ + static_cast<double>(x) * right_ + static_cast<double>(y) * down_, along_};
      const DepthSpan whole = line.within(glm::dvec3(-0.5), last_ + 0.5, {-pixels_.reach, pixels_.reach});
      const DepthSpan here = line.within(first - 0.5, after - 0.5, whole);
      if (here.empty()) continue;
      double held = row[x].samples > 0 ? kSign * row[x].value : kNoneYet;
      extremum.take(line, {here, here.near == whole.near, here.far == whole.far}, held);
      if (held > kNoneYet) row[x] = {kSign * held, 1};
    }
  }

  // Gathers the samples whose cell belongs to the brick.
  template <class T>
  void addSamples(const BrickBlock& block, const SliceStatistic& statistic, std::int64_t y, std::int64_t begin,
                  std::int64_t end, GatheredValue* row) const {
    const InterpolatedBrick<T> field(block);
    for (std::int64_t x = begin; x < end; ++x) {
      for (int k = 0; k < pixels_.samples; ++k) {
        const glm::dvec3 at = first_ + static_cast<double>(x) * right_ + static_cast<double>(y) * down_ +
                              (k - 0.5 * (pixels_.samples - 1)) * along_;
        if (glm::any(glm::lessThan(at, glm::dvec3(-0.5))) || glm::any(glm::greaterThan(at, last_ + 0.5))) continue;
        // Between the centres of the outermost voxels and the volume's faces, values are constant.
        const glm::dvec3 inside = glm::clamp(labels_ ? glm::floor(at + 0.5) : at, glm::dvec3(0), last_);
        const glm::dvec3 cell = glm::floor(inside);
        const VoxelCoord v{static_cast<std::int64_t>(cell.x), static_cast<std::int64_t>(cell.y),
                           static_cast<std::int64_t>(cell.z)};
        if (!block.core.contains(v)) continue;
        const T* const corner = field.at(v);
        statistic.add(labels_ ? static_cast<double>(*corner) : field.between(corner, inside - cell), row[x]);
      }
    }
  }

  const PlanePixels& pixels_;
  bool labels_, exact_;
  glm::dvec3 last_, first_, right_, down_, along_;
};

// Pixels [x, x_end) by [y, y_end).
struct PixelBox {
  std::int64_t x = 0, y = 0, x_end = 0, y_end = 0;
  bool empty() const { return x >= x_end || y >= y_end; }
};

// The pixels whose samples may lie in cells of the brick.
PixelBox pixelsOver(const VoxelBox& core, const VolumeGeometry& level, const PlanePixels& pixels, bool exact) {
  ValueRange across, along_x, along_y;
  const double edge2 = pixels.edge * pixels.edge;
  for (int i = 0; i < 8; ++i) {
    // A cell reaches to the next voxel; at the volume's faces half a voxel further.
    const glm::dvec3 corner((i & 1) ? static_cast<double>(core.hi.x) : static_cast<double>(core.lo.x) - 0.5,
                            (i & 2) ? static_cast<double>(core.hi.y) : static_cast<double>(core.lo.y) - 0.5,
                            (i & 4) ? static_cast<double>(core.hi.z) : static_cast<double>(core.lo.z) - 0.5);
    const glm::dvec3 from_first = level.worldOf(corner) - pixels.first;
    across.include(glm::dot(from_first, pixels.along) / edge2);
    along_x.include(glm::dot(from_first, pixels.right) / edge2);
    along_y.include(glm::dot(from_first, pixels.down) / edge2);
  }
  const double reach = exact ? pixels.reach : 0.5 * (pixels.samples - 1);
  const double half = reach * glm::dot(pixels.along, pixels.along) / edge2;
  if (across.lo > half + kSideRounding || across.hi < -half - kSideRounding) return {};
  const auto bounded = [](double pixel, std::int64_t count) {
    return static_cast<std::int64_t>(std::clamp(pixel, 0.0, static_cast<double>(count)));
  };
  return {bounded(std::floor(along_x.lo), pixels.width), bounded(std::floor(along_y.lo), pixels.height),
          bounded(std::ceil(along_x.hi) + 1, pixels.width), bounded(std::ceil(along_y.hi) + 1, pixels.height)};
}

Image coloured(const std::vector<GatheredValue>& gathered, const PlanePixels& pixels, const SliceStatistic& statistic,
               const SliceColors& colors) {
  Image image(static_cast<int>(pixels.width), static_cast<int>(pixels.height));
  for (std::size_t i = 0; i < gathered.size(); ++i) {
    const GatheredValue& pixel = gathered[i];
    if (pixel.samples == 0) continue;
    // NaN is the mean of the two infinities.
    const glm::vec3* const color = colors.of(statistic.valueOf(pixel));
    if (color == nullptr) continue;
    float* const rgba = image.rgba.data() + 4 * i;
    for (int channel = 0; channel < 3; ++channel) rgba[channel] = (*color)[channel];
    rgba[3] = 1;
  }
  return image;
}

}  // namespace

PlanePixels pixelsOfPlane(const VolumeGeometry& level, const PlaneSliceRequest& request) {
  const double length = glm::length(request.normal);
  if (!(length > 0) || !std::isfinite(length) || !std::isfinite(request.offset))
    throw Error(
        ErrorCode::kUsage,
        fmt::format("--plane: expected a normal other than 0,0,0 and a finite offset (found {:g},{:g},{:g},{:g})",
                    request.normal.x, request.normal.y, request.normal.z, request.offset));
  if (!(request.thickness >= 0) || !std::isfinite(request.thickness))
    throw Error(ErrorCode::kUsage,
                fmt::format("--thickness: expected a length of at least 0 (found {})", request.thickness));
  if (request.pixel && (!(*request.pixel > 0) || !std::isfinite(*request.pixel)))
    throw Error(ErrorCode::kUsage, fmt::format("--pixel: expected a length above 0 (found {})", *request.pixel));
  const glm::dvec3 normal = request.normal / length;
  const glm::dvec3 on = -request.offset / length * normal;
  const std::vector<glm::dvec3> outline = cornersBetween(level, on, normal, 0.5 * request.thickness);
  if (outline.empty()) {
    ValueRange offsets;
    for (const glm::dvec3& corner : level.corners()) offsets.include(-glm::dot(corner, request.normal));
    throw Error(ErrorCode::kUsage, fmt::format("--plane: the plane lies beside the volume (found the offset {:g}); "
                                               "choose an offset between {:g} and {:g}",
                                               request.offset, offsets.lo, offsets.hi));
  }
  PlanePixels out{};
  const double voxel = level.shortestEdge();
  out.edge = request.pixel.value_or(voxel);
  const glm::dvec3 down = downOf(normal, level.frame), right = glm::cross(down, normal);
  ValueRange across, below;
  for (const glm::dvec3& corner : outline) {
    across.include(glm::dot(corner - on, right));
    below.include(glm::dot(corner - on, down));
  }
  const auto pixels = [&](const ValueRange& side) {
    const double count = std::max(1.0, std::ceil((side.hi - side.lo) / out.edge - kSideRounding));
    if (count > kLargestSliceSide)
      throw Error(ErrorCode::kUsage,
                  fmt::format("--plane: expected at most {} pixels along a side (found {:.0f}, of {:g}); choose larger "
                              "pixels (--pixel) or a coarser --level",
                              kLargestSliceSide, count, out.edge));
    return static_cast<std::int64_t>(count);
  };
  out.width = pixels(across);
  out.height = pixels(below);
  const auto begin = [&](const ValueRange& side, std::int64_t count) {
    return 0.5 * (side.lo + side.hi) - 0.5 * static_cast<double>(count - 1) * out.edge;
  };
  out.first = on + begin(across, out.width) * right + begin(below, out.height) * down;
  out.right = out.edge * right;
  out.down = out.edge * down;
  const double samples = std::max(1.0, std::ceil(request.thickness / voxel - kSideRounding));
  if (samples > kLargestSliceSide)
    throw Error(ErrorCode::kUsage, fmt::format("--thickness: expected at most {} voxels of {:g} (found {:g})",
                                               kLargestSliceSide, voxel, request.thickness));
  out.samples = static_cast<int>(samples);
  const double apart = out.samples > 1 ? request.thickness / samples : voxel;
  out.along = apart * normal;
  out.reach = 0.5 * request.thickness / apart;
  return out;
}

bool isExactAcross(const BrickedVolume& store, const PlaneSliceRequest& request) {
  return request.thickness > 0 && store.manifest().volume_class != VolumeClass::kLabels &&
         sliceStatistic(request.statistic).sign() != 0;
}

Image renderPlaneSlice(const BrickedVolume& store, const PlaneSliceRequest& request, Progress& progress) {
  store.requireLevel(request.level);
  const VolumeGeometry& level = store.level(request.level).geometry;
  const bool labels = store.manifest().volume_class == VolumeClass::kLabels;
  const SliceStatistic& statistic = sliceStatistic(request.statistic);
  if (labels && request.thickness > 0 && statistic.mixesValues())
    throw Error(ErrorCode::kUsage, "--thickness: labels have no average; add --mode mip or minip");
  const SliceColors colors(request.labels, request.colormap,
                           request.window.value_or(defaultWindow(store.manifest().histogram)));
  const PlanePixels pixels = pixelsOfPlane(level, request);
  requireSliceFits(store, pixels.width, pixels.height, 4 * sizeof(float) + sizeof(GatheredValue), request.memory_bytes);
  const bool exact = isExactAcross(store, request);
  const PlaneSampler sampler(level, pixels, labels, exact);
  std::vector<GatheredValue> gathered(static_cast<std::size_t>(pixels.width * pixels.height));
  const Extent3& lattice = store.index().lattice(request.level);
  for (std::int64_t i = 0; i < lattice.count(); ++i) {
    progress.throwIfCancelled("drawing a slice");
    const BrickKey key{request.level, brickAt(lattice, i)};
    const PixelBox box = pixelsOver(store.frame(key).core(), level, pixels, exact);
    progress.advance("drawing", "bricks", static_cast<std::uint64_t>(i) + 1,
                     static_cast<std::uint64_t>(lattice.count()));
    if (box.empty()) continue;
    const BrickBlock block = store.read(key);
    withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
      parallelFor(static_cast<std::size_t>(box.y_end - box.y), [&](std::size_t row) {
        const std::int64_t y = box.y + static_cast<std::int64_t>(row);
        sampler.addRow<T>(block, statistic, y, box.x, box.x_end, gathered.data() + y * pixels.width);
      });
    });
  }
  return coloured(gathered, pixels, statistic, colors);
}

}  // namespace kiln
