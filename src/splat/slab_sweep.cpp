#include "splat/slab_sweep.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "splat/finish_sample.h"
#include "splat/join_volumes.h"
#include "splat/label_samples.h"
#include "splat/lay_sheet.h"
#include "splat/pixel_slabs.h"
#include "splat/sample_window.h"
#include "splat/slab_layer.h"
#include "splat/unit_load.h"
#include "splat/waiting_samples.h"

namespace kiln {

struct SweepMemory::Parts {
  // Of a block, what each pixel, all of them and any of them own. shape: rows of kBlockEdge.
  struct OwnedBlock {
    SlabSpan all, any;
    std::array<SlabSpan, kBlockEdge * kBlockEdge> pixels;
  };
  struct Unit {
    VoxelCoord lo;
    PixelRect rect;
    const BrickBlock* block;
    std::size_t volume;
    bool inside;  // of the tile and the zone
  };
  struct OfVolume {
    WaitingSamples<SlabSample> waiting;  // by their slab
    WaitingSamples<AovSample> waiting_aovs;
    Sheet sheets[2], aov_sheets[2];
    std::optional<SampleWindow> window;  // of this sweep
    std::size_t bytes() const {
      std::size_t sum = sizeof *this + waiting.bytes() + waiting_aovs.bytes();
      for (int i = 0; i < 2; ++i) sum += sheets[i].bytes() + aov_sheets[i].bytes();
      return sum;
    }
  };
  std::vector<SweptCell> cells;          // by their first slab
  std::vector<std::vector<Unit>> units;  // by their first slab, from the sweep's first
  std::vector<OfVolume> volumes;
  std::vector<SlabSample> refined;  // with details
  std::vector<std::int32_t> slabs;  // of each of them
  std::vector<const SlabSample*> visible;
  std::vector<const AovSample*> visible_aovs;
  std::vector<SampleDetails> details;
  TileWindows windows;
  std::vector<OwnedBlock> owned;         // of the tile's blocks
  std::unique_ptr<LabelSamples> labels;  // where a volume is of labels
  alignas(64) float values[(kUnitVoxels + 2 * kUnitMargin) * (kUnitVoxels + 2 * kUnitMargin) * kUnitSamples];
};

SweepMemory::SweepMemory() : parts_(std::make_unique<Parts>()) {}
SweepMemory::~SweepMemory() = default;

std::size_t SweepMemory::bytes() const {
  const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
  const Parts& p = *parts_;
  std::size_t sum = sizeof p + (p.labels ? sizeof *p.labels : 0) + of(p.cells) + of(p.refined) + of(p.slabs) +
                    p.windows.bytes() + of(p.visible) + of(p.visible_aovs) + of(p.details) + of(p.owned) + of(p.units);
  for (const Parts::OfVolume& volume : p.volumes) sum += volume.bytes();
  for (const std::vector<Parts::Unit>& units : p.units) sum += of(units);
  return sum;
}

namespace {

using OwnedBlock = SweepMemory::Parts::OwnedBlock;
using Unit = SweepMemory::Parts::Unit;
using OfVolume = SweepMemory::Parts::OfVolume;

// What is swept, and where to.
struct SweepInput {
  std::span<const SlabFrame* const> frames;
  const SlabFrame& any;     // one of them
  const BrickBlock* owner;  // the brick whose pixels of slabs are drawn; null where all are
  const TilePixels& tile;
  Visibility& visibility;
  bool test_samples;
  float opaque_at;
};

class Sweep {
 public:
  Sweep(const SweepInput& in, SweepMemory::Parts& memory, std::span<SplatCounts> counts)
      : frames_(in.frames),
        zone_(in.any.zone()),
        projector_(in.any.projector()),
        any_(in.any),
        owner_(in.owner),
        tile_(in.tile),
        visibility_(in.visibility),
        test_samples_(in.test_samples),
        opaque_at_(in.opaque_at),
        m_(memory),
        counts_(counts),
        aovs_(tile_.aovs.any()),
        part_(in.any.look().clip->part()),
        parted_(!part_.all()) {}

