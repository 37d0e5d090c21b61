#include "engine/pixel/cast_rays_in_cell.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "engine/pixel/sample_normal.h"
#include "engine/pixel/slab_layer.h"
#include "engine/pixel/voxels/mask_voxels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/pixel/cast_rays_in_cell.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/pixel/cell_chords-inl.h"
#include "engine/pixel/cell_faces-inl.h"
#include "engine/pixel/cell_field-inl.h"
#include "engine/pixel/cell_rays-inl.h"
#include "engine/pixel/cell_surfaces-inl.h"
#include "engine/pixel/classify-inl.h"
#include "engine/pixel/face_slopes-inl.h"
#include "engine/pixel/mask_samples-inl.h"
#include "engine/pixel/sample_colors-inl.h"
#include "engine/pixel/sample_light-inl.h"
#include "engine/shared/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// Interpolates, classifies, composites and lights the samples found by CellRays. kGaps: voxels may be NaN.
template <class Field, bool kGaps>
class CellCaster {
 public:
  CellCaster(const RaySampling& rays, const SlabContext& context, const CellInput& in, const TilePixels& tile,
             float opacity_threshold, CellSamples& samples, CellOutput& out)
      : r_(rays),
        context_(context),
        l_(context.lattice()),
        in_(in),
        tile_(tile),
        opacity_threshold_(opacity_threshold),
        modulates_(l_.plane.factors != nullptr),
        places_(tile.aovs.any() || (l_.surfaces > 0 && (!in.cuts.empty() || tile.deep != nullptr))),
        derives_(places_ || modulates_),
        slopes_(!derives_ && !(l_.lights != nullptr && l_.lights->model().scatters)),
        lit_by_mask_(in.mask != nullptr && l_.surfaces == 0),
        p_(rays, context.lattice(), in, tile),
        faces_(p_, rays, in),
        field_(context.lattice(), in, samples),
        mask_(context.lattice(), in, samples),
        colors_(context.lattice(), in, samples),
        s_(samples),
        out_(out) {}

  void run() {
    if (in_.on_face) castFaces();
    if (in_.at_edge && l_.surfaces == 0) castChords();
    const auto cast = [this](std::size_t count) { castFound(count); };
    const RayParts parts = l_.surfaces > 0 ? RayParts::kPieces : RayParts::kMiddles;
    CellRays<decltype(cast)>(p_, r_, in_, tile_, s_, parts, cast).run(shownSpaces());
  }

 private:
  // Thickness of a surface in a shadow map, which holds no steps. unit: slabs.
  static constexpr double kShadowLayer = 0.25;
  // Optical depth of an opaque face beside other volumes, far above that of any matter in a slab: 9 times the slab's
  // thickness over the unit of opacity.
  static constexpr float kOpaqueFace = 1e30f;
  static constexpr std::size_t kLanes = CellSamples::kLanes, kLit = CellSamples::kLit;
  static constexpr int kPlane = CellInput::kPlane;

  // Mask of intervals of table positions that contain extinction.
  HWY_INLINE M visible(V lo, V hi) const {
    const D d;
    return hn::And(hn::Gt(hi, hn::Set(d, l_.visible_after)), hn::Lt(lo, hn::Set(d, l_.visible_before)));
  }

  HWY_NOINLINE void castFound(std::size_t count) {
    if (l_.surfaces > 0) return castSurfaces(count);
    count_ = count;
    const bool pieces = p_.inPieces();
    pieces ? placeAll<true>() : placeAll<false>();
    field_.interpolate(count_);
    classifyAll();
    pieces ? attenuateAll<true>() : attenuateAll<false>();
    if (in_.sums != nullptr)
      keepAll();
    else
      blendAll();
    lightAll();
  }

  HWY_NOINLINE void castSurfaces(std::size_t count) {
    CellSurfaces<Field>(p_, r_, l_, in_, field_, s_).find(count, [this](std::size_t crossings) {
      count_ = kept_ = crossings;
      if (in_.mask != nullptr) maskSurfaces();
      if (places_) finishSurfaces();
      if (in_.sums != nullptr)
        sumSurfaces();
      else
        blendAll();
      lightAll();
    });
  }

  // Spaces in which samples may be visible; all spaces if none are returned. The middle of a piece may lie beside the
  // middle of its slab.
  std::optional<Spaces> shownSpaces() const {
    const std::optional<Spaces> shown = field_.shown();
    if (!shown || l_.surfaces > 0 || !(in_.at_end || !in_.cuts.empty())) return shown;
    if (r_.longestStep(in_.bounds) > 1) return std::nullopt;
    return grown(*shown);
  }

  // Draws the rays that cross the volume between the middles of slabs. They have no other sample in the volume.
  HWY_NOINLINE void castChords() {
    p_.useChords(true);
    CellChords(p_, r_, in_, s_).find([this](std::size_t count) { castFound(count); });
    p_.useChords(false);
  }

