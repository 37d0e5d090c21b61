#include "engine/voxel/splat_cell.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "engine/voxel/gather_voxels.h"
#include "engine/voxel/project_voxels.h"
#include "engine/voxel/rasterize_footprints.h"

namespace kiln {
namespace {

// Finds the visible voxels of a cell, front to back, and passes them through the kernels batch by batch. Visibility is
// tested between projection and gathering, so that hidden voxels cost neither gradient nor light. Pixels closed by a
// batch take effect from the next batch on.
class CellSplatter {
 public:
  CellSplatter(const SplatContext& context, const BrickBlock& block, const TileTarget& target, TilePlanes& planes,
               DrawCounts& counts)
      : context_(context), block_(block), target_(target), planes_(planes), counts_(counts) {}

  void cell(const VoxelBox& box) {
    lo_ = box.lo;
    cut_ = context_.clip->classify(box) == ClipRegion::Overlap::kCut;
    ends_ = context_.ends.any() && endsIn(box);
    more_ = cut_ || ends_ || !context_.light_is_plain || context_.gradient_opacity.active() || planes_.aovs().any();
    findVoxels(*context_.classifier, context_.projector->order(), block_, box, found_);
    for (int n = 0; n < found_.count; n += kVoxelBatch) batch(n);
  }

 private:
  bool endsIn(const VoxelBox& box) const {
    const VoxelCoord& last = context_.ends.last;
    return last.x < box.hi.x || last.y < box.hi.y || last.z < box.hi.z;
  }

  void batch(int first) {
    const std::int32_t* const codes = found_.codes + first;
    const int count = std::min(found_.count - first, kVoxelBatch);
    ProjectedVoxels projected;
    projectVoxels(context_.view, lo_, codes, count, planes_.rect(), projected);
    std::uint32_t drawn = projected.touching;
    if (cut_) {
      forEach(projected.touching, [&](std::size_t n) {
        if (!context_.clip->contains(indexOf(codes[n]))) drawn &= ~(1u << n);
      });
    }
    counts_.visited += static_cast<std::uint64_t>(std::popcount(drawn & projected.inside));
    if (context_.test_samples && drawn != 0) drawn = openOf(projected, drawn);
    counts_.splats += static_cast<std::uint64_t>(std::popcount(drawn & projected.inside));
    if (drawn == 0) return;
    counts_.changed = true;
    ShadedVoxels shaded;
    takeVoxels(*context_.classifier, block_, found_, first, drawn, context_.view.light.phong || more_, shaded);
    if (more_) forEach(drawn, [&](std::size_t n) { takeMore(codes[n], n, shaded); });
    rasterizeFootprints(context_.view, projected, shaded, drawn, planes_, target_.opacity_threshold,
                        target_.visibility);
  }

  // Returns a mask of the voxels of `asked` that have an open pixel. Footprints of a batch have nearly equal sizes; for
  // large footprints the visibility structure reads fewer words than the planes.
  std::uint32_t openOf(const ProjectedVoxels& projected, std::uint32_t asked) const {
    constexpr std::uint64_t kLarge = 1024;  // unit: pixels
    if (projected.rect(static_cast<std::size_t>(std::countr_zero(asked))).count() <= kLarge)
      return planes_.open(projected, asked);
    std::uint32_t out = 0;
    forEach(asked, [&](std::size_t n) {
      const bool hidden = target_.visibility.hidden(intersection(projected.rect(n), planes_.rect()));
      out |= (hidden ? 0u : 1u) << n;
    });
    return out;
  }

  template <class F>
  static void forEach(std::uint32_t drawn, F f) {
    for (; drawn != 0; drawn &= drawn - 1) f(static_cast<std::size_t>(std::countr_zero(drawn)));
  }

  // Handles voxel n beyond the kernels: other lights, cut faces, opacity by gradient, AOVs, and voxels that exist in
  // part.
  void takeMore(std::int32_t code, std::size_t n, ShadedVoxels& shaded) const {
    const glm::vec3 measured(shaded.slope[0][n], shaded.slope[1][n], shaded.slope[2][n]);
    // A NaN or infinite neighbour leaves no usable gradient.
    const glm::vec3 slope = std::isfinite(measured.x + measured.y + measured.z) ? measured : glm::vec3(0);
    const Shader& shader = context_.shader;
    const auto place = [&] { return context_.projector->viewOf(voxelAt(lo_, code)); };
    const float* const m = shaded.material + 4 * n;
    Material material = {m[0], m[1], m[2], m[3]};
    if (context_.gradient_opacity.active()) material = context_.gradient_opacity(valueOf(code), slope);
    const glm::vec3* const face =
        cut_ ? context_.clip->cutGradient(indexOf(code), context_.projector->towardsEye(place())) : nullptr;
    if (!context_.light_is_plain) {
      const Color color = face != nullptr ? shader.onCut(material, *face, place()) : shader(material, slope, place());
      material = {color.r, color.g, color.b, material.tau};
      for (auto& axis : shaded.slope) axis[n] = 0;
    } else if (face != nullptr) {
      for (int axis = 0; axis < 3; ++axis)
        shaded.slope[axis][n] = context_.view.light.gradient.directed * (*face)[axis];
    }
    if (planes_.aovs().any()) {
      const glm::dvec3 p = place();
      shaded.aov[n] = {static_cast<float>(p.z),
                       face != nullptr ? shader.normalOnCut(*face, p) : shader.normal(slope, p)};
    }
    if (ends_) material.tau *= static_cast<float>(context_.ends.partOf(voxelAt(lo_, code)));
    std::memcpy(shaded.material + 4 * n, &material, sizeof material);
  }

  double valueOf(std::int32_t code) const {
    const auto at = static_cast<std::size_t>(block_.offsetOf(voxelAt(lo_, code)));
    return withVoxelType(block_.type,
                         [&]<class T>(std::type_identity<T>) { return static_cast<double>(block_.data<T>()[at]); });
  }

  glm::dvec3 indexOf(std::int32_t code) const {
    const VoxelCoord v = voxelAt(lo_, code);
    return {v.x, v.y, v.z};
  }

  const SplatContext& context_;
  const BrickBlock& block_;
  const TileTarget& target_;
  TilePlanes& planes_;
  DrawCounts& counts_;
  // State of the current cell.
  VoxelCoord lo_;
  bool cut_ = false;   // by the clip region
  bool ends_ = false;  // some voxels exist in part
  bool more_ = false;  // some voxels need takeMore
  FoundVoxels found_;
};

}  // namespace

void splatCell(const SplatContext& context, const BrickBlock& block, const VoxelBox& cell, const TileTarget& target,
               TilePlanes& planes, DrawCounts& counts) noexcept {
  const VoxelBox drawn = intersection(cell, context.part);
  if (!drawn.empty()) CellSplatter(context, block, target, planes, counts).cell(drawn);
}

}  // namespace kiln
