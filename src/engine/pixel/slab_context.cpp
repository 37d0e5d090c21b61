#include "engine/pixel/slab_context.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>

#include "base/thread/parallel.h"
#include "engine/pixel/voxels/label_voxels.h"
#include "engine/shared/view_box.h"

namespace kiln {
namespace {

int floorOf(double v) { return static_cast<int>(std::floor(std::clamp(v, -kFar_px, kFar_px))); }

// Depth of a box, as a fraction of the nearest depth, above which the box is clipped to the zone before projection. A
// deep box would cover many more pixels than the part inside the zone.
constexpr double kDeep = 0.25;

// Fraction of the limit of SampleTable::soft up to which one sample per voxel shows as much as two.
constexpr double kPairChange = 0.25;

// unit: world.
double shortestEdge(const Projector& projector) {
  return std::min({glm::length(projector.axis(0)), glm::length(projector.axis(1)), glm::length(projector.axis(2))});
}

SampleLattice::Plane planeOf(const SampleTable& table, const Projector& projector) {
  const PlaneTable& plane = table.plane();
  SampleLattice::Plane out;
  if (!plane.any()) return out;
  out.factors = plane.factors();
  out.colors = plane.colors();
  out.stride = plane.stride();
  out.column_scale = static_cast<float>(plane.columnsPerValue() / static_cast<double>(table.scale()));
  out.column_offset = static_cast<float>((table.offset() - plane.firstValue()) * plane.columnsPerValue());
  out.last_column = static_cast<float>(plane.columns() - 1);
  out.row_offset = static_cast<float>(-plane.firstGradient() * plane.rowsPerGradient());
  out.last_row = static_cast<float>(plane.rows() - 1);
  out.rows_from_slope = glm::mat3(plane.rowsPerGradient() * glm::dmat3(projector.viewFromIndexGradient()));
  out.unit = static_cast<float>(table.unit());
  return out;
}

SampleLattice sampleLattice(const SlabZone& zone, const Projector& projector, const SampleTable& table,
                            const Appearance& look) {
  SampleLattice out;
  out.interpolation = look.interpolation;
  out.perspective = projector.perspective();
  out.focal = static_cast<float>(projector.focal());
  out.thickness = static_cast<float>(zone.thickness);
  out.table = table.entries();
  out.table_scale = table.scale();
  out.table_last = table.last();
  out.extinctions = table.extinctions();
  out.visible_after = table.visibleAfter();
  out.visible_before = table.visibleBefore();
  if (look.colors != nullptr) {
    out.color_table = look.colors->entries();
    out.color_last = look.colors->last();
    out.color_nearest = look.colors->ofLabels();
  }
  out.surfaces = static_cast<int>(table.surfaceValues().size());
  out.surface_values = table.surfaceValues().data();
  out.surface_opacities = table.surfaceOpacities().data();
  if (zone.intervals && !table.ofLabels() && !table.ofSurfaces()) out.integral = table.integral();
  out.plane = planeOf(table, projector);
  out.least_interval = table.leastInterval();
  out.light = plainLight(look.shading, look.gradients, projector);
  out.points_on_faces = look.faces != nullptr;
  if (look.shading.phong && !isPlain(look.shading)) out.lights = &look.shader;
  out.near = static_cast<float>(zone.near);
  return out;
}

// Reach of the opacity smoothing of labels; larger where voxels are larger in the picture. unit: voxels.
int labelSmoothing(const SlabZone& zone, const Projector& projector) {
  const double scale = projector.focal() / (projector.perspective() ? zone.near : 1);
  return static_cast<int>(std::clamp(std::lround(std::cbrt(projector.voxelVolume()) * scale),
                                     long{kLeastLabelSmoothing}, long{kMostLabelSmoothing}));
}
// The apron must hold the voxels that smoothing reads beyond the voxels of samples and their gradients.
static_assert(kMostLabelSmoothing + 2 <= kApron);

// Range of the supports of a cell and its neighbours.
ValueRange supportsAround(const CellSupports& supports, int x, int y, int z) {
  ValueRange out;
  const auto last = [&](int cell) { return std::min(cell + 1, supports.edge() - 1); };
  for (int k = std::max(z - 1, 0); k <= last(z); ++k) {
    for (int j = std::max(y - 1, 0); j <= last(y); ++j) {
      for (int i = std::max(x - 1, 0); i <= last(x); ++i) out.include(supports.at(i, j, k));
    }
  }
  return out;
}

}  // namespace

SlabContext::SlabContext(const SlabZone& zone, const Projector& projector, const Extent3& dims,
                         const SampleTable& table, const Appearance& look)
    : zone_(zone),
      projector_(projector),
      dims_(dims),
      table_(table),
      look_(look),
      clipped_(!look.clip->showsAll()),
      lattice_(sampleLattice(zone, projector, table, look_)),
      faces_(sampleFaces(*look.clip, dims, lattice_.light.gradient.directed)),
      voxel_length_(std::cbrt(projector.voxelVolume())),
      shortest_edge_(shortestEdge(projector)) {
  lattice_.label_smoothing = labelSmoothing(zone, projector);
  std::copy_if(faces_.begin(), faces_.end(), std::back_inserter(light_faces_),
               [&](const SampleFace& face) { return !table.ofSurfaces() && !(face.cuts && look_.faces != nullptr); });
  if (look_.faces != nullptr) shown_faces_ = look_.faces->seenFaces(*look_.clip);
}

// A sample extends across faces: up to half of a sample may be inside although the middle is outside.
bool SlabContext::cutOff(const VoxelBox& samples) const {
  return !look_.clip->part().touches(samples) ||
         (clipped_ && look_.clip->classify(dilated(samples, 1)) == ClipRegion::Overlap::kOutside);
}

bool SlabContext::onFace(const VoxelBox& voxels) const {
  // Positions are rounded to floats.
  constexpr double kMargin = 0.1;
  const glm::dvec3 lo(voxels.lo.x, voxels.lo.y, voxels.lo.z), hi(voxels.hi.x, voxels.hi.y, voxels.hi.z);
  const glm::dvec3 middle = 0.5 * (lo + hi) - 0.5, half = 0.5 * (hi - lo) + kMargin;
  return std::any_of(shown_faces_.begin(), shown_faces_.end(), [&](const glm::dvec4& face) {
    const glm::dvec3 normal(face);
    return std::abs(glm::dot(normal, middle) + face.w) <= glm::dot(glm::abs(normal), half);
  });
}

bool SlabContext::coloursFace(const VoxelBox& voxels, const ValueRange& range) const {
  return look_.faces != nullptr && look_.faces->colors() != nullptr && !range.empty() && onFace(voxels);
}

bool SlabContext::inPairs(const SampledRange& range) const {
  if (range.gaps || table_.plane().any()) return false;
  // Voxels that are not soft, or hold the border of a layer, have several samples for a reason.
  const bool near = 2 * zone_.thickness <= shortest_edge_ * (1 + 1e-9);
  return near && table_.soft(range.values, voxel_length_ / kPairChange) && table_.even(range.values, voxel_length_);
}

PixelRect SlabContext::boundsOf(const VoxelBox& box) const {
  const ViewBox at(projector_, box);
  const double near = table_.ofSurfaces() ? zone_.overlapNear() : zone_.near;
  if (at.farthest < near || at.nearest >= zone_.far) return {};
  // Without clipping, a box beside the eye would cover the whole picture.
  const bool deep = projector_.perspective() && at.farthest - at.nearest > kDeep * at.nearest;
  const ViewExtent seen =
      deep ? at.extentBetween(std::max(near, 0.5 * projector_.nearDepth()), zone_.far) : at.extent();
  // Pixels whose centres are in the box, with a margin for the rounding of sample positions to floats.
  const double wide = std::max(seen.x1 - seen.x0, seen.y1 - seen.y0);
  const double slack = 0.01 + wide * std::ldexp(static_cast<double>(std::max({dims_.x, dims_.y, dims_.z})), -22);
  const auto first = [&](double px) { return floorOf(px - 0.5 - slack); };
  const auto end = [&](double px) { return floorOf(px - 0.5 + slack) + 1; };
  return {first(seen.x0), first(seen.y0), end(seen.x1), end(seen.y1)};
}

std::vector<SlabCell> visibleCells(const SlabContext& context, const BrickBlock& block) {
  const int n = block.supports.edge();
  // Cubic kernels and intervals of a coarser level reach one voxel beyond the supports stored with a brick.
  const SampleLattice& l = context.lattice();
  const bool farther = l.interpolation != Interpolation::kLinear || l.integral != nullptr;
  std::array<std::vector<std::uint8_t>, 3> order;
  for (int a = 0; a < 3; ++a) {
    std::vector<std::uint8_t>& along = order[static_cast<std::size_t>(a)];
    along.resize(static_cast<std::size_t>(n));
    context.projector().order().axisOrder(a, block.core.lo[a] - kCellSize, n, along.data(), kCellSize);
  }
  // A small picture of a large volume has a single brick, so layers are examined in parallel.
  std::vector<std::vector<SlabCell>> layers(order[2].size());
  parallelFor(layers.size(), [&](std::size_t layer) {
    const int z = order[2][layer];
    for (const int y : order[1]) {
      for (const int x : order[0]) {
        const VoxelCoord lo = {block.core.lo.x + (x - 1) * kCellSize, block.core.lo.y + (y - 1) * kCellSize,
                               block.core.lo.z + (z - 1) * kCellSize};
        SlabCell cell{intersection({lo, {lo.x + kCellSize, lo.y + kCellSize, lo.z + kCellSize}}, block.core), {}};
        if (cell.box.empty()) continue;
        const ValueRange& range = block.supports.at(x, y, z);
        const bool near = context.interesting(range) || context.coloursFace(cell.box, range);
        if (!near && !(farther && context.interesting(supportsAround(block.supports, x, y, z)))) continue;
        if (context.cutOff(cell.box)) continue;
        const VoxelBox support = intersection(dilated(cell.box, kPatchMargin), block.extent);
        if (!near && !context.interesting(rangeOf(block.voxels, block.type, block.extent, support))) continue;
        cell.rect = context.boundsOf(cell.box);
        if (!cell.rect.empty()) layers[layer].push_back(cell);
      }
    }
  });
  std::vector<SlabCell> out;
  for (const std::vector<SlabCell>& layer : layers) out.insert(out.end(), layer.begin(), layer.end());
  return out;
}

}  // namespace kiln