  // Draws the points on cut faces, the first samples of their rays.
  HWY_NOINLINE void castFaces() {
    on_face_ = true;
    CellFaces(p_, r_, context_, in_, s_).find([this](std::size_t points) {
      count_ = kept_ = points;
      classifyFaces();
      if (in_.mask != nullptr) maskSurfaces();
      const D d;
      for (std::size_t n = 0; n < kept_; n += hn::Lanes(d)) {
        const CellPlaces::Where w = p_.slabOf(hn::Load(DI(), s_.kept_code + n));
        for (int a = 0; a < 3; ++a) hn::StoreU(p_.pointAt(a, w, hn::Load(d, s_.at + n)), d, s_.index_place[a] + n);
      }
      if (in_.sums != nullptr)
        sumSurfaces();
      else
        blendAll();
      lightAll();
    });
    on_face_ = false;
  }

  // Table positions and opacities of points on cut faces.
  void classifyFaces() {
    const float opacity = context_.look().faces->opacity();
    const D d;
    if (in_.labels != nullptr) {
      // As in the solid behind the face: the label with the largest share, opaque where labels have half of all.
      field_.interpolate(kept_);
      for (std::size_t n = 0; n < kept_; n += hn::Lanes(d)) {
        const V place = field_.values(n), twice = hn::Set(d, 2.0f);
        const V before = hn::Mul(twice, hn::Floor(hn::Mul(hn::Set(d, 0.5f), place)));
        hn::StoreU(hn::Add(before, hn::Set(d, 1.0f)), d, s_.entry + n);
        hn::StoreU(hn::Mul(hn::Sub(place, before), hn::Set(d, opacity)), d, s_.opacity + n);
      }
      return;
    }
    const SampleTable* const colors = context_.look().faces->colors();
    field_.interpolate(kept_);
    for (std::size_t n = 0; n < kept_; n += hn::Lanes(d)) {
      V value = field_.values(n);
      M shows = hn::Eq(value, value);
      value = hn::IfThenElseZero(shows, value);
      if (colors != nullptr) {
        const V place =
            hn::Mul(hn::Add(value, hn::Set(d, context_.look().faces->shift())), hn::Set(d, colors->scale()));
        hn::StoreU(hn::Min(hn::Max(place, hn::Zero(d)), hn::Set(d, colors->last())), d, s_.entry + n);
      } else {
        const V entry = placeOf(d, l_, value);
        hn::StoreU(entry, d, s_.entry + n);
        V tau = extinctionAt(d, l_, entry);
        if (modulates_) {
          keepSlopes(n, std::min(kept_ - n, hn::Lanes(d)));
          tau = modulatedTau(n, tau);
        }
        shows = hn::And(shows, hn::Gt(tau, hn::Zero(d)));
      }
      hn::StoreU(hn::IfThenElseZero(shows, hn::Set(d, opacity)), d, s_.opacity + n);
    }
  }

  // Finishes crossings: those outside the clip region become transparent. Stores gradients and positions.
  void finishSurfaces() {
    const D d;
    for (std::size_t n = 0; n < kept_; n += hn::Lanes(d)) {
      const CellPlaces::Where w = p_.slabOf(hn::Load(DI(), s_.kept_code + n));
      for (int a = 0; a < 3; ++a) hn::StoreU(p_.pointAt(a, w, hn::Load(d, s_.at + n)), d, s_.index_place[a] + n);
      keepSlopes(n, std::min(kept_ - n, hn::Lanes(d)));
      keepSlope(n, outOfSurface(n, slopesFrom(n)));
    }
    if (in_.cuts.empty()) return;
    for (std::size_t n = 0; n < kept_; ++n) {
      if (!context_.look().clip->contains(siteOf(n).index)) s_.opacity[n] = 0;
    }
  }

  // Gradients of crossings, turned so that the outward sign turns them to the side from which their rays come.
  HWY_INLINE Vector outOfSurface(std::size_t n, const Vector& slope) const {
    const D d;
    if (on_face_) return slope;
    const V sign = hn::AndNot(hn::LoadU(d, s_.excess[0] + n), hn::SignBit(d));
    return {hn::Xor(slope.x, sign), hn::Xor(slope.y, sign), hn::Xor(slope.z, sign)};
  }

  void maskSurfaces() {
    const D d;
    for (std::size_t n = 0; n < kept_; n += hn::Lanes(d)) {
      const std::size_t count = std::min(kept_ - n, hn::Lanes(d));
      const V shown = on_face_ ? mask_.shownAt(n, count) : mask_.shownOnSides(n, count);
      hn::StoreU(hn::Mul(shown, hn::LoadU(d, s_.opacity + n)), d, s_.opacity + n);
    }
  }