  // requires: the cells are in the memory.
  void run() {
    std::sort(m_.cells.begin(), m_.cells.end(),
              [](const SweptCell& a, const SweptCell& b) { return a.cell->bounds.first < b.cell->bounds.first; });
    begin_ = m_.cells.front().cell->bounds.first;
    int end = 0;
    for (const SweptCell& swept : m_.cells) end = std::max(end, swept.cell->bounds.last + 1);
    // A sample puts light into the slab after its own, too.
    const auto slabs = static_cast<std::size_t>(end - begin_ + 1);
    if (m_.units.size() < slabs) m_.units.resize(slabs);
    if (m_.volumes.size() < frames_.size()) m_.volumes.resize(frames_.size());
    for (std::size_t v = 0; v < frames_.size(); ++v) reset(v, slabs);
    m_.windows.reset(tile_, any_.footprint().taps());
    owned_known_ = 0;
    std::size_t next = 0;
    for (int slab = begin_; slab <= end; ++slab) {
      for (; next < m_.cells.size() && m_.cells[next].cell->bounds.first <= slab; ++next) cut(m_.cells[next], slab);
      const auto i = static_cast<std::size_t>(slab - begin_);
      for (const Unit& unit : m_.units[i]) refine(unit);
      m_.units[i].clear();
      std::uint64_t dirty = 0;
      for (std::size_t v = 0; v < frames_.size(); ++v) dirty |= fillSheets(v, slab, i);
      if (dirty != 0) composite(dirty, slab);
    }
  }

 private:
  void reset(std::size_t v, std::size_t slabs) {
    OfVolume& volume = m_.volumes[v];
    volume.window.reset();
    if (frames_[v] != nullptr) volume.window.emplace(frames_[v]->lattice(), frames_[v]->sampleReach(), tile_.rect);
    volume.waiting.reset(slabs);
    for (Sheet& sheet : volume.sheets) sheet.reset(tile_.rect, any_.footprint(), any_.colorUnit());
    if (!aovs_) return;
    volume.waiting_aovs.reset(slabs);
    for (Sheet& sheet : volume.aov_sheets) sheet.reset(tile_.rect, any_.footprint());
  }

  // The samples of a slab, i-th of the sweep, whose turn has come; returns the blocks that the slab has light in.
  std::uint64_t fillSheets(std::size_t v, int slab, std::size_t i) {
    OfVolume& volume = m_.volumes[v];
    Sheet &here = volume.sheets[slab & 1], &behind = volume.sheets[(slab + 1) & 1];
    volume.waiting.take(i, [&](std::span<const SlabSample> samples) { splat(v, samples, here, behind); });
    if (aovs_) {
      Sheet &aovs = volume.aov_sheets[slab & 1], &aovs_behind = volume.aov_sheets[(slab + 1) & 1];
      volume.waiting_aovs.take(i,
                               [&](std::span<const AovSample> samples) { splatAovs(v, samples, aovs, aovs_behind); });
    }
    return here.dirty();
  }

  bool hidden(const PixelRect& rect, SplatCounts& counts) {
    ++counts.nodes_tested;
    const bool is = visibility_.hidden(rect);
    counts.nodes_hidden += is ? 1 : 0;
    return is;
  }

  bool allOpen(const PixelRect& rect) const {
    const int x = tile_.rect.x0, y = tile_.rect.y0;
    return m_.windows.allOpen({rect.x0 - x, rect.y0 - y, rect.x1 - x, rect.y1 - y});
  }

