#include "splat/refine_unit.h"

#include <algorithm>
#include <bit>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/refine_unit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/unit_field-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// The part of a depth spread before `t` beyond its middle.
HWY_INLINE V before(D d, const DepthSpread& s, V t) {
  const V u = hn::Min(hn::Abs(t), hn::Set(d, s.reach));
  const float flat = 0.5f * (s.a - s.b);
  const V v = hn::Max(hn::Sub(u, hn::Set(d, flat)), hn::Zero(d));
  const V slope = hn::Set(d, s.b > 0 ? 0.5f / s.b : 0.0f);
  const V half = hn::Mul(hn::Sub(u, hn::Mul(hn::Mul(v, v), slope)), hn::Set(d, 1.0f / s.a));
  return hn::Add(hn::Set(d, 0.5f), hn::CopySign(half, t));
}

// A unit is refined in two passes. The first goes through the rows of its samples and finds those that may be seen: not
// transparent, in the tile, their footprints not closed. These are few, and are kept one after the other; the second
// pass shades them by full vectors. kDetails: whether details are wanted.
template <class Field, bool kDetails>
class Refiner {
 public:
  Refiner(const UnitLattice& lattice, const UnitInput& unit, const RefinedSamples& out)
      : l_(lattice), u_(unit), out_(out), derives_(lattice.light.phong || kDetails), field_(lattice, unit) {}

  RefinedCounts run() {
    const D d;
    for (int k = u_.first[2]; k < u_.end[2]; ++k) {
      field_.toPlane(k);
      for (int j = u_.first[1]; j < u_.end[1]; ++j) {
        field_.toRow(j);
        for (int i = 0; i < u_.end[0]; i += static_cast<int>(hn::Lanes(d))) find(i, j, k);
        if (found_count_ > kMostFound - kUnitSamples) finish();
      }
    }
    finish();
    return counts_;
  }

 private:
  static constexpr std::size_t kMostFound = 256;

  // Samples found, waiting for the second pass. Room for one vector more, which stores go beyond.
  struct Found {
    alignas(64) std::int32_t code[kMostFound + kUnitSamples];  // i + 2^4 j + 2^8 k, and kCounted where it counts
    alignas(64) float place[kMostFound + kUnitSamples];        // of its value, in the table
    alignas(64) float tau[kMostFound + kUnitSamples];          // where the first pass knows it
    alignas(64) float slope[3][kMostFound + kUnitSamples];
  };

  // Where samples are.
  struct Seen {
    Vector view;
    V u, v;   // across, over depth in perspective
    V r;      // 1 / depth in perspective
    V x, y;   // unit: pixels
    V depth;  // unit: slabs
  };
  HWY_INLINE Seen seen(const Vector& row, V ox) const {
    const D d;
    Seen out;
    out.view = {fused(ox, hn::Set(d, l_.step_x.x), row.x), fused(ox, hn::Set(d, l_.step_x.y), row.y),
                fused(ox, hn::Set(d, l_.step_x.z), row.z)};
    out.u = out.view.x, out.v = out.view.y, out.r = hn::Set(d, 1.0f);
    if (l_.perspective) {
      out.r = hn::Div(out.r, out.view.z);
      out.u = hn::Mul(out.u, out.r), out.v = hn::Mul(out.v, out.r);
    }
    out.x = fused(out.u, hn::Set(d, l_.focal), hn::Set(d, l_.centre_x));
    out.y = fused(out.v, hn::Set(d, l_.focal), hn::Set(d, l_.centre_y));
    out.depth = hn::Mul(hn::Sub(out.view.z, hn::Set(d, l_.near)), hn::Set(d, l_.slabs_per_depth));
    return out;
  }