  // Keeps crossings with the optical depths of their opacities. An opaque face hides what other volumes have in its
  // slab.
  void sumSurfaces() {
    for (std::size_t n = 0; n < kept_; ++n) {
      const float opacity = opacityIn(n, p_.pixelOf(s_.kept_code[n] & CellPlaces::kPixel)[3]);
      s_.opacity[n] = on_face_ && opacity >= 1 ? kOpaqueFace : static_cast<float>(extinctionOf(opacity, 1));
    }
    keepAll();
  }

  // Finds the gradients of a batch of samples, for slopesAt.
  HWY_INLINE void findSlopes(std::size_t n, std::size_t count) {
    if (lit_by_mask_) mask_.findSlopes(n, count);
    field_.findSlopes(n, count);
  }

  // Gradients that give the normals of a vector of samples: the field's, or the mask's at its surface.
  HWY_INLINE Vector slopesAt(std::size_t i) const {
    const Vector slope = field_.slopes(i);
    return lit_by_mask_ ? mask_.slopesOr(slope, i) : slope;
  }

  // Stores the gradients of a vector of samples, for finishing.
  void keepSlopes(std::size_t n, std::size_t count) {
    findSlopes(n, count);
    keepSlope(n, field_.slopes(0));
  }

  HWY_INLINE void keepSlope(std::size_t n, const Vector& slope) {
    const D d;
    hn::StoreU(slope.x, d, s_.slope[0] + n);
    hn::StoreU(slope.y, d, s_.slope[1] + n);
    hn::StoreU(slope.z, d, s_.slope[2] + n);
  }