  // The units of a cell wait for their first slabs. They are aligned in index space, so that a sample has the same
  // arithmetic in every brick.
  void cut(const SweptCell& swept, int slab) {
    const SlabCell& cell = *swept.cell;
    const SlabFrame& f = *frames_[swept.volume];
    if (hidden(intersection(cell.bounds.rect, tile_.rect), counts_[swept.volume])) return;
    const std::array<int, 3>& edge = f.lattice().voxels;
    const auto down = [&](int axis) {
      return cell.box.lo[axis] & ~static_cast<std::int64_t>(edge[static_cast<std::size_t>(axis)] - 1);
    };
    const bool whole = edge == std::array<int, 3>{kCellSize, kCellSize, kCellSize};
    for (std::int64_t z = down(2); z < cell.box.hi.z; z += edge[2]) {
      for (std::int64_t y = down(1); y < cell.box.hi.y; y += edge[1]) {
        for (std::int64_t x = down(0); x < cell.box.hi.x; x += edge[0]) {
          const VoxelBox box = {{x, y, z}, {x + edge[0], y + edge[1], z + edge[2]}};
          const SlabFrame::Bounds bounds = whole ? cell.bounds : f.boundsOf(intersection(box, cell.box));
          const PixelRect rect = intersection(bounds.rect, tile_.rect);
          if (bounds.empty() || rect.empty()) continue;
          m_.units[static_cast<std::size_t>(std::max(bounds.first, slab) - begin_)].push_back(
              {box.lo, rect, swept.block, swept.volume, bounds.in_zone && rect == bounds.rect});
        }
      }
    }
  }

  void refine(const Unit& unit) {
    if (hidden(unit.rect, counts_[unit.volume])) return;
    const SlabFrame& f = *frames_[unit.volume];
    const UnitLattice& l = f.lattice();
    const UnitRanges ranges = loadUnit(*unit.block, l, f.table().offset(), unit.lo, m_.values);
    if (!f.interesting(ranges.whole.values)) return;
    const int edge = l.voxels[0];
    const auto latticeOf = [&](int first_x, int end_x, const SampledRange& range) {
      const VoxelCoord& lo = unit.lo;
      const VoxelBox block{{lo.x + first_x, lo.y, lo.z}, {lo.x + end_x, lo.y + l.voxels[1], lo.z + l.voxels[2]}};
      return f.softLattice() != nullptr && f.soft(block, range) ? f.softLattice() : &l;
    };
    if (l.blocks == 1) return refine(unit, *latticeOf(0, edge, ranges.whole), ranges.whole.values, 0, edge);
    const int middle = edge / 2;
    const SampledRange &first = ranges.blocks[0], &second = ranges.blocks[1];
    const UnitLattice &of_first = *latticeOf(0, middle, first), &of_second = *latticeOf(middle, edge, second);
    if (&of_first == &of_second) return refine(unit, of_first, ranges.whole.values, 0, edge);
    if (f.interesting(first.values)) refine(unit, of_first, first.values, 0, middle);
    if (f.interesting(second.values)) refine(unit, of_second, second.values, middle, edge);
  }

