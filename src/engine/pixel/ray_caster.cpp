#include "engine/pixel/ray_caster.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <vector>

#include "engine/pixel/cast_rays_in_cell.h"
#include "engine/pixel/voxels/color_patch.h"
#include "engine/pixel/voxels/label_voxels.h"
#include "engine/pixel/voxels/load_patch.h"
#include "engine/pixel/voxels/mask_voxels.h"

namespace kiln {
namespace {

// Prefetches the rows of a cell, which lie far apart in a brick's memory.
void fetch(const BrickBlock& block, const VoxelBox& cell) {
  const VoxelBox box = intersection(dilated(cell, kPatchMargin), block.extent);
  const auto bytes = static_cast<std::int64_t>(sizeOf(block.type));
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const std::byte* const row = block.data<std::byte>() + bytes * block.offsetOf({box.lo.x, y, z});
      __builtin_prefetch(row);
      __builtin_prefetch(row + bytes * (box.hi.x - box.lo.x) - 1);
    }
  }
}

struct SeenCell {
  const SlabCell* cell = nullptr;
  PixelRect rect;
};

class RayCaster {
 public:
  RayCaster(const RaySampling& rays, const SlabContext& context, const BrickBlock& block, const TilePixels& tile,
            Visibility& visibility, float opacity_threshold, SlabSums* sums, DrawCounts& counts)
      : rays_(rays),
        context_(context),
        block_(block),
        tile_(tile),
        visibility_(visibility),
        opacity_threshold_(opacity_threshold),
        sums_(sums),
        part_(context.look().clip->part()),
        counts_(counts) {}

  // Prefetches a cell while the cell before it is cast; that cell may hide the next.
  void run(std::span<const SlabCell> cells) {
    SeenCell due;
    for (const SlabCell& cell : cells) {
      const SeenCell next{&cell, intersection(cell.rect, tile_.rect)};
      if (next.rect.empty() || hidden(next.rect)) continue;
      fetch(block_, cell.box);
      cast(due);
      due = next;
    }
    cast(due);
  }

 private:
  bool hidden(const PixelRect& rect) {
    const bool out = visibility_.hidden(rect);
    ++counts_.nodes_tested;
    counts_.nodes_hidden += out ? 1 : 0;
    return out;
  }

  void cast(const SeenCell& seen) {
    if (seen.cell == nullptr || visibility_.hidden(seen.rect)) return;
    const VoxelBox& box = seen.cell->box;
    alignas(64) float values[CellInput::kReadEdge * CellInput::kPlane + kPatchStride];
    CellInput in;
    if (!(context_.table().ofLabels() ? loadLabelsOf(box, in) : loadValuesOf(box, values, in))) return;
    if (!loadMaskOf(box, in)) return;
    loadColorsOf(box, in);
    in.bounds = seen.cell->rect;
    // Extent of a slab; positions are rounded to floats. unit: voxels.
    constexpr double kMargin = 0.1;
    const double slab = static_cast<double>(rays_.longestStep(in.bounds)) + kMargin;
    int ends = 0;
    for (int a = 0; a < 3; ++a) {
      const bool last = box.hi[a] == context_.dims()[a];
      in.lo[a] = static_cast<float>(box.lo[a] - rays_.anchor[a]) - 1.0f;
      in.corner[a] = static_cast<double>(box.lo[a]) - 0.5;
      in.end[a] = last ? rays_.volume_hi[a] : static_cast<double>(box.hi[a]) - 0.5;
      // The first or the last sample of a ray may be in the cell beside a thin cell at the end.
      const int at_axis = (in.corner[a] + 0.5 < slab ? 1 : 0) + (rays_.volume_hi[a] - in.end[a] < slab ? 1 : 0);
      in.ends[static_cast<std::size_t>(a)] = at_axis > 0;
      ends += at_axis;
    }
    in.at_end = ends > 0, in.at_edge = ends > 1;
    findFaces(box, 0.5 * slab, in);
    if (!part_.all()) in.part = &part_;
    in.on_face = context_.onFace(box);
    in.sums = sums_;
    // Several volumes are composited in single slabs.
    // The near half of a pair at a face hides the far half, but the face lights a share of the length.
    in.in_pairs = in.in_pairs && sums_ == nullptr && (in.lit_by.empty() || !context_.look().shading.phong);
    forEachSquare(seen.rect, [&](const PixelRect& square) {
      in.rect = square;
      if (square == seen.rect || !visibility_.hidden(square)) castSquare(in);
    });
  }