  // One vector of samples, from sample i of the row on.
  HWY_INLINE void find(int i, int j, int k) {
    const D d;
    const DI di;
    const auto ui = static_cast<std::size_t>(i), uj = static_cast<std::size_t>(j), uk = static_cast<std::size_t>(k);
    M alive;
    const V value = field_.values(ui, alive);
    const VI lane = hn::Add(hn::Iota(di, 0), hn::Set(di, i));
    alive = hn::And(alive, hn::RebindMask(d, hn::And(hn::Gt(lane, hn::Set(di, u_.first[0] - 1)),
                                                     hn::Lt(lane, hn::Set(di, u_.end[0])))));

    const V place = placeOf(d, l_, value);
    if (l_.integral == nullptr) {
      alive = hn::And(
          alive, hn::And(hn::Gt(place, hn::Set(d, l_.visible_after)), hn::Lt(place, hn::Set(d, l_.visible_before))));
      if (hn::AllFalse(d, alive)) return;
    }
    V tau = hn::Zero(d);
    if (knowsTau()) {
      tau = extinctionAt(d, l_, hn::IfThenElseZero(alive, place));
      if (l_.integral != nullptr) tau = meanExtinction(d, l_, field_.interval(i, j, k), place, alive, tau);
      alive = hn::And(alive, hn::Gt(tau, hn::Zero(d)));
      if (hn::AllFalse(d, alive)) return;
    }

    const float oy = u_.axis[1]->offset[uj], oz = u_.axis[2]->offset[uk];
    const glm::vec3 row = u_.origin + oz * l_.step_z + oy * l_.step_y;
    const Seen s =
        seen({hn::Set(d, row.x), hn::Set(d, row.y), hn::Set(d, row.z)}, hn::LoadU(d, &u_.axis[0]->offset[ui]));
    if (l_.perspective) alive = hn::And(alive, hn::Ge(s.view.z, hn::Set(d, l_.near_depth)));
    const Along across = along(s.x, u_.tile.x0), down = along(s.y, u_.tile.y0);
    alive = hn::And(alive, touches(across.window, u_.tile.x0, u_.tile.x1));
    alive = hn::And(alive, touches(down.window, u_.tile.y0, u_.tile.y1));
    const V reach = hn::Set(d, l_.spread.reach);
    const V end = hn::Set(d, static_cast<float>(l_.slabs));
    alive = hn::And(alive, hn::And(hn::Gt(hn::Add(s.depth, reach), hn::Zero(d)), hn::Lt(hn::Sub(s.depth, reach), end)));
    if (hn::AllFalse(d, alive)) return;

    // Counted is a sample of the brick's own, in the tile and the zone where its centre is. Of the zone it then fills
    // a part.
    const bool core_row = j >= u_.core_first[1] && j < u_.core_end[1] && k >= u_.core_first[2] && k < u_.core_end[2];
    M counted = hn::RebindMask(d, hn::And(hn::Gt(lane, hn::Set(di, core_row ? u_.core_first[0] - 1 : kUnitSamples)),
                                          hn::Lt(lane, hn::Set(di, u_.core_end[0]))));
    counted = hn::And(counted, hn::And(within(s.x, u_.tile.x0, u_.tile.x1), within(s.y, u_.tile.y0, u_.tile.y1)));
    counted = hn::And(counted, hn::And(hn::Ge(s.depth, hn::Zero(d)), hn::Lt(s.depth, end)));
    if (u_.windows != nullptr) {
      const M is_open = open(hn::ConvertTo(di, hn::IfThenElseZero(alive, across.window)),
                             hn::ConvertTo(di, hn::IfThenElseZero(alive, down.window)), alive);
      const M closed = hn::AndNot(is_open, alive);
      counts_.closed += static_cast<int>(hn::CountTrue(d, hn::And(closed, counted)));
      alive = hn::AndNot(closed, alive);
      if (hn::AllFalse(d, alive)) return;
    }

    const VI code = hn::Add(hn::Add(lane, hn::Set(di, (j << 4) + (k << 8))),
                            hn::IfThenElseZero(hn::RebindMask(di, counted), hn::Set(di, FootprintPlace::kCounted)));
    const Packing packed(alive);
    const auto keep = [&](V v, float* to) { hn::StoreU(packed(v), d, to + found_count_); };
    hn::StoreU(packed(code), di, found_.code + found_count_);
    keep(place, found_.place);
    if (knowsTau()) keep(tau, found_.tau);
    if (derives_) {
      const Vector slope = field_.gradients(ui);
      keep(slope.x, found_.slope[0]);
      keep(slope.y, found_.slope[1]);
      keep(slope.z, found_.slope[2]);
    }
    found_count_ += hn::CountTrue(d, alive);
  }