  // The voxels of a unit from the first to the end along x, with the samples of this lattice, which interpolate values
  // of `range`.
  void refine(const Unit& unit, const UnitLattice& l, const ValueRange& range, int first_x, int end_x) {
    SplatCounts& counts = counts_[unit.volume];
    const SlabFrame& f = *frames_[unit.volume];
    const BrickBlock& block = *unit.block;
    const double offset = f.table().offset();
    const VoxelBox reach = intersection(dilated(block.core, f.ghosts()), boxOf(f.dims()));
    UnitInput in;
    in.values = m_.values;
    in.least = static_cast<float>(range.lo - offset);
    in.most = static_cast<float>(range.hi - offset);
    in.origin = glm::vec3(f.projector().viewOf(unit.lo));
    in.axis = l.axesAt(unit.lo);
    bool ends = false;
    for (int a = 0; a < 3; ++a) {
      const auto ua = static_cast<std::size_t>(a);
      const int from = a == 0 ? first_x : 0, to = a == 0 ? end_x : l.voxels[ua];
      const auto sample = [&](std::int64_t voxel) {
        const auto within = std::clamp<std::int64_t>(voxel - unit.lo[a], from, to);
        return in.axis[ua]->before[static_cast<std::size_t>(within)];
      };
      in.first[ua] = sample(reach.lo[a]), in.end[ua] = sample(reach.hi[a]);
      in.core_first[ua] = sample(block.core.lo[a]), in.core_end[ua] = sample(block.core.hi[a]);
      // Of a unit beside the brick, one block may be beyond what is drawn.
      if (in.first[ua] >= in.end[ua]) return;
      ends = ends || f.ends().last[a] < unit.lo[a] + to;
    }
    if (ends) setParts(f.ends(), unit.lo, l.voxels, in);
    in.tile = tile_.rect;
    if (!unit.inside && !m_.volumes[unit.volume].window->narrow(in)) return;
    if (l.labels && !sampled(unit, in)) return;
    // A sample that is clipped does not count: this is known later.
    if (test_samples_ && !f.detailed() && !allOpen(unit.rect)) in.windows = &m_.windows;
    if (f.detailed() || aovs_)
      refineWithDetails(in, unit, l);
    else
      counts.visited +=
          static_cast<std::uint64_t>(refineUnit(l, in, {&m_.volumes[unit.volume].waiting, begin_}).closed);
  }

  // Where the volume ends in a unit, or where the unit does: of a sample that lies across its end there is a part, be
  // it in its last voxel or in the next one.
  [[gnu::noinline]] static void setParts(const EndVoxels& ends, const VoxelCoord& lo, const std::array<int, 3>& voxels,
                                         UnitInput& in) {
    std::array<float, kUnitSamples>* const parts[3] = {&in.part_x, &in.part_y, &in.part_z};
    for (int a = 0; a < 3; ++a) {
      const auto ua = static_cast<std::size_t>(a);
      parts[a]->fill(1.0f);
      const std::int64_t last = ends.last[a] - lo[a];
      if (last < 0 || last >= voxels[ua]) continue;
      const int end = in.axis[ua]->before[static_cast<std::size_t>(last) + 1];
      if (in.end[ua] < end) continue;
      *parts[a] = in.axis[ua]->partsBefore(static_cast<double>(last) + ends.part[a]);
      if (end < kUnitSamples && (*parts[a])[static_cast<std::size_t>(end)] > 0) {
        if (in.core_end[ua] == end) ++in.core_end[ua];
        ++in.end[ua];
      }
      in.parts = in.parts ||
                 std::any_of(parts[a]->begin(), parts[a]->begin() + in.end[ua], [](float part) { return part != 1; });
    }
  }

  // Whether one of its labels is shown; then it says what its samples are.
  [[gnu::noinline]] bool sampled(const Unit& unit, UnitInput& in) {
    if (!m_.labels) m_.labels = std::make_unique<LabelSamples>();
    const SlabFrame& f = *frames_[unit.volume];
    if (!sampleLabels(*unit.block, f.lattice(), in, unit.lo, f.table(), *m_.labels)) return false;
    in.values = m_.labels->voxels.opacities;
    in.label_places = m_.labels->places;
    return true;
  }

  void refineWithDetails(const UnitInput& in, const Unit& unit, const UnitLattice& l) {
    const SlabFrame& f = *frames_[unit.volume];
    OfVolume& volume = m_.volumes[unit.volume];
    if (const std::size_t most = mostRefined(l, in); m_.refined.size() < most) {
      m_.refined.resize(most);
      m_.slabs.resize(most);
      m_.details.resize(most);
    }
    const RefinedCounts counts = refineUnit(l, in, {nullptr, 0, m_.refined.data(), m_.slabs.data(), m_.details.data()});
    counts_[unit.volume].visited += static_cast<std::uint64_t>(counts.closed);
    const glm::dvec3 edges(in.axis[0]->step, in.axis[1]->step, in.axis[2]->step);
    for (std::size_t i = 0; i < static_cast<std::size_t>(counts.samples); ++i) {
      SlabSample& s = m_.refined[i];
      if (f.detailed() && !finish(f, s, m_.details[i], unit.lo, edges)) continue;
      const int slab = std::max(m_.slabs[i], begin_);
      volume.waiting.add(static_cast<std::size_t>(slab - begin_)) = s;
      if (aovs_) addToWaitingAovs(unit, l, s, slab, m_.details[i]);
    }
  }

