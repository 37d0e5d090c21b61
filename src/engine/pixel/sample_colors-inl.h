// Colours of samples: of their values, of a companion volume, and of regions of values and gradients. Compiled once for
// each instruction set; hence no #pragma once.
#if defined(KILN_SAMPLE_COLORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_SAMPLE_COLORS_INL_H
#undef KILN_SAMPLE_COLORS_INL_H
#else
#define KILN_SAMPLE_COLORS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "engine/pixel/cast_rays_in_cell.h"
#include "engine/pixel/cell_field-inl.h"
#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Stores the colours of a batch of visible samples that begins at the n-th: r, g, b of the i-th at
// CellSamples::rows[0] + 4 i.
class SampleColors {
 public:
  SampleColors(const SampleLattice& lattice, const CellInput& in, CellSamples& samples)
      : l_(lattice), in_(in), s_(samples) {}

  // Colours of the samples' values, or of the companion's.
  HWY_INLINE void lookUp(std::size_t n, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) lookUpColor(l_.table, s_.entry[n + i], i);
    if (in_.color_places != nullptr) lookUpCompanion(n, count);
  }

  // Colours of the samples' positions in a table of their own.
  HWY_INLINE void lookUpIn(const SampleTable& table, std::size_t n, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) lookUpColor(table.entries(), s_.entry[n + i], i);
  }

  // Mixes the colours of regions with the colours of values.
  HWY_NOINLINE void mixRegions(std::size_t n, std::size_t count) {
    const SampleLattice::Plane& plane = l_.plane;
    for (std::size_t i = 0; i < count; ++i) {
      const float along = fused(s_.entry[n + i], plane.column_scale, plane.column_offset);
      const float column = std::min(std::max(along, 0.0f), plane.last_column), row = s_.row[n + i];
      const auto x = static_cast<std::int32_t>(column), y = static_cast<std::int32_t>(row);
      const float* const here = plane.colors + 4 * static_cast<std::ptrdiff_t>(y * plane.stride + x);
      const float* const above = here + 4 * static_cast<std::ptrdiff_t>(plane.stride);
      const auto mixed = [&](int c) {
        const auto along_row = [&](const float* at) {
          return fused(column - static_cast<float>(x), at[4 + c] - at[c], at[c]);
        };
        const float lower = along_row(here);
        return fused(row - static_cast<float>(y), along_row(above) - lower, lower);
      };
      float* const rgb = s_.rows[0] + 4 * i;
      const float own = mixed(3);
      for (int c = 0; c < 3; ++c) rgb[c] = fused(own, rgb[c], mixed(c));
    }
  }

 private:
  // Replaces the colours of samples at which the companion has a value.
  HWY_NOINLINE void lookUpCompanion(std::size_t n, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const float place = companionPlaceAt(static_cast<std::size_t>(s_.index[n + i]));
      if (place == place) lookUpColor(l_.color_table, std::min(std::max(place, 0.0f), l_.color_last), i);
    }
  }

  // Position of a found sample in the table of the companion's colours; NaN if the companion has no value there.
  HWY_INLINE float companionPlaceAt(std::size_t sample) const {
    const float place =
        l_.color_nearest ? nearestOf(in_.color_places, sample) : interpolatedAt(in_.color_places, s_, sample);
    const bool some_hidden = in_.mask != nullptr || in_.labels != nullptr, has_value = place == place;
    const bool stays = l_.color_nearest ? has_value && !some_hidden : has_value || !some_hidden;
    return stays ? place : placeBeside(sample, place);
  }

  // The surface of a mask or a label lies between shown and hidden voxels, and hidden voxels have other labels or no
  // values. A surface also lies between voxels with and without labels where a segmentation ends at the surface.
  // Returns the place of the nearest voxel that counts if one of the eight around the sample does not, else `place`. A
  // voxel counts if it is shown and, in a volume of labels, its label has a colour.
  HWY_NOINLINE float placeBeside(std::size_t sample, float place) const {
    const std::int32_t offset = s_.offset[sample];
    const float* const places = in_.color_places + offset;
    const auto counts = [&](int at) {
      if (l_.color_nearest && places[at] != places[at]) return false;
      return in_.labels != nullptr ? in_.labels[offset + at] >= 0 : in_.mask == nullptr || in_.mask[offset + at] > 0;
    };
    const auto away = [&](int axis, bool next) {
      const float f = s_.fraction[axis][sample], distance = next ? 1 - f : f;
      return distance * distance;
    };
    float nearest = std::numeric_limits<float>::quiet_NaN(), least = 4;  // above all squared distances
    bool all_count = true;
    // From the last on: of equally near voxels the later, as nearestOf.
    for (int corner = 7; corner >= 0; --corner) {
      const bool x = (corner & 1) != 0, y = (corner & 2) != 0, z = (corner & 4) != 0;
      const int at = (z ? CellInput::kPlane : 0) + (y ? kPatchStride : 0) + (x ? 1 : 0);
      if (!counts(at)) {
        all_count = false;
        continue;
      }
      const float distance = away(0, x) + away(1, y) + away(2, z);
      if (distance < least) least = distance, nearest = places[at];
    }
    return all_count ? place : nearest;
  }

  // The voxel of a patch that is nearest to a sample.
  HWY_INLINE float nearestOf(const float* patch, std::size_t sample) const {
    const auto next = [&](int axis) { return s_.fraction[axis][sample] >= 0.5f; };
    return patch[s_.offset[sample] + (next(2) ? CellInput::kPlane : 0) + (next(1) ? kPatchStride : 0) +
                 (next(0) ? 1 : 0)];
  }

  // Stores the colour at a table position as the i-th of the batch.
  HWY_INLINE void lookUpColor(const float* table, float entry, std::size_t i) {
    const D4 d;
    const auto whole = static_cast<std::int32_t>(entry);
    const float* const at = table + 4 * static_cast<std::ptrdiff_t>(whole);
    const auto t = hn::Set(d, entry - static_cast<float>(whole));
    for (std::size_t c = 0; c < 4; c += hn::Lanes(d)) {
      const auto here = hn::LoadU(d, at + c);
      hn::Store(between(here, hn::LoadU(d, at + 4 + c), t), d, s_.rows[0] + 4 * i + c);
    }
  }

  const SampleLattice& l_;
  const CellInput& in_;
  CellSamples& s_;
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