  // Whether the first pass asks for extinctions: where places in the table do not say what is transparent.
  bool knowsTau() const { return l_.integral != nullptr || l_.gaps; }

  // The second pass, of what the first has found so far.
  HWY_NOINLINE void finish() {
    for (std::size_t n = 0; n < found_count_; n += hn::Lanes(D())) finishVector(n);
    found_count_ = 0;
  }

  HWY_INLINE void finishVector(std::size_t n) {
    const D d;
    const DI di;
    const auto lanes = static_cast<int>(std::min(found_count_ - n, hn::Lanes(d)));
    M alive = hn::RebindMask(d, hn::Lt(hn::Iota(di, 0), hn::Set(di, lanes)));
    const VI code = hn::IfThenElseZero(hn::RebindMask(di, alive), hn::Load(di, found_.code + n));
    const V place = hn::IfThenElseZero(alive, hn::Load(d, found_.place + n));
    const VI entry = hn::ConvertTo(di, place);
    hn::Store(hn::ShiftLeft<2>(entry), di, kept_.entry);
    hn::Store(hn::Sub(place, hn::ConvertTo(d, entry)), d, kept_.between);
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(lanes); ++lane) classify(lane);
    V red, green, blue, tau;
    hn::LoadInterleaved4(d, kept_.material, red, green, blue, tau);
    if (knowsTau()) tau = hn::Load(d, found_.tau + n);
    alive = hn::And(alive, hn::Gt(tau, hn::Zero(d)));

    const auto index = [&](auto shifted) { return hn::And(shifted, hn::Set(di, kUnitSamples - 1)); };
    const VI i = index(code), j = index(hn::ShiftRight<4>(code)), k = index(hn::ShiftRight<8>(code));
    const V ox = ofAxis(u_.axis[0]->offset, i), oy = ofAxis(u_.axis[1]->offset, j), oz = ofAxis(u_.axis[2]->offset, k);
    const auto row = [&](int c) {
      return hn::Add(hn::Add(hn::Set(d, u_.origin[c]), hn::Mul(oz, hn::Set(d, l_.step_z[c]))),
                     hn::Mul(oy, hn::Set(d, l_.step_y[c])));
    };
    const Seen s = seen({row(0), row(1), row(2)}, ox);
    const V one = hn::Set(d, 1.0f);
    V ray = hn::Set(d, l_.thickness), weight = hn::Set(d, l_.weight), oblique = one;
    if (l_.perspective) {
      oblique = hn::Sqrt(fused(s.u, s.u, fused(s.v, s.v, one)));
      ray = hn::Mul(ray, oblique);
      weight = hn::Mul(weight, hn::Mul(s.r, s.r));
    }