  // What is for pictures with AOVs only is apart, so that the loops of the others stay small.
  [[gnu::noinline]] void addToWaitingAovs(const Unit& unit, const UnitLattice& l, const SlabSample& s, int slab,
                                          const SampleDetails& details) {
    const SlabFrame& f = *frames_[unit.volume];
    const float depth = (details.view.z - l.near) * l.slabs_per_depth;
    m_.volumes[unit.volume].waiting_aovs.add(static_cast<std::size_t>(slab - begin_)) =
        aovSample(s, slab, depth, l.spread, finishedNormal(f.look(), siteOf(details, unit.lo)));
  }

  static SampleSite siteOf(const SampleDetails& details, const VoxelCoord& lo) {
    return {glm::dvec3(lo.x, lo.y, lo.z) + glm::dvec3(details.offset), glm::dvec3(details.view), details.gradient};
  }

  // Shades, modulates and clips a sample by itself, which is so many voxels long; false where it is clipped.
  static bool finish(const SlabFrame& f, SlabSample& s, const SampleDetails& details, const VoxelCoord& lo,
                     const glm::dvec3& edges) {
    const SampleLook& look = f.look();
    const SampleSite site = siteOf(details, lo);
    const auto share = static_cast<float>(look.clip->shareOf(site.index, edges));
    if (!(share > 0)) return false;
    s.front *= share, s.back *= share;
    const Color color = finishedColor(look, {s.r, s.g, s.b, details.tau}, site);
    s.r = color.r, s.g = color.g, s.b = color.b;
    s.opacity = -std::expm1(-finishedExtinction(look, details.tau, site) * details.ray);
    return true;
  }

  void splat(std::size_t v, std::span<const SlabSample> samples, Sheet& here, Sheet& next) {
    const PlaceCounts counted = takeVisible(samples, m_.visible, here, next);
    counts_[v].visited += counted.all, counts_[v].splats += counted.open;
    addSamples(m_.visible, frames_[v]->footprint(), here, next);
  }

  // What the samples' colours went to. No pixel has been closed since.
  [[gnu::noinline]] void splatAovs(std::size_t v, std::span<const AovSample> samples, Sheet& here, Sheet& next) {
    takeVisible(samples, m_.visible_aovs, here, next);
    addAovs(m_.visible_aovs, frames_[v]->footprint(), here, next);
  }

  // Samples that count.
  struct PlaceCounts {
    std::uint64_t all = 0, open = 0;
  };

  // Those whose footprints are not closed; their blocks are marked in their sheets.
  template <class Sample>
  PlaceCounts takeVisible(std::span<const Sample> samples, std::vector<const Sample*>& out, Sheet& here,
                          Sheet& next) const {
    PlaceCounts counts;
    out.resize(samples.size());
    std::size_t count = 0;
    std::uint64_t blocks = 0, blocks_behind = 0;
    for (const Sample& s : samples) {
      const bool open = !test_samples_ || m_.windows.open(s.place);
      out[count] = &s;
      count += open ? 1 : 0;
      const int counted = s.place.counted() ? 1 : 0;
      counts.all += counted, counts.open += open ? counted : 0;
      const std::uint64_t touched = open ? m_.windows.blocks(s.place) : 0;
      blocks |= touched;
      blocks_behind |= s.back > 0 ? touched : 0;
    }
    out.resize(count);
    here.mark(blocks);
    next.mark(blocks_behind);
    return counts;
  }