  void castSquare(const CellInput& in) {
    CellOutput out;
    castRaysInCell(rays_, context_, in, tile_, opacity_threshold_, samples_, out);
    counts_.visited += out.shown, counts_.splats += out.samples;
    counts_.changed = counts_.changed || out.samples > 0;
    for (int y = 0; y < in.rect.height(); ++y) {
      for (std::uint64_t rest = out.closed[static_cast<std::size_t>(y)]; rest != 0; rest &= rest - 1)
        rays_.close(visibility_, in.rect.x0 + std::countr_zero(rest), in.rect.y0 + y);
    }
  }

  bool loadValuesOf(const VoxelBox& box, float* values, CellInput& in) const {
    const SampledRange range = loadPatch(block_, context_.lattice(), context_.table().offset(), box.lo, values);
    in.values = values;
    in.gaps = range.gaps;
    in.in_pairs = context_.inPairs(range);
    if (!range.values.empty()) in.color = context_.table().oneColor(range.values);
    return true;
  }
  // Returns false if no label is visible.
  bool loadLabelsOf(const VoxelBox& box, CellInput& in) {
    if (!labels_) labels_ = std::make_unique_for_overwrite<LabelVoxels>();
    const LabelsAround around = loadLabels(block_, context_.lattice(), box.lo, context_.table(), *labels_);
    in.values = labels_->opacities, in.labels = labels_->ranks;
    // Along a ray a single label looks uniform.
    in.one_label = in.in_pairs = around == LabelsAround::kOne;
    return around != LabelsAround::kNone;
  }

  // Finds the faces at a cell. `beyond`: reach of samples beyond the cell. unit: voxels.
  void findFaces(const VoxelBox& box, double beyond, CellInput& in) {
    const auto isWithin = [&](const SampleFace& face, double voxels) {
      return leastInside(face, box, context_.dims()) < static_cast<float>(voxels) * face.voxel;
    };
    cuts_.clear();
    for (const SampleFace& face : context_.faces()) {
      if (face.cuts && isWithin(face, beyond)) cuts_.push_back(face);
    }
    in.cuts = cuts_;
    // A ray may have entered through a distant face, which then lights no sample; hence all faces.
    const std::vector<SampleFace>& lights = context_.lightFaces();
    if (std::ranges::any_of(lights, [&](const SampleFace& face) { return isWithin(face, 1 + beyond); }))
      in.lit_by = lights;
  }

  // Returns false if the mask hides the cell. Labels know the mask already.
  bool loadMaskOf(const VoxelBox& box, CellInput& in) {
    if (block_.shown.all() || context_.table().ofLabels()) return true;
    if (!mask_) mask_ = std::make_unique_for_overwrite<MaskVoxels>();
    const MaskAround around = loadMask(block_, context_.lattice(), box.lo, *mask_);
    if (around != MaskAround::kSome) return around == MaskAround::kAll;
    in.mask = mask_->shown, in.mask_smoothed = mask_->smoothed;
    in.in_pairs = false;
    return true;
  }

  void loadColorsOf(const VoxelBox& box, CellInput& in) {
    const SampleTable* const table = context_.look().colors;
    if (table == nullptr || block_.color_values.empty()) return;
    if (!colors_) colors_ = std::make_unique_for_overwrite<ColorPatch>();
    loadColors(block_, *table, box.lo, *colors_);
    in.color_places = colors_->places;
    in.color = nullptr;
  }

  const RaySampling& rays_;
  const SlabContext& context_;
  const BrickBlock& block_;
  const TilePixels& tile_;
  Visibility& visibility_;
  const float opacity_threshold_;
  SlabSums* const sums_;  // null if samples are composited at once
  const ClipRegion::Part& part_;
  DrawCounts& counts_;
  CellSamples samples_;
  std::vector<SampleFace> cuts_;         // faces that reach the cell that is cast
  std::unique_ptr<LabelVoxels> labels_;  // label volumes only
  std::unique_ptr<MaskVoxels> mask_;     // masked volumes only
  std::unique_ptr<ColorPatch> colors_;   // volumes coloured by another only
};

}  // namespace

void castRays(const RaySampling& rays, const SlabContext& context, const BrickBlock& block,
              std::span<const SlabCell> cells, const TilePixels& tile, Visibility& visibility, float opacity_threshold,
              DrawCounts& counts) {
  RayCaster(rays, context, block, tile, visibility, opacity_threshold, nullptr, counts).run(cells);
}

void sumCells(const RaySampling& rays, const SlabContext& context, const BrickBlock& block,
              std::span<const SlabCell> cells, const TilePixels& tile, Visibility& visibility, SlabSums& sums,
              DrawCounts& counts) {
  RayCaster(rays, context, block, tile, visibility, 1, &sums, counts).run(cells);
}

}  // namespace kiln