    // The parts of it in its first slab and beyond; none outside of the zone, whose neighbours draw theirs.
    const V reach = hn::Set(d, l_.spread.reach);
    const V end = hn::Set(d, static_cast<float>(l_.slabs));
    const V s0 = hn::Floor(hn::Sub(s.depth, reach));
    const V s1 = hn::Floor(hn::Add(s.depth, reach));
    const V first = hn::Max(s0, hn::Zero(d));
    const V split = before(d, l_.spread, hn::Sub(hn::Add(first, one), s.depth));
    V front = hn::IfThenElse(hn::Gt(s1, first), split, one);
    V back = hn::Sub(one, front);
    const M crossing = hn::Or(hn::Lt(s0, hn::Zero(d)), hn::Ge(s1, end));
    // Where it is not cut, rounding must not ask what the vector's other samples are.
    if (!hn::AllFalse(d, crossing)) {
      const V in_front = before(d, l_.spread, hn::Neg(s.depth)), beyond = before(d, l_.spread, hn::Sub(s.depth, end));
      front = hn::IfThenElse(crossing, hn::Max(hn::Sub(front, in_front), hn::Zero(d)), front);
      back = hn::IfThenElse(crossing, hn::Max(hn::Sub(back, beyond), hn::Zero(d)), back);
      back = hn::IfThenZeroElse(hn::Ge(first, hn::Sub(end, one)), back);
    }
    V third = hn::Zero(d);
    if (l_.three_slabs) {
      const V from = hn::Add(first, hn::Set(d, 2.0f));
      const V there = before(d, l_.spread, hn::Sub(s.depth, from));
      const V beyond = hn::IfThenElseZero(hn::Ge(s1, end), before(d, l_.spread, hn::Sub(s.depth, end)));
      const M reaches = hn::And(hn::Ge(s1, from), hn::Lt(from, end));
      third = hn::IfThenElseZero(reaches, hn::Max(hn::Sub(there, beyond), hn::Zero(d)));
      back = hn::IfThenElse(reaches, hn::Max(hn::Sub(back, third), hn::Zero(d)), back);
    }
    alive = hn::And(alive, hn::Gt(hn::Add(front, back), hn::Zero(d)));
    if (derives_) {
      const Vector slope{hn::Load(d, found_.slope[0] + n), hn::Load(d, found_.slope[1] + n),
                         hn::Load(d, found_.slope[2] + n)};
      if (l_.light.phong) {
        V matte = one, gloss = hn::Zero(d);
        lightOn(d, l_.light, l_.perspective, slope, {s.u, s.v, oblique}, matte, gloss);
        const auto lit = [&](V color) { return fused(color, matte, gloss); };
        red = lit(red), green = lit(green), blue = lit(blue);
      }
      if constexpr (kDetails) note({ox, oy, oz}, slope, s.view, tau, ray);
    }