  // The slabs of pixel (x, y) whose middles are in the brick, and in the part of the volume that is drawn; the volume's
  // outermost bricks own what is beyond.
  SlabSpan ownedAt(int x, int y) const {
    const PixelRay ray(projector_, x, y);
    SlabSpan out{0, zone_.slabs};
    for (int a = 0; a < 3; ++a) {
      const VoxelBox& core = owner_->core;
      if (core.lo[a] > 0) out.cut(zone_, ray, a, static_cast<double>(core.lo[a]) - 0.5, true);
      if (core.hi[a] < any_.dims()[a]) out.cut(zone_, ray, a, static_cast<double>(core.hi[a]) - 0.5, false);
      if (!parted_) continue;
      if (std::isfinite(part_.lo[a])) out.cut(zone_, ray, a, part_.lo[a], true);
      if (std::isfinite(part_.hi[a])) out.cut(zone_, ray, a, part_.hi[a], false);
    }
    return out;
  }

  const OwnedBlock& ownedOf(int block, const PixelRect& area) {
    m_.owned.resize(64);
    OwnedBlock& out = m_.owned[static_cast<std::size_t>(block)];
    if ((owned_known_ >> block & 1) != 0) return out;
    owned_known_ |= std::uint64_t{1} << block;
    out.all = {0, zone_.slabs}, out.any = {zone_.slabs, 0};
    for (int y = area.y0; y < area.y1; ++y) {
      for (int x = area.x0; x < area.x1; ++x) {
        const SlabSpan o = ownedAt(x, y);
        out.all = {std::max(out.all.first, o.first), std::min(out.all.end, o.end)};
        out.any = {std::min(out.any.first, o.first), std::max(out.any.end, o.end)};
        out.pixels[static_cast<std::size_t>((y - area.y0) * kBlockEdge + x - area.x0)] = o;
      }
    }
    return out;
  }

  // The open pixels of a block that are the brick's own in this slab.
  BlockBits takesOf(int block, const PixelRect& area, int slab) {
    BlockBits out{};
    const SlabSpan* o = nullptr;
    bool all = true;
    if (owner_ != nullptr) {
      const OwnedBlock& owned = ownedOf(block, area);
      if (slab < owned.any.first || slab >= owned.any.end) return out;
      all = slab >= owned.all.first && slab < owned.all.end;
      o = owned.pixels.data();
    }
    for (int y = 0; y < area.height(); ++y, o += all ? 0 : kBlockEdge) {
      unsigned bits = m_.windows.openPixels(area.x0 - tile_.rect.x0, area.y0 - tile_.rect.y0 + y);
      if (!all) {
        for (int x = 0; x < area.width(); ++x) bits &= ~(slab < o[x].first || slab >= o[x].end ? 1u << x : 0u);
      }
      out[static_cast<std::size_t>(y)] = static_cast<std::uint8_t>(bits);
    }
    return out;
  }

  // Lays the sheets' blocks of the slab behind what is in the image, and empties them. A pixel that reaches the
  // threshold is divided by its alpha and closed.
  void composite(std::uint64_t dirty, int slab) {
    for (std::uint64_t rest = dirty; rest != 0; rest &= rest - 1) {
      const int block = std::countr_zero(rest);
      const PixelRect area = m_.volumes.front().sheets[0].blockRect(block);
      const BlockBits takes = takesOf(block, area, slab);
      if (frames_.size() > 1) join(block, area, slab);
      for (std::size_t v = 0; v < frames_.size(); ++v) {
        if ((m_.volumes[v].sheets[slab & 1].dirty() >> block & 1) != 0) lay(v, area, takes, slab);
      }
    }
    m_.windows.update();
    for (std::size_t v = 0; v < frames_.size(); ++v) {
      m_.volumes[v].sheets[slab & 1].setClear();
      if (aovs_) m_.volumes[v].aov_sheets[slab & 1].clear();
    }
  }

