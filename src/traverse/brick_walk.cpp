#include "traverse/brick_walk.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "store/ranges/minmax_octree.h"

namespace kiln {

struct BrickWalk::Visit {
  const PixelRect& image;
  const Visibility& visibility;
  const std::function<void(const BrickKey&, const PixelRect&)>& draw;
  BrickWalkCounts& counts;
  NodeLog* log;
};

BrickWalk::BrickWalk(const BrickedVolume& store, const FrameLevels& levels, BrickSelection selection)
    : store_(store), levels_(levels), selection_(std::move(selection)), brick_size_(store.manifest().brick_size) {
  for (int level = levels.finest(); level <= levels.coarsest(); ++level) {
    Extent3 children{1, 1, 1};
    if (level > levels.finest()) {
      const Extent3& own = levels.span(level);
      const Extent3& finer = levels.span(level - 1);
      children = {own.x / finer.x, own.y / finer.y, own.z / finer.z};
    }
    addLayer({level, brick_size_, children, store.index().lattice(level), {}});
  }
  while (layers_.back().lattice.count() > 1) {
    const Layer& below = layers_.back();
    addLayer({below.level, 2 * below.edge, {2, 2, 2}, brickLattice(below.lattice, 2), {}});
  }
}

void BrickWalk::addLayer(Layer layer) {
  layers_.push_back(std::move(layer));
  Layer& added = layers_.back();
  added.nodes.reserve(static_cast<std::size_t>(added.lattice.count()));
  for (std::int64_t i = 0; i < added.lattice.count(); ++i) {
    const BrickCoord brick = brickAt(added.lattice, i);
    const VoxelCoord at = {brick.x, brick.y, brick.z};
    const bool brick_sized = added.edge == brick_size_;
    const VoxelBox voxels = voxelsOf(added, at);
    const BrickUse use = brick_sized ? selection_.choose_level(added.level, voxels) : BrickUse{false, true};
    Node node;
    if (use.finer) node = sumOfChildren(layers_.size() - 1, at);
    node.finer = node.interesting > 0;
    if (use.itself) {
      const bool shown =
          levels_.clipRegion(added.level).classify(dilated(voxels, selection_.ghosts)) != ClipRegion::Overlap::kOutside;
      const BrickEntry& entry = store_.index().at({added.level, brick});
      node.drawn = shown && visiblePart(added.level, voxels, entry, [](const PixelRect&) { return true; });
      ++node.bricks;
      node.interesting += node.drawn ? 1 : 0;
      node.masked += entry.masked ? 1 : 0;
    }
    added.nodes.push_back(node);
  }
}

bool BrickWalk::visiblePart(int level, const VoxelBox& core, const BrickEntry& entry, const RectTest& test) const {
  return levels_.clipRegion(level).part().touches(core) && selection_.visible_part(level, core, entry, test);
}

BrickWalk::Node BrickWalk::sumOfChildren(std::size_t layer, const VoxelCoord& at) const {
  const Extent3& n = layers_[layer].children;
  Node sum;
  for (std::int64_t z = 0; z < n.z; ++z) {
    for (std::int64_t y = 0; y < n.y; ++y) {
      for (std::int64_t x = 0; x < n.x; ++x) {
        const Node* child = find(layer - 1, {n.x * at.x + x, n.y * at.y + y, n.z * at.z + z});
        if (child == nullptr) continue;
        sum.bricks += child->bricks;
        sum.interesting += child->interesting;
        sum.masked += child->masked;
      }
    }
  }
  return sum;
}

const BrickWalk::Node* BrickWalk::find(std::size_t layer, const VoxelCoord& at) const {
  const Layer& nodes = layers_[layer];
  if (!boxOf(nodes.lattice).contains(at)) return nullptr;
  return &nodes.nodes[static_cast<std::size_t>((at.z * nodes.lattice.y + at.y) * nodes.lattice.x + at.x)];
}

VoxelBox BrickWalk::voxelsOf(const Layer& layer, const VoxelCoord& at) const {
  const VoxelCoord lo = {at.x * layer.edge, at.y * layer.edge, at.z * layer.edge};
  return intersection({lo, {lo.x + layer.edge, lo.y + layer.edge, lo.z + layer.edge}},
                      boxOf(levels_.dims(layer.level)));
}

// Finer voxel centres lie up to half a voxel outside the box around this level's centres, and their footprints are no
// larger than this level's. Dilating by a voxel is therefore conservative.
PixelRect BrickWalk::boundsOf(const Layer& layer, const VoxelBox& voxels, const Node& node) const {
  const bool holds_finer = node.finer && layer.level > levels_.finest();
  const std::int64_t reach = holds_finer || selection_.ghosts > 0 ? 1 : 0;
  return levels_.projector(layer.level).bounds(reach > 0 ? dilated(voxels, reach) : voxels);
}

void BrickWalk::run(const PixelRect& image, const Visibility& visibility,
                    const std::function<void(const BrickKey&, const PixelRect&)>& draw, BrickWalkCounts& counts,
                    NodeLog* log) const {
  const Node& all = layers_.back().nodes.front();
  counts.bricks = all.bricks;
  counts.interesting = all.interesting;
  counts.masked = all.masked;
  node({image, visibility, draw, counts, log}, layers_.size() - 1, {0, 0, 0});
}

std::vector<BrickInView> BrickWalk::inView(const PixelRect& image, BrickWalkCounts& counts) const {
  std::vector<BrickInView> out;
  out.reserve(layers_.back().nodes.front().interesting);
  run(
      image, *makeNoVisibility(),
      [&](const BrickKey& key, const PixelRect& rect) {
        out.push_back({key, rect});
      },
      counts, nullptr);
  return out;
}

void BrickWalk::node(const Visit& visit, std::size_t layer, const VoxelCoord& at) const {
  const Node* node = find(layer, at);
  if (node == nullptr || node->interesting == 0) return;
  const Layer& nodes = layers_[layer];
  const VoxelBox voxels = voxelsOf(nodes, at);
  const PixelRect rect = intersection(boundsOf(nodes, voxels, *node), visit.image);
  if (rect.empty()) return;
  ++visit.counts.nodes_tested;
  const bool hidden = visit.visibility.hidden(rect);
  if (visit.log != nullptr && (hidden || !node->drawn))
    visit.log->add(voxels, std::countr_zero(static_cast<std::uint64_t>(nodes.edge / kCellSize)), hidden);
  if (hidden) {
    ++visit.counts.nodes_hidden;
    return;
  }
  if (node->finer) {
    const Layer& below = layers_[layer - 1];
    const Extent3& n = nodes.children;
    const VoxelCoord first = {n.x * at.x, n.y * at.y, n.z * at.z};
    const VoxelCoord mid = {(first.x + 1) * below.edge, (first.y + 1) * below.edge, (first.z + 1) * below.edge};
    for (const std::uint8_t child : levels_.projector(below.level).order().children(mid)) {
      const VoxelCoord step = {child & 1, child >> 1 & 1, child >> 2};
      // An axis that is not halved has a single child.
      if (!boxOf(n).contains(step)) continue;
      this->node(visit, layer - 1, {first.x + step.x, first.y + step.y, first.z + step.z});
    }
  }
  if (!node->drawn) return;
  const BrickKey key{
      nodes.level, {static_cast<std::int32_t>(at.x), static_cast<std::int32_t>(at.y), static_cast<std::int32_t>(at.z)}};
  // Finer bricks are nearer and may have hidden the brick; the brick's parts are also smaller than `rect`.
  if (open(key, rect, visit.visibility)) visit.draw(key, rect);
}

// Returns whether a part of the brick inside `rect` is neither hidden nor covered.
bool BrickWalk::open(const BrickKey& key, const PixelRect& rect, const Visibility& visibility,
                     std::span<const PixelRect> covered) const {
  const VoxelBox core = coreBox(key.brick, brick_size_, levels_.dims(key.level));
  return visiblePart(key.level, core, store_.index().at(key), [&](const PixelRect& part) {
    const PixelRect touched = intersection(part, rect);
    return !touched.empty() && !visibility.hidden(touched) &&
           std::none_of(covered.begin(), covered.end(), [&](const PixelRect& r) { return r.contains(touched); });
  });
}

bool BrickWalk::hidden(const BrickInView& brick, const Visibility& visibility,
                       std::span<const PixelRect> covered) const {
  return visibility.hidden(brick.rect) || !open(brick.key, brick.rect, visibility, covered);
}

ChooseLevel voxelLevelChoice(const FrameLevels& levels) {
  return [&levels](int level, const VoxelBox& box) {
    const bool itself = levels.fineEnough(level, box);
    return BrickUse{itself, !itself};
  };
}

VisiblePart wholeBrick(const Classifier& classifier) {
  constexpr int kAll = std::numeric_limits<int>::max();
  return [&classifier](int /*level*/, const VoxelBox& /*core*/, const BrickEntry& entry, const RectTest& test) {
    return classifier.interesting(entry.core) && test({-kAll, -kAll, kAll, kAll});
  };
}

}  // namespace kiln