    if (u_.parts) {
      const V across = hn::Mul(ofAxis(u_.part_y, j), ofAxis(u_.part_z, k));
      weight = hn::Mul(weight, hn::Mul(ofAxis(u_.part_x, i), across));
    }
    const V opacity = opacityOf(d, hn::Mul(tau, ray));
    const Along across = along(s.x, u_.tile.x0), down = along(s.y, u_.tile.y0);
    const VI window = hn::Add(hn::ConvertTo(di, across.window), hn::ShiftLeft<16>(hn::ConvertTo(di, down.window)));
    const VI phases = hn::Add(
        hn::Add(hn::ConvertTo(di, across.phase), hn::ShiftLeft<8>(hn::ConvertTo(di, down.phase))),
        hn::Or(hn::And(code, hn::Set(di, FootprintPlace::kCounted)), hn::Set(di, l_.first_phase * (1 + (1 << 8)))));
    hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(alive, first)), di, kept_.slab);
    hn::StoreInterleaved4(red, green, blue, opacity, d, kept_.light);
    hn::StoreInterleaved4(hn::Mul(weight, front), hn::Mul(weight, back), hn::BitCast(d, window), hn::BitCast(d, phases),
                          d, kept_.parts);
    keepAll(alive);
    const M also = hn::And(alive, hn::Gt(third, hn::Zero(d)));
    if (hn::AllFalse(d, also)) return;
    // What reaches a third slab waits for it as a sample of its own, which is counted already.
    hn::Store(hn::Add(hn::ConvertTo(di, hn::IfThenElseZero(alive, first)), hn::Set(di, 2)), di, kept_.slab);
    hn::StoreInterleaved4(hn::Mul(weight, third), hn::Zero(d), hn::BitCast(d, window),
                          hn::BitCast(d, hn::AndNot(hn::Set(di, FootprintPlace::kCounted), phases)), d, kept_.parts);
    keepAll(also);
  }

  HWY_INLINE void keepAll(M alive) {
    for (unsigned rest = bitsOf(D(), alive); rest != 0; rest &= rest - 1)
      keep(static_cast<std::size_t>(std::countr_zero(rest)));
  }

  // Four channels at once of one lane's sample, which costs less than gathering them for a vector.
  HWY_INLINE void classify(std::size_t lane) {
    using D4 = hn::CappedTag<float, 4>;
    const D4 d;
    const float* const entry = l_.table + kept_.entry[lane];
    const auto part = hn::Set(d, kept_.between[lane]);
    for (std::size_t i = 0; i < 4; i += hn::Lanes(d)) {
      const auto material = between(hn::LoadU(d, entry + i), hn::LoadU(d, entry + 4 + i), part);
      hn::Store(material, d, kept_.material + 4 * lane + i);
    }
  }

  // The sample of this lane of the vector in turn.
  HWY_INLINE void keep(std::size_t lane) {
    SlabSample& to = place(lane);
    std::memcpy(&to.r, kept_.light + 4 * lane, 4 * sizeof(float));
    std::memcpy(&to.front, kept_.parts + 4 * lane, 4 * sizeof(float));
  }

  HWY_INLINE SlabSample& place(std::size_t lane) {
    if constexpr (kDetails) {
      out_.slabs[counts_.samples] = kept_.slab[lane];
      out_.details[counts_.samples] = noted_.at(lane);
      return out_.samples[counts_.samples++];
    } else {
      return out_.waiting->add(static_cast<std::size_t>(std::max(kept_.slab[lane] - out_.first_slab, 0)));
    }
  }

  // The window of a footprint along one axis, counted from the first that touches the tile, and its phase.
  struct Along {
    V window, phase;
  };
  HWY_INLINE Along along(V at, int tile_first) const {
    const D d;
    // Of an odd number of taps the middle one holds the sample, of an even one the nearest border is in the middle.
    const V edge = hn::Add(at, hn::Set(d, l_.taps % 2 == 0 ? 0.5f : 0.0f));
    const V base = hn::Floor(edge);
    constexpr float kPhases = FootprintPlace::kPhases;
    // What rounds to a whole pixel is in the last phase before it.
    const V phase = hn::Min(hn::Mul(hn::Sub(edge, base), hn::Set(d, kPhases)), hn::Set(d, kPhases - 1));
    return {hn::Sub(base, hn::Set(d, static_cast<float>(tile_first + 1 - (l_.taps + 1) / 2))), phase};
  }
  HWY_INLINE M touches(V window, int tile_first, int tile_end) const {
    const D d;
    return hn::And(hn::Ge(window, hn::Zero(d)),
                   hn::Lt(window, hn::Set(d, static_cast<float>(tile_end - tile_first + l_.taps - 1))));
  }

  HWY_INLINE static M within(V at, int first, int end) {
    const D d;
    return hn::And(hn::Ge(at, hn::Set(d, static_cast<float>(first))), hn::Lt(at, hn::Set(d, static_cast<float>(end))));
  }

  HWY_INLINE M open(VI x, VI y, [[maybe_unused]] M alive) const {
    const D d;
    const DI di;
    const VI word = hn::Add(hn::Mul(y, hn::Set(di, u_.windows->stride())), hn::ShiftRight<5>(x));
    const VI bit = hn::Shl(hn::Set(di, 1), hn::And(x, hn::Set(di, 31)));
    return hn::RebindMask(d, hn::Ne(hn::And(openWords(word, hn::RebindMask(di, alive)), bit), hn::Zero(di)));
  }
  // Words near the first lane's, as most are, are found without a gather.
  HWY_INLINE VI openWords(VI word, [[maybe_unused]] hn::Mask<DI> alive) const {
    const DI di;
    const std::int32_t* const words = u_.windows->openWords();
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
    const std::int32_t first = hn::GetLane(hn::Compress(word, alive)) - TileWindows::kWordsBeside;
    const VI from_first = hn::Sub(word, hn::Set(di, first));
    const auto near = hn::Eq(hn::AndNot(hn::Set(di, kUnitSamples - 1), from_first), hn::Zero(di));
    if (hn::AllTrue(di, hn::Or(near, hn::Not(alive))))
      return hn::TableLookupLanes(hn::LoadU(di, words + first),
                                  hn::IndicesFromVec(di, hn::And(from_first, hn::Set(di, kUnitSamples - 1))));
#endif
    return hn::GatherIndex(di, words, word);
  }

  // Of each lane, the axis' number of its index.
  HWY_INLINE static V ofAxis(const std::array<float, kUnitSamples>& numbers, VI index) {
    return lookUp(D(), numbers.data(), index);
  }

  // The vector in turn, for those of its samples that are kept.
  struct Kept {
    alignas(64) std::int32_t entry[16], slab[16];
    alignas(64) float between[16], material[64], light[64], parts[64];
  };

  // Its details, for those.
  struct Noted {
    alignas(64) float offset[3][16], gradient[3][16], view[3][16], tau[16], ray[16];
    SampleDetails at(std::size_t n) const {
      const auto vec = [&](const float(&from)[3][16]) { return glm::vec3(from[0][n], from[1][n], from[2][n]); };
      return {vec(offset), vec(gradient), vec(view), tau[n], ray[n]};
    }
  };
  void note(const Vector& offset, const Vector& slope, const Vector& view, V tau, V ray) {
    const D d;
    const V* const offsets[3] = {&offset.x, &offset.y, &offset.z};
    const V* const slopes[3] = {&slope.x, &slope.y, &slope.z};
    const V* const views[3] = {&view.x, &view.y, &view.z};
    const V sum = hn::Add(hn::Abs(slope.x), hn::Add(hn::Abs(slope.y), hn::Abs(slope.z)));
    const M finite = hn::Lt(sum, hn::Set(d, 1e38f));
    for (int a = 0; a < 3; ++a) {
      hn::Store(*offsets[a], d, noted_.offset[a]);
      hn::Store(hn::IfThenElseZero(finite, *slopes[a]), d, noted_.gradient[a]);
      hn::Store(*views[a], d, noted_.view[a]);
    }
    hn::Store(tau, d, noted_.tau);
    hn::Store(ray, d, noted_.ray);
  }

  const UnitLattice& l_;
  const UnitInput& u_;
  const RefinedSamples& out_;
  const bool derives_;  // whether gradients are asked for
  Field field_;
  RefinedCounts counts_;
  std::size_t found_count_ = 0;
  Found found_;
  Kept kept_;
  Noted noted_;
};

template <class Field>
RefinedCounts refine(const UnitLattice& lattice, const UnitInput& unit, const RefinedSamples& out) {
  return out.details != nullptr ? Refiner<Field, true>(lattice, unit, out).run()
                                : Refiner<Field, false>(lattice, unit, out).run();
}

RefinedCounts refineUnitOn(const UnitLattice& lattice, const UnitInput& unit, const RefinedSamples& out) {
  if (lattice.labels) return refine<LabelField>(lattice, unit, out);
  return lattice.interpolation == Interpolation::kLinear ? refine<LinearField>(lattice, unit, out)
                                                         : refine<CubicField>(lattice, unit, out);
}

const char* nameOfTarget() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(refineUnitOn);
HWY_EXPORT(nameOfTarget);

RefinedCounts refineUnit(const UnitLattice& lattice, const UnitInput& unit, const RefinedSamples& out) {
  return HWY_DYNAMIC_DISPATCH(refineUnitOn)(lattice, unit, out);
}

const char* instructionSet() { return HWY_DYNAMIC_DISPATCH(nameOfTarget)(); }

}  // namespace kiln
#endif