  [[gnu::noinline]] void join(int block, const PixelRect& area, int slab) {
    std::array<VolumeBlock, kMostVolumes> blocks;
    std::size_t count = 0;
    std::ptrdiff_t stride = 0;
    for (std::size_t v = 0; v < frames_.size(); ++v) {
      OfVolume& volume = m_.volumes[v];
      Sheet& sheet = volume.sheets[slab & 1];
      if ((sheet.dirty() >> block & 1) == 0) continue;
      stride = sheet.stride();
      blocks[count++] = {sheet.at(area.x0, area.y0), sheet.filledAt(area.x0, area.y0),
                         aovs_ ? volume.aov_sheets[slab & 1].at(area.x0, area.y0) : nullptr};
    }
    if (count > 1) joinVolumes(std::span(blocks).first(count), stride / 4, area.width(), area.height());
  }

  void lay(std::size_t v, const PixelRect& area, const BlockBits& takes, int slab) {
    Sheet& sheet = m_.volumes[v].sheets[slab & 1];
    SheetBlock in;
    in.pixels = tile_.rgba + 4 * tile_.placeOf(area.x0, area.y0);
    in.sums = sheet.at(area.x0, area.y0);
    in.filled = sheet.filledAt(area.x0, area.y0);
    in.stride = tile_.stride;
    in.columns = sheet.stride() / 4;
    in.covered = tile_.covered + tile_.placeOf(area.x0, area.y0);
    in.erosion = frames_[v]->zone().erosion;
    in.color_unit = sheet.colorUnit();
    in.width = area.width(), in.height = area.height();
    in.takes = takes;
    in.opaque_at = opaque_at_;
    if (aovs_ || tile_.deep != nullptr || tile_.edges != nullptr)
      layTelling(v, in, area, slab);
    else
      close(laySheet(in, nullptr), v, area);
  }

  void close(const LaidBlock& laid, std::size_t v, const PixelRect& area) {
    for (int y = area.y0; y < area.y1; ++y) {
      const auto row = static_cast<std::size_t>(y - area.y0);
      counts_[v].changed = counts_[v].changed || laid.changed[row] != 0;
      for (unsigned rest = laid.opaque[row]; rest != 0; rest &= rest - 1) {
        const int x = area.x0 + std::countr_zero(rest);
        float* const pixel = tile_.rgba + 4 * tile_.placeOf(x, y);
        for (int c = 0; c < 3; ++c) pixel[c] /= pixel[3];
        pixel[3] = 1.0f;
        visibility_.close(x, y);
        m_.windows.close(x - tile_.rect.x0, y - tile_.rect.y0);
      }
    }
  }

  // Lays a block of a volume's sheet, and tells what it added to each pixel beside colours.
  [[gnu::noinline]] void layTelling(std::size_t v, const SheetBlock& block, const PixelRect& area, int slab) {
    LaidPixels pixels;
    float before[kBlockEdge][4 * kBlockEdge];
    for (int y = 0; y < area.height(); ++y) std::copy_n(block.pixels + y * block.stride, 4 * area.width(), before[y]);
    const LaidBlock laid = laySheet(block, &pixels);
    close(laid, v, area);
    for (int y = area.y0; y < area.y1; ++y) {
      const auto row = static_cast<std::size_t>(y - area.y0);
      for (unsigned rest = laid.changed[row]; rest != 0; rest &= rest - 1) {
        const int x = std::countr_zero(rest);
        const std::size_t place = row * kBlockEdge + static_cast<std::size_t>(x);
        if (aovs_) addToAovs(v, area.x0 + x, y, slab, pixels.pixels[place]);
        if (tile_.edges != nullptr) addToEdges(area.x0 + x, y, pixels.pixels[place], pixels.slabs[place]);
        if (tile_.deep != nullptr) addToDeep(area.x0 + x, y, slab, &before[row][4 * x]);
      }
    }
  }

