#include "splat/slab_frame.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "splat/label_samples.h"
#include "splat/view_box.h"

namespace kiln {
namespace {

int floorOf(double v) { return static_cast<int>(std::floor(std::clamp(v, -kFar_px, kFar_px))); }

// A box is cut off at its zone where it spans more than this of its nearest depth: there it looks much larger than what
// of it is in the zone.
constexpr double kDeep = 0.25;

// Of soft voxels (SampleTable::soft) that change by this part of what is soft, on rays one sample a voxel shows as much
// as two.
constexpr double kPairChange = 0.25;

// A row of samples is as long as a vector. Along the other axes a unit is short: fewer samples then wait for their
// slabs (ARCHITECTURE.md has the figures).
constexpr int kUnitRows = 8;

// See softBlock.
static_assert(kMostGhosts - 1 <= kMostSoftBlock && kMostSoftBlock + kUnitMargin <= kApron);

// Samples do not lie across the faces between cells, and units are not cut where their samples begin anew.
static_assert(kCellSize % kRefinedVoxels == 0 && kRefinedVoxels % kUnitVoxels == 0);

int unitVoxels(const Refinement& refinement, std::size_t axis, bool of_blocks) {
  if (of_blocks) return axis == 0 && unitHasRoom(refinement, kUnitVoxels) ? kUnitVoxels : softBlock(refinement);
  int voxels = kUnitVoxels;
  while (voxels > 1 &&
         (!unitHasRoom(refinement, voxels) || (axis > 0 && refinement.samples * voxels > kUnitRows * kRefinedVoxels)))
    voxels /= 2;
  return voxels;
}

DepthSpread depthSpread(const SlabZone& zone, const std::array<Refinement, 3>& refinement, const Projector& projector) {
  std::array<float, 3> edges{};
  for (int a = 0; a < 3; ++a) {
    const auto ua = static_cast<std::size_t>(a);
    edges[ua] = static_cast<float>(std::abs(projector.axis(a).z) / refinement[ua].ofVoxel() / zone.thickness);
  }
  std::sort(edges.begin(), edges.end());
  return {edges[2], edges[1], 0.5f * (edges[2] + edges[1])};
}

// unit: world.
double shortestEdge(const Projector& projector) {
  return std::min({glm::length(projector.axis(0)), glm::length(projector.axis(1)), glm::length(projector.axis(2))});
}
double longestSample(const SlabZone& zone, const Projector& projector) {
  double out = 0;
  for (int a = 0; a < 3; ++a) {
    const auto ua = static_cast<std::size_t>(a);
    const double samples = std::min(zone.refinement[ua].ofVoxel(), zone.soft_refinement[ua].ofVoxel());
    out = std::max(out, glm::length(projector.axis(a)) / samples);
  }
  return out;
}

UnitLattice unitLattice(const SlabZone& zone, const std::array<Refinement, 3>& refinement_of,
                        const Projector& projector, const FootprintTable& footprint, const SampleTable& table,
                        const SampleLook& look, bool detailed) {
  UnitLattice out;
  out.interpolation = look.interpolation;
  out.labels = table.ofLabels();
  // Gradients of labels are the B-spline's, whatever interpolates between voxels.
  const Interpolation of_axes = out.labels ? Interpolation::kCubic : look.interpolation;
  for (std::size_t a = 0; a < 3; ++a) {
    out.voxels[a] = unitVoxels(zone.refinement[a], a, zone.judgesBlocks());
    for (int first = 0; first < kRefinedVoxels; first += out.voxels[a])
      out.axes[a].emplace_back(refinement_of[a], first, out.voxels[a], of_axes);
  }
  if (zone.judgesBlocks()) out.blocks = out.voxels[0] / softBlock(zone.refinement[0]);
  out.perspective = projector.perspective();
  out.focal = static_cast<float>(projector.focal());
  out.centre_x = static_cast<float>(projector.centre().x);
  out.centre_y = static_cast<float>(projector.centre().y);
  out.near_depth = static_cast<float>(projector.nearDepth());
  out.step_x = glm::vec3(projector.axis(0));
  out.step_y = glm::vec3(projector.axis(1));
  out.step_z = glm::vec3(projector.axis(2));
  out.near = static_cast<float>(zone.near);
  out.slabs_per_depth = static_cast<float>(1 / zone.thickness);
  out.thickness = static_cast<float>(zone.thickness);
  out.slabs = zone.slabs;
  out.spread = depthSpread(zone, refinement_of, projector);
  out.taps = footprint.taps();
  double samples = 1;
  for (const Refinement& refinement : refinement_of) samples *= refinement.ofVoxel();
  out.weight =
      static_cast<float>(projector.voxelVolume() / samples * projector.focal() * projector.focal() / zone.thickness);
  out.table = table.entries();
  out.table_scale = table.scale();
  out.table_last = table.last();
  out.extinctions = table.extinctions();
  out.visible_after = table.visibleAfter();
  out.visible_before = table.visibleBefore();
  out.gaps = table.hasGaps();
  if (zone.intervals && !out.labels) out.integral = table.integral();
  out.least_interval = table.leastInterval();
  out.light = plainLight(look.shading, look.gradient_noise, projector);
  out.light.phong = out.light.phong && !detailed;
  return out;
}

// How far the opacities of labels are smoothed, where the apron holds as much: on rays the farther, the larger voxels
// are in the picture. unit: voxels.
std::int64_t labelSmoothing(const SlabZone& zone, const Projector& projector) {
  if (!zone.on_rays) return kMostLabelSmoothing;
  const double scale = projector.focal() / (projector.perspective() ? zone.near : 1);
  return std::clamp(std::lround(std::cbrt(projector.voxelVolume()) * scale), long{kLeastLabelSmoothing},
                    long{kMostLabelSmoothing});
}

// How far beyond its core a brick's samples reach the pixels of slabs that it owns: along the axis where it is the
// most, a footprint across and half a slab and a sample's own depth along the view.
std::int64_t ghostsOf(const SlabZone& zone, const Projector& projector, const FootprintTable& footprint,
                      double sample_reach) {
  constexpr double kSlack = 0.02;  // a footprint's phases, and rounding
  const double along = (sample_reach + 0.5 + kSlack) * zone.thickness;
  const double farthest = projector.perspective() ? zone.far + along : 1;
  const double across = (footprint.radius() + kSlack) * farthest / projector.focal();
  // Along a ray of the picture's corner, depth is also a way across.
  const glm::dvec2 slope = projector.perspective() ? projector.widest() / projector.focal() : glm::dvec2(0);
  std::int64_t most = 0;
  for (int a = 0; a < 3; ++a) {
    const glm::dvec3 row = glm::abs(glm::dvec3(projector.indexRow(a)));
    const double voxels = (row.x + row.y) * across + (row.x * slope.x + row.y * slope.y + row.z) * along;
    const auto ua = static_cast<std::size_t>(a);
    const double first = std::min(zone.refinement[ua].leastFromFace(), zone.soft_refinement[ua].leastFromFace());
    most = std::max(most, static_cast<std::int64_t>(std::ceil(std::min(voxels - first, 1e6))));
  }
  // Between voxels, one more is for interpolation.
  return std::min(most, zone.refined() ? kMostGhosts - 1 : kMostGhosts);
}

// What the supports of a cell and of those around it range over.
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

SlabFrame::SlabFrame(const SlabZone& zone, const Projector& projector, const Extent3& dims, const EndVoxels& ends,
                     const SampleTable& table, const SampleLook& look, const SlabSharing& sharing)
    : zone_(zone),
      projector_(projector),
      dims_(dims),
      ends_(ends),
      table_(table),
      look_(look),
      detailed_(!isPlain(look.shading) || look.gradient_opacity.active() || !look.clip->showsAll()),
      footprint_(zone.sigma_px, zone.soft_sigma_px, sharing.least_taps),
      color_unit_(std::max(colorUnitOf(look.shading), sharing.color_unit)),
      lattice_(unitLattice(zone, zone.refinement, projector, footprint_, table, look, detailed_)),
      voxel_length_(std::cbrt(projector.voxelVolume())),
      shortest_edge_(shortestEdge(projector)),
      longest_sample_(longestSample(zone, projector)) {
  if (zone.judgesBlocks()) {
    soft_lattice_ = unitLattice(zone, zone.soft_refinement, projector, footprint_, table, look, detailed_);
    soft_lattice_->first_phase = FootprintTable::kSoftRows;
    soft_lattice_->three_slabs = soft_lattice_->spread.reach > 0.5f;
  }
  ghosts_ = sharing.owned && !zone.on_rays ? ghostsOf(zone, projector, footprint_, sampleReach()) : 0;
  // What the apron holds beyond the voxels of samples and of their gradients.
  const std::int64_t left = kApron - ghosts_ - (zone.on_rays || zone.refined() ? 2 : 1);
  lattice_.label_smoothing = static_cast<int>(std::clamp<std::int64_t>(left, 0, labelSmoothing(zone, projector)));
}

double SlabFrame::sampleReach() const {
  if (zone_.on_rays) return 0;
  const auto reach = static_cast<double>(lattice_.spread.reach);
  return soft_lattice_ ? std::max(reach, static_cast<double>(soft_lattice_->spread.reach)) : reach;
}

bool SlabFrame::soft(const VoxelBox& block, const SampledRange& range) const {
  bool ends = range.gaps || look_.clip->classify(block) != ClipRegion::Overlap::kInside;
  for (int a = 0; a < 3; ++a) ends = ends || block.lo[a] <= 0 || block.hi[a] >= dims_[a];
  return table_.soft(range.values, voxel_length_, ends);
}

bool SlabFrame::cutOff(const VoxelBox& samples) const {
  // A sample on a ray lies across faces, and up to half of it may be inside whose middle is not.
  return look_.clip->classify(zone_.on_rays ? dilated(samples, 1) : samples) == ClipRegion::Overlap::kOutside;
}

bool SlabFrame::inPairs(const SampledRange& range) const {
  if (range.gaps || look_.gradient_opacity.active()) return false;
  // What is not soft has several samples a voxel for a reason.
  const bool near = 2 * zone_.thickness <= shortest_edge_ * (1 + 1e-9);
  return near && table_.soft(range.values, voxel_length_ / kPairChange, false);
}

SlabFrame::Bounds SlabFrame::boundsOf(const VoxelBox& box) const {
  const ViewBox at(projector_, box);
  // At the volume's end a sample may be half of its length beyond it.
  const bool ends = box.hi.x == dims_.x || box.hi.y == dims_.y || box.hi.z == dims_.z;
  const double beyond = ends && zone_.refined() ? 0.5 * std::max(zone_.thickness, longest_sample_) : 0;
  // A sample has a depth of its own.
  const double reach = sampleReach() * zone_.thickness + beyond;
  Bounds out;
  if (at.farthest + reach < zone_.near || at.nearest - reach >= zone_.far) return out;
  // Beside the eye, what is nearer than the zone would be all over the picture.
  const bool deep = projector_.perspective() && at.farthest - at.nearest > kDeep * at.nearest;
  const ViewExtent seen =
      deep ? at.extentBetween(std::max(zone_.near - reach, 0.5 * projector_.nearDepth()), zone_.far + reach)
           : at.extent();
  if (zone_.on_rays) {
    // Pixels whose centres are in it, and rounding.
    // Places on rays are floats.
    const double wide = std::max(seen.x1 - seen.x0, seen.y1 - seen.y0);
    const double slack = 0.01 + wide * std::ldexp(static_cast<double>(std::max({dims_.x, dims_.y, dims_.z})), -22);
    const auto first = [&](double px) { return floorOf(px - 0.5 - slack); };
    const auto end = [&](double px) { return floorOf(px - 0.5 + slack) + 1; };
    out.rect = {first(seen.x0), first(seen.y0), end(seen.x1), end(seen.y1)};
    out.last = zone_.slabs - 1;
    return out;
  }
  // Half a pixel to the nearest centre and rounding beside the footprint.
  double r = footprint_.radius() + 0.51;
  if (beyond > 0)
    r += beyond * projector_.focal() /
         (projector_.perspective() ? std::max(zone_.near - reach, projector_.nearDepth()) : 1);
  out.rect = {floorOf(seen.x0 - r), floorOf(seen.y0 - r), floorOf(seen.x1 + r) + 1, floorOf(seen.y1 + r) + 1};
  const auto slab = [&](double z) {
    return static_cast<int>(std::clamp(std::floor((z - zone_.near) / zone_.thickness), 0.0, zone_.slabs - 1.0));
  };
  // One for rounding.
  out.first = std::max(0, slab(at.nearest - reach) - 1);
  out.last = slab(at.farthest + reach);
  out.in_zone = at.nearest - reach >= zone_.near && at.farthest + reach < zone_.far;
  return out;
}

std::vector<SlabCell> interestingCells(const SlabFrame& frame, const BrickBlock& block) {
  std::vector<SlabCell> out;
  const VoxelBox reach = intersection(dilated(block.core, frame.ghosts()), boxOf(frame.dims()));
  const int n = block.supports.edge();
  // A cubic, and what a sample between the voxels of a coarser level stands for, reach a voxel farther than the
  // supports that come with a brick.
  const UnitLattice& l = frame.lattice();
  const bool farther = l.interpolation != Interpolation::kLinear || (frame.zone().on_rays && l.integral != nullptr);
  std::array<std::vector<std::uint8_t>, 3> order;
  for (int a = 0; a < 3; ++a) {
    std::vector<std::uint8_t>& along = order[static_cast<std::size_t>(a)];
    along.resize(static_cast<std::size_t>(n));
    frame.projector().order().axisOrder(a, block.core.lo[a] - kCellSize, n, along.data(), kCellSize);
  }
  for (const int z : order[2]) {
    for (const int y : order[1]) {
      for (const int x : order[0]) {
        const bool near = frame.interesting(block.supports.at(x, y, z));
        if (!near && !(farther && frame.interesting(supportsAround(block.supports, x, y, z)))) continue;
        const VoxelCoord lo = {block.core.lo.x + (x - 1) * kCellSize, block.core.lo.y + (y - 1) * kCellSize,
                               block.core.lo.z + (z - 1) * kCellSize};
        SlabCell cell{intersection({lo, {lo.x + kCellSize, lo.y + kCellSize, lo.z + kCellSize}}, reach), {}};
        if (cell.box.empty() || frame.cutOff(cell.box)) continue;
        const VoxelBox support = intersection(dilated(cell.box, kUnitMargin), block.extent);
        if (!near && !frame.interesting(rangeOf(block.voxels, block.type, block.extent, support))) continue;
        cell.bounds = frame.boundsOf(cell.box);
        if (!cell.bounds.empty()) out.push_back(cell);
      }
    }
  }
  return out;
}

}  // namespace kiln