  // Computes the voxel before each sample, and the position between voxels.
  template <bool kPieces>
  void placeAll() {
    const D d;
    const DI di;
    for (std::size_t n = 0; n < count_; n += hn::Lanes(d)) {
      const CellPlaces::Where w = p_.sampleOf<kPieces>(hn::Load(di, s_.code + n));
      // Relative to the voxel before the cell, which begins half a voxel behind it.
      VI voxel[3];
      for (int a = 0; a < 3; ++a) {
        const V at = p_.indexOf(a, w, in_.lo[a]);
        // Rounding, or the middle of a piece, may put a sample just outside the cell.
        const V inside = hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, kPatchVoxels + 1.0f));
        voxel[a] = hn::Min(hn::ConvertTo(di, inside), hn::Set(di, kPatchVoxels));
        hn::Store(hn::Sub(inside, hn::ConvertTo(d, voxel[a])), d, s_.fraction[a] + n);
      }
      hn::Store(offsetOf(voxel), di, s_.offset + n);
    }
  }

  // Keeps the visible samples, by index.
  void classifyAll() {
    const D d;
    const DI di;
    kept_ = 0;
    for (std::size_t n = 0; n < count_; n += hn::Lanes(d)) {
      const V value = field_.values(n), entry = placeOf(d, l_, value);
      const VI index = hn::Iota(di, static_cast<int>(n));
      M shows = lanesBefore(n, count_);
      if (kGaps) shows = hn::And(shows, hn::Eq(value, value));
      V tau = hn::Zero(d);
      if (l_.integral != nullptr) {
        tau = meanExtinctionOf(n, value, entry, shows);
        shows = hn::And(shows, hn::Gt(tau, hn::Zero(d)));
      } else {
        shows = hn::And(shows, visible(entry, entry));
      }
      const Packing packed(shows);
      if (l_.integral != nullptr) hn::StoreU(packed(tau), d, s_.opacity + kept_);
      hn::StoreU(packed(index), di, s_.index + kept_);
      hn::StoreU(packed(hn::Load(di, s_.code + n)), di, s_.kept_code + kept_);
      hn::StoreU(packed(entry), d, s_.entry + kept_);
      kept_ += hn::CountTrue(d, shows);
    }
  }

  // Mean extinction of a vector of samples from the n-th on, at table positions `entry`.
  HWY_NOINLINE V meanExtinctionOf(std::size_t n, V value, V entry, M alive) {
    const D d;
    const D4 d4;
    const std::size_t count = std::min(count_ - n, hn::Lanes(d));
    // Rows along x through the sample, and one voxel before and after the sample along y and z.
    enum { kHere, kBeforeY, kAfterY, kBeforeZ, kAfterZ, kRows };
    alignas(64) float rows[kRows][4 * kLanes] = {};
    for (std::size_t lane = 0; lane < count; ++lane) {
      const float* const at = in_.values + s_.offset[n + lane] - 1;
      const auto y = hn::Set(d4, s_.fraction[1][n + lane]), z = hn::Set(d4, s_.fraction[2][n + lane]);
      for (std::size_t i = 0; i < 4; i += hn::Lanes(d4)) {
        const auto row = [&](int dy, int dz) { return hn::LoadU(d4, at + dz * kPlane + dy * kPatchStride + i); };
        const auto through = [&](int dy, int dz) {
          return mix(d4, mix(d4, row(dy, dz), row(dy, dz + 1), z), mix(d4, row(dy + 1, dz), row(dy + 1, dz + 1), z), y);
        };
        hn::Store(through(0, 0), d4, rows[kHere] + 4 * lane + i);
        hn::Store(through(-1, 0), d4, rows[kBeforeY] + 4 * lane + i);
        hn::Store(through(1, 0), d4, rows[kAfterY] + 4 * lane + i);
        hn::Store(through(0, -1), d4, rows[kBeforeZ] + 4 * lane + i);
        hn::Store(through(0, 1), d4, rows[kAfterZ] + 4 * lane + i);
      }
    }
    const V x = hn::Load(d, s_.fraction[0] + n);
    const auto of = [&](int row, std::size_t first) {
      V v[4];
      hn::LoadInterleaved4(d, rows[row], v[0], v[1], v[2], v[3]);
      return mix(d, v[first], v[first + 1], x);
    };
    const V before[3] = {of(kHere, 0), of(kBeforeY, 1), of(kBeforeZ, 1)};
    const V after[3] = {of(kHere, 2), of(kAfterY, 1), of(kAfterZ, 1)};
    const V place = hn::IfThenElseZero(alive, entry);
    const V at_point = extinctionAt(d, l_, place);
    return meanExtinction(d, l_, intervalOf(d, value, before, after), place, alive, at_point);
  }

  // Computes the opacities of visible samples; for several volumes, the optical depths. Equation (6).
  template <bool kPieces>
  void attenuateAll() {
    const D d;
    // Vectors beyond the last sample look up the table's first entry.
    hn::StoreU(hn::Zero(d), d, s_.entry + kept_);
    const bool asks = kPieces || l_.perspective || in_.in_pairs || derives_;
    const bool masked = in_.mask != nullptr;
    for (std::size_t n = 0; n < kept_; n += hn::Lanes(d)) {
      V tau = l_.integral != nullptr ? hn::Load(d, s_.opacity + n) : extinctionAt(d, l_, hn::Load(d, s_.entry + n));
      if (masked) tau = hn::Mul(tau, mask_.shownAt(n, std::min(kept_ - n, hn::Lanes(d))));
      V length = hn::Set(d, l_.thickness);
      if (asks) {
        const std::size_t count = std::min(kept_ - n, hn::Lanes(d));
        const CellPlaces::Where w = p_.sampleOf<kPieces>(hn::Load(DI(), s_.kept_code + n));
        length = hn::Mul(hn::Mul(length, p_.sightOf(w).oblique), w.slabs);
        if (derives_) keepSlopes(n, count);
        if (modulates_) tau = modulatedTau(n, tau);
        // Opacity depends on the gradient of the values; light depends on the normal.
        if (derives_ && lit_by_mask_) keepSlope(n, mask_.slopesOr(slopesFrom(n), 0));
        if (places_) keepPlaces(n, w);
      }
      const V depth = hn::Mul(tau, length);
      hn::Store(in_.sums != nullptr ? depth : opacityOf(d, depth), d, s_.opacity + n);
    }
  }

  // Multiplies opacities by the factors of their gradients.
  HWY_NOINLINE V modulatedTau(std::size_t n, V tau) {
    const D d;
    const SampleLattice::Plane& plane = l_.plane;
    const V row = planeRowOf(d, plane, slopesFrom(n));
    if (plane.colors != nullptr) hn::StoreU(row, d, s_.row + n);
    const V factor = planeFactorAt(d, plane, planePlaceOf(d, plane, hn::LoadU(d, s_.entry + n), row));
    return modulatedExtinction(d, plane, tau, factor);
  }

  // The gradients that were kept for samples from the n-th on.
  HWY_INLINE Vector slopesFrom(std::size_t n) const {
    const D d;
    return {hn::LoadU(d, s_.slope[0] + n), hn::LoadU(d, s_.slope[1] + n), hn::LoadU(d, s_.slope[2] + n)};
  }

  // Stores the positions of samples, the slabs that the samples cover, and the faces that light the samples.
  HWY_INLINE void keepPlaces(std::size_t n, const CellPlaces::Where& w) {
    const D d;
    for (int a = 0; a < 3; ++a) hn::StoreU(p_.indexOf(a, w, 0), d, s_.index_place[a] + n);
    hn::StoreU(w.slabs, d, s_.slabs + n);
    if (in_.lit_by.empty()) return;
    const FaceSlopes::Face face = faces_.at(w);
    hn::StoreU(face.slope.x, d, s_.face_slope[0] + n);
    hn::StoreU(face.slope.y, d, s_.face_slope[1] + n);
    hn::StoreU(face.slope.z, d, s_.face_slope[2] + n);
    hn::StoreU(face.share, d, s_.face_share + n);
  }

  SampleSite siteOf(std::size_t n) const {
    SampleSite out;
    for (int a = 0; a < 3; ++a)
      out.index[a] = static_cast<double>(r_.anchor[a]) + static_cast<double>(s_.index_place[a][n]);
    out.gradient = {s_.slope[0][n], s_.slope[1][n], s_.slope[2][n]};
    if (!std::isfinite(out.gradient.x + out.gradient.y + out.gradient.z)) out.gradient = glm::vec3(0);
    out.view = context_.projector().viewOfIndex(out.index);
    out.to_eye = context_.projector().towardsEye(out.view);
    if (on_face_ || in_.lit_by.empty()) return out;
    out.face_slope = {s_.face_slope[0][n], s_.face_slope[1][n], s_.face_slope[2][n]};
    out.face_share = s_.face_share[n];
    return out;
  }

  // Composites the visible samples; samples of a pixel come front to back. Keeps samples that contribute, with their
  // weight and, instead of their opacity, the alpha in front of them. A pixel that reaches the threshold is closed; its
  // colour is divided by alpha after all its light has been added. Equations (8) and (9).
  void blendAll() {
    const bool overlaps = l_.surfaces > 0 && r_.overlap != 0 && !on_face_;
    if (overlaps || tile_.aovs.any() || tile_.shadows != nullptr)
      blendEach<false>();
    else
      blendEach<true>();
    keepSeen();
    if (tile_.shadows != nullptr) kept_ = 0;  // a light's view has no light
  }

  // kColorsOnly: the picture has neither planes nor shadows, nor surfaces where two levels overlap. A frame of cthead
  // then takes 0.96 to 0.99 of the general version's time.
  template <bool kColorsOnly>
  HWY_NOINLINE void blendEach() {
    std::size_t closed = 0;
    const bool any_aovs = tile_.aovs.any();
    for (std::size_t n = 0; n < kept_; ++n) {
      const std::int32_t pixel = s_.kept_code[n] & CellPlaces::kPixel;
      float& alpha = p_.pixelOf(pixel)[3];
      // The weight is 0 if the pixel is closed. Branches on opacity or closing would be unpredictable.
      const float before = alpha, opacity = kColorsOnly ? s_.opacity[n] : opacityIn(n, before),
                  weight = (1 - before) * opacity, after = before + weight;
      const bool closes = (after >= opacity_threshold_) & (before != 1.0f);
      alpha = after;
      s_.weight[n] = weight;
      s_.opacity[n] = before;
      if (!kColorsOnly && weight > 0) {
        if (any_aovs) addAovs(n, pixel, before, weight, opacity, closes);
        if (tile_.shadows != nullptr) addShadow(n, before, closes ? 1 : after);
      }
      if (!closes) continue;
      s_.closed[closed++] = {pixel, after};
      alpha = 1.0f;
    }
    closed_count_ = closed;
  }

  // Opacity of a sample in front of which the pixel has an alpha of `before`. In the overlap of two levels a surface
  // counts unless the finer level has drawn it.
  HWY_INLINE float opacityIn(std::size_t n, float before) const {
    if (l_.surfaces == 0 || r_.overlap == 0 || on_face_) return s_.opacity[n];
    const bool in_overlap = s_.at[n] < -r_.middle - 0.5f;
    return in_overlap && before >= s_.opacity[n] ? 0.0f : s_.opacity[n];
  }

  // Keeps the samples with a weight above zero.
  HWY_INLINE void keepSeen() {
    const D d;
    const DI di;
    std::size_t seen = 0;
    for (std::size_t n = 0; n < kept_; n += hn::Lanes(d)) {
      const V weight = hn::Load(d, s_.weight + n);
      const M kept = hn::And(lanesBefore(n, kept_), hn::Gt(weight, hn::Zero(d)));
      const Packing packed(kept);
      const auto move = [&](auto tag, auto* of) { hn::StoreU(packed(hn::Load(tag, of + n)), tag, of + seen); };
      move(di, s_.index), move(di, s_.kept_code), move(d, s_.entry), move(d, s_.opacity);
      if (exact()) move(d, s_.at), move(d, s_.excess[0]);
      for (int a = 0; derives_ && a < 3; ++a) move(d, s_.slope[a]);
      for (int a = 0; places_ && a < 3; ++a) move(d, s_.index_place[a]);
      if (l_.plane.colors != nullptr) move(d, s_.row);
      hn::StoreU(packed(weight), d, s_.weight + seen);
      seen += hn::CountTrue(d, kept);
    }
    out_.shown += kept_;
    out_.samples += seen;
    kept_ = seen;
  }

  // Keeps all samples with optical depth, for sums over several volumes.
  HWY_NOINLINE void keepAll() {
    closed_count_ = 0;
    for (std::size_t n = 0; n < kept_; ++n) {
      const float depth = s_.weight[n] = s_.opacity[n];
      if (in_.sums->hasLayers() && depth > 0) {
        const CellPlaces::Place at = p_.placeOf(s_.kept_code[n]);
        std::optional<float> place;
        if (exact()) place = std::max(s_.at[n] + r_.middle + 0.5f - static_cast<float>(at.slab), 0.0f);
        if (tile_.shadows != nullptr)
          in_.sums->addShade(at.slab, at.x, at.y, depth, place);
        else
          in_.sums->addLayer(at.slab, at.x, at.y, depth, places_ ? normalOf(siteOf(n)) : glm::vec3(0),
                             place.value_or(0.5f), place ? 0.0f : 1.0f);
      }
    }
    keepSeen();
  }

  // Samples have depths of their own, inside their slabs.
  bool exact() const { return l_.surfaces > 0 || on_face_; }

  glm::vec3 normalOf(const SampleSite& site) const {
    return on_face_ ? faceNormal(context_.look(), site) : sampleNormal(context_.look(), site);
  }

  void addShadow(std::size_t n, float before, float after) {
    const SlabZone& zone = context_.zone();
    const std::int32_t code = s_.kept_code[n];
    const CellPlaces::Place at = p_.placeOf(code);
    double near = zone.near + at.slab * zone.thickness;
    double thickness = (code >= CellPlaces::kPair ? 2 : 1) * zone.thickness;
    if (l_.surfaces > 0) {
      near = zone.near + static_cast<double>(s_.at[n] + r_.middle + 0.5f) * zone.thickness;
      thickness *= kShadowLayer;
    }
    tile_.shadows->add(at.x, at.y, static_cast<float>(near), static_cast<float>(near + thickness), before, after);
  }

  HWY_NOINLINE void addAovs(std::size_t n, std::int32_t pixel, float before, float weight, float opacity, bool closes) {
    const SampleSite site = siteOf(n);
    const SlabZone& zone = context_.zone();
    SlabLayer layer;
    layer.before = before;
    layer.added = weight;
    layer.closes = closes;
    layer.opacity = opacity;
    layer.middle = site.view.z;
    layer.thickness = exact() ? 0 : static_cast<double>(s_.slabs[n]) * zone.thickness;
    const glm::vec3 normal = normalOf(site);
    for (int a = 0; a < 3; ++a) layer.normal[a] = weight * normal[a];
    addLayer(layer, tile_.aovs, p_.pixelPlace(pixel));
  }

  // Adds the light of contributing samples, several vectors at a time: scalar work on samples overlaps with vector work
  // on earlier samples.
  void lightAll() {
    for (std::size_t n = 0; n < kept_; n += kLit) light(n, std::min(kept_ - n, kLit));
    for (std::size_t i = 0; i < closed_count_; ++i) {
      const auto [place, alpha] = s_.closed[i];
      const float by[4] = {alpha, alpha, alpha, 1};
      float* const pixel = p_.pixelOf(place);
      for (std::size_t c = 0; c < 4; c += hn::Lanes(D4()))
        hn::StoreU(hn::Div(hn::LoadU(D4(), pixel + c), hn::LoadU(D4(), by + c)), D4(), pixel + c);
      out_.closed[static_cast<std::size_t>(place >> CellPlaces::kPixelBits)] |= std::uint64_t{1}
                                                                                << (place & (kSquareEdge - 1));
    }
  }

  HWY_INLINE void light(std::size_t n, std::size_t count) {
    const D d;
    const D4 d4;
    const SampleTable* const of_faces = on_face_ ? context_.look().faces->colors() : nullptr;
    const bool one_color = in_.color != nullptr && l_.plane.colors == nullptr && of_faces == nullptr;
    if (of_faces != nullptr) {
      colors_.lookUpIn(*of_faces, n, count);
    } else {
      if (!one_color) colors_.lookUp(n, count);
      if (l_.plane.colors != nullptr) colors_.mixRegions(n, count);
    }
    const bool lights = !on_face_ && (l_.light.phong || l_.lights != nullptr);
    if (lights && slopes_) findSlopes(n, count);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      V red, green, blue, unused;
      if (one_color)
        red = hn::Set(d, in_.color[0]), green = hn::Set(d, in_.color[1]), blue = hn::Set(d, in_.color[2]);
      else
        hn::LoadInterleaved4(d, s_.rows[0] + 4 * i, red, green, blue, unused);
      if (lights && l_.light.phong) {
        V matte = hn::Set(d, 1.0f), gloss = hn::Zero(d);
        const Sight sight = p_.sightOf(p_.slabOf(hn::LoadU(DI(), s_.kept_code + n + i)));
        lightOn(d, l_.light, l_.perspective, slopeOf(n, i), sight, matte, gloss);
        if (!in_.lit_by.empty()) lightFace(n + i, sight, matte, gloss);
        const auto lit = [&](V color) { return fused(color, matte, gloss); };
        red = lit(red), green = lit(green), blue = lit(blue);
      } else if (lights) {
        lightAt(n + i, i, count - i, red, green, blue);
      }
      const V weight = hn::LoadU(d, s_.weight + n + i);
      hn::StoreInterleaved4(hn::Mul(weight, red), hn::Mul(weight, green), hn::Mul(weight, blue),
                            in_.sums != nullptr ? weight : hn::Zero(d), d, s_.rows[0] + 4 * i);
    }
    if (tile_.deep != nullptr && in_.sums == nullptr) return addDeep(n, count);
    for (std::size_t i = 0; i < count; ++i) {
      float* const to = lightOf(s_.kept_code[n + i]);
      for (std::size_t c = 0; c < 4; c += hn::Lanes(d4))
        hn::StoreU(hn::Add(hn::LoadU(d4, to + c), hn::Load(d4, s_.rows[0] + 4 * i + c)), d4, to + c);
    }
  }

  // Lights a vector of samples, the i-th of its batch on, in any lights.
  HWY_NOINLINE void lightAt(std::size_t n, std::size_t i, std::size_t count, V& red, V& green, V& blue) const {
    const D d;
    CellPlaces::Where w = p_.sampleOf(hn::LoadU(DI(), s_.kept_code + n));
    if (l_.surfaces > 0) w.t = hn::LoadU(d, s_.at + n);
    const Sight sight = p_.sightOf(w);
    const Vector slope = l_.surfaces > 0 && !derives_ ? outOfSurface(n, slopeOf(n - i, i)) : slopeOf(n - i, i);
    const SampleLight light(*l_.lights, l_.perspective);
    const M alive = hn::FirstN(d, std::min(count, hn::Lanes(d)));
    Colors colors{red, green, blue};
    if (in_.lit_by.empty()) {
      light.on(slope, hn::FirstN(d, 0), sight, p_.viewOf(w, sight), alive, colors);
    } else {
      const FaceSlopes::Face face = faces_.at(w);
      const M none = hn::Eq(face.share, hn::Zero(d)), all = hn::Eq(face.share, hn::Set(d, 1.0f));
      const M on_face = hn::Not(none), in_part = hn::And(alive, hn::AndNot(all, on_face));
      const auto either = [&](V of_face, V own) { return hn::IfThenElse(on_face, of_face, own); };
      const Vector normal{either(face.slope.x, slope.x), either(face.slope.y, slope.y), either(face.slope.z, slope.z)};
      light.on(normal, on_face, sight, p_.viewOf(w, sight), alive, colors);
      if (!hn::AllFalse(d, in_part)) {
        Colors own{red, green, blue};
        light.on(slope, hn::FirstN(d, 0), sight, p_.viewOf(w, sight), in_part, own);
        const auto mixed = [&](V of_face, V inner) {
          return hn::IfThenElse(in_part, fused(face.share, hn::Sub(of_face, inner), inner), of_face);
        };
        colors = {mixed(colors.red, own.red), mixed(colors.green, own.green), mixed(colors.blue, own.blue)};
      }
    }
    red = colors.red, green = colors.green, blue = colors.blue;
  }

  // Mixes the plain light of a vector of samples, the n-th on, with the light of the face in front of the samples.
  HWY_NOINLINE void lightFace(std::size_t n, const Sight& sight, V& matte, V& gloss) const {
    const D d;
    const FaceSlopes::Face face = faces_.at(p_.sampleOf(hn::LoadU(DI(), s_.kept_code + n)));
    if (hn::AllTrue(d, hn::Eq(face.share, hn::Zero(d)))) return;
    V matte_of_face = matte, gloss_of_face = gloss;
    lightOn(d, l_.light, l_.perspective, face.slope, sight, matte_of_face, gloss_of_face);
    const M whole = hn::Eq(face.share, hn::Set(d, 1.0f));
    const auto mixed = [&](V of_face, V own) {
      return hn::IfThenElse(whole, of_face, fused(face.share, hn::Sub(of_face, own), own));
    };
    matte = mixed(matte_of_face, matte), gloss = mixed(gloss_of_face, gloss);
  }

  // The gradients of a batch of samples that begins at the n-th, from its i-th on.
  HWY_INLINE Vector slopeOf(std::size_t n, std::size_t i) const {
    if (derives_) return slopesFrom(n + i);
    const D d;
    return slopes_ ? slopesAt(i) : Vector{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  }

  // Adds light as `light` does, and stores each sample as a deep sample. A sample that closes its pixel includes the
  // effect of the division by alpha.
  HWY_NOINLINE void addDeep(std::size_t n, std::size_t count) {
    const SlabZone& zone = context_.zone();
    // Slabs from the zone's begin to the middles of the pieces, and half of the pieces.
    alignas(64) float middle[kLit], half[kLit];
    const D d;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      const CellPlaces::Where w = p_.sampleOf(hn::LoadU(DI(), s_.kept_code + n + i));
      hn::Store(hn::Add(w.t, hn::Set(d, r_.middle + 0.5f)), d, middle + i);
      hn::Store(hn::Mul(hn::Set(d, 0.5f), w.slabs), d, half + i);
    }
    // Pieces that meet between two slabs have one depth there.
    const auto depthOf = [&](float slabs) {
      const float whole = std::round(slabs), at = std::abs(slabs - whole) < CellPlaces::kRounded ? whole : slabs;
      return static_cast<float>(zone.near + static_cast<double>(at) * zone.thickness);
    };
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t code = s_.kept_code[n + i];
      float* const to = p_.pixelOf(code & CellPlaces::kPixel);
      float before[4] = {0, 0, 0, s_.opacity[n + i]}, after[4] = {0, 0, 0, before[3] + s_.weight[n + i]};
      for (int c = 0; c < 3; ++c) before[c] = to[c], after[c] = to[c] = to[c] + s_.rows[0][4 * i + c];
      if (const float alpha = after[3]; alpha >= opacity_threshold_) {
        for (float& channel : after) channel /= alpha;
      }
      const CellPlaces::Place at = p_.placeOf(code);
      float near = depthOf(middle[i] - half[i]), far = depthOf(middle[i] + half[i]);
      if (exact()) near = far = static_cast<float>(siteOf(n + i).view.z);
      tile_.deep->add(at.x, at.y, near, far, before, after);
    }
  }

  // Returns the four floats to which a sample's light is added.
  HWY_INLINE float* lightOf(std::int32_t code) const {
    if (in_.sums == nullptr) return p_.pixelOf(code & CellPlaces::kPixel);
    const CellPlaces::Place at = p_.placeOf(code);
    return in_.sums->light(at.slab, at.x, at.y);
  }

  // Interpolates between neighbours along an axis, independent of the interpolation of values (Interval).
  template <class Tag, class Vec>
  static HWY_INLINE Vec mix(Tag d, Vec a, Vec b, Vec t) {
    return LinearCellField<kGaps>::mix(d, a, b, t);
  }

  const RaySampling& r_;
  const SlabContext& context_;
  const SampleLattice& l_;
  const CellInput& in_;
  const TilePixels& tile_;
  const float opacity_threshold_;
  const bool modulates_;    // opacities depend on gradients
  const bool places_;       // positions and gradients of samples are kept
  const bool derives_;      // gradients of samples are kept
  const bool slopes_;       // light needs gradients that are not kept
  const bool lit_by_mask_;  // a solid has the normals of its mask's surface; an iso-surface ends at the mask
  CellPlaces p_;
  const FaceSlopes faces_;
  Field field_;
  MaskSamples mask_;
  SampleColors colors_;
  CellSamples& s_;
  CellOutput& out_;
  bool on_face_ = false;  // the samples are points on cut faces
  std::size_t count_ = 0, kept_ = 0, closed_count_ = 0;
};

void castRaysInCellOn(const RaySampling& rays, const SlabContext& context, const CellInput& in, const TilePixels& tile,
                      float opacity_threshold, CellSamples& samples, CellOutput& out) {
  const auto cast = [&]<class Field, bool kGaps>(std::type_identity<Field>, std::bool_constant<kGaps>) {
    CellCaster<Field, kGaps>(rays, context, in, tile, opacity_threshold, samples, out).run();
  };
  if (in.labels != nullptr)
    cast(std::type_identity<LabelCellField>(), std::false_type());
  else if (context.lattice().interpolation != Interpolation::kLinear)
    cast(std::type_identity<CubicCellField>(), std::true_type());
  else if (in.gaps)
    cast(std::type_identity<LinearCellField<true>>(), std::true_type());
  else
    cast(std::type_identity<LinearCellField<false>>(), std::false_type());
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(castRaysInCellOn);

void castRaysInCell(const RaySampling& rays, const SlabContext& context, const CellInput& in, const TilePixels& tile,
                    float opacity_threshold, CellSamples& samples, CellOutput& out) {
  HWY_DYNAMIC_DISPATCH(castRaysInCellOn)(rays, context, in, tile, opacity_threshold, samples, out);
}

}  // namespace kiln
#endif