  void addToDeep(int x, int y, int slab, const float* before) {
    const auto depthOf = [&](int border) { return static_cast<float>(zone_.near + border * zone_.thickness); };
    tile_.deep->add(x, y, depthOf(slab), depthOf(slab + 1), before, tile_.rgba + 4 * tile_.placeOf(x, y));
  }

  // Also what is hidden by the part's own slabs: in the whole picture, what is in front of it may make them hide less.
  void addToEdges(int x, int y, const LaidPixel& laid, const LaidPixels::Slab& slab) {
    if (!(slab.part > 0)) return;
    const float alpha = std::min(laid.opacity / laid.filled, 1.0f);
    tile_.edges->add(x, y, {slab.part, {slab.rgb[0], slab.rgb[1], slab.rgb[2], alpha}}, laid.before);
  }

  void addToAovs(std::size_t v, int x, int y, int slab, const LaidPixel& laid) {
    const std::int32_t* const sum = std::as_const(m_.volumes[v].aov_sheets[slab & 1]).at(x, y);
    const float open = laid.share, opacity = laid.opacity;
    SlabLayer layer;
    layer.before = laid.before;
    layer.added = open * opacity;
    layer.closes = laid.before + layer.added >= opaque_at_;
    layer.opacity = opacity / laid.filled;
    layer.filled = std::min(laid.filled / Sheet::kOne, 1.0f);
    layer.turn = fillingOfHalf(erosionOf(layer.opacity, frames_[v]->zone().erosion));
    layer.place = std::clamp(static_cast<float>(sum[3]) / opacity, -0.5f, 0.5f);
    layer.middle = zone_.near + (slab + 0.5) * zone_.thickness;
    layer.thickness = zone_.thickness;
    for (int axis = 0; axis < 3; ++axis) layer.normal[axis] = open * static_cast<float>(sum[axis]);
    addLayer(layer, tile_.aovs, tile_.placeOf(x, y));
  }

  const std::span<const SlabFrame* const> frames_;  // null where a volume has nothing in the zone
  const SlabZone& zone_;
  const Projector& projector_;
  const SlabFrame& any_;
  const BrickBlock* const owner_;
  const TilePixels& tile_;
  Visibility& visibility_;
  const bool test_samples_;
  const float opaque_at_;
  SweepMemory::Parts& m_;
  const std::span<SplatCounts> counts_;  // of each volume
  const bool aovs_;                      // whether the tile has any
  const ClipRegion::Part& part_;
  const bool parted_;
  int begin_ = 0;
  std::uint64_t owned_known_ = 0;  // blocks: a bit each, as a sheet's
};

}  // namespace

void sweepSlabs(const SlabFrame& frame, const BrickBlock& block, std::span<const SlabCell* const> cells,
                const TilePixels& tile, Visibility& visibility, bool test_samples, float opaque_at, SweepMemory& memory,
                SplatCounts& counts) {
  if (cells.empty()) return;
  std::vector<SweptCell>& swept = memory.parts().cells;
  swept.clear();
  for (const SlabCell* const cell : cells) swept.push_back({cell, &block, 0});
  const SlabFrame* const frames[] = {&frame};
  Sweep({frames, frame, &block, tile, visibility, test_samples, opaque_at}, memory.parts(), {&counts, 1}).run();
}

void sweepTogether(std::span<const SlabFrame* const> frames, std::span<const SweptCell> cells, const TilePixels& tile,
                   Visibility& visibility, bool test_samples, float opaque_at, SweepMemory& memory,
                   std::span<SplatCounts> counts) {
  if (cells.empty()) return;
  memory.parts().cells.assign(cells.begin(), cells.end());
  const SlabFrame& any = *frames[cells.front().volume];
  Sweep({frames, any, nullptr, tile, visibility, test_samples, opaque_at}, memory.parts(), counts).run();
}

}  // namespace kiln
