#include "frame/brick_walk.h"

#include <bit>

namespace kiln {

struct BrickWalk::Visit {
  const Projector& projector;
  const PixelRect& image;
  const Visibility& visibility;
  const std::function<void(const BrickKey&, const PixelRect&)>& draw;
  BrickWalkCounts& counts;
  NodeLog* log;
};

BrickWalk::BrickWalk(const StoreReader& store, int level, const Classifier& classifier)
    : level_(level),
      brick_size_(store.manifest().brick_size),
      cell_levels_(std::countr_zero(static_cast<std::uint64_t>(brick_size_ / kCellSize))),
      dims_(store.level(level).geometry.dims) {
  const Extent3& lattice = store.index().lattice(level);
  Layer bricks{lattice, {}};
  bricks.interesting.reserve(static_cast<std::size_t>(lattice.count()));
  for (std::int64_t i = 0; i < lattice.count(); ++i) {
    const BrickEntry& entry = store.index().at({level, brickAt(lattice, i)});
    bricks.interesting.push_back(classifier.interesting(entry.core) ? 1 : 0);
  }
  layers_.push_back(std::move(bricks));
  while (layers_.back().nodes.count() > 1) {
    const Layer& fine = layers_.back();
    Layer coarse{brickLattice(fine.nodes, 2), {}};
    coarse.interesting.assign(static_cast<std::size_t>(coarse.nodes.count()), 0);
    std::size_t i = 0;
    for (std::int64_t z = 0; z < fine.nodes.z; ++z) {
      for (std::int64_t y = 0; y < fine.nodes.y; ++y) {
        for (std::int64_t x = 0; x < fine.nodes.x; ++x) {
          coarse.interesting[static_cast<std::size_t>((z / 2 * coarse.nodes.y + y / 2) * coarse.nodes.x + x / 2)] +=
              fine.interesting[i++];
        }
      }
    }
    layers_.push_back(std::move(coarse));
  }
}

std::uint32_t BrickWalk::interestingBelow(int layer, const VoxelCoord& at) const {
  const Layer& nodes = layers_[static_cast<std::size_t>(layer)];
  if (!boxOf(nodes.nodes).contains(at)) return 0;
  return nodes.interesting[static_cast<std::size_t>((at.z * nodes.nodes.y + at.y) * nodes.nodes.x + at.x)];
}

VoxelBox BrickWalk::voxelsOf(int layer, const VoxelCoord& at) const {
  const std::int64_t edge = brick_size_ << layer;
  const VoxelCoord lo = {at.x * edge, at.y * edge, at.z * edge};
  return intersection({lo, {lo.x + edge, lo.y + edge, lo.z + edge}}, boxOf(dims_));
}

void BrickWalk::run(const Projector& projector, const PixelRect& image, const Visibility& visibility,
                    const std::function<void(const BrickKey&, const PixelRect&)>& draw, BrickWalkCounts& counts,
                    NodeLog* log) const {
  const int top = static_cast<int>(layers_.size()) - 1;
  counts.interesting = interestingBelow(top, {0, 0, 0});
  node({projector, image, visibility, draw, counts, log}, top, {0, 0, 0});
}

std::vector<BrickInView> BrickWalk::inView(const Projector& projector, const PixelRect& image,
                                           BrickWalkCounts& counts) const {
  std::vector<BrickInView> out;
  run(
      projector, image, *makeNoVisibility(),
      [&](const BrickKey& key, const PixelRect& rect) {
        out.push_back({key, rect});
      },
      counts, nullptr);
  return out;
}

void BrickWalk::node(const Visit& visit, int layer, const VoxelCoord& at) const {
  const std::uint32_t interesting = interestingBelow(layer, at);
  if (interesting == 0) return;
  const PixelRect rect = intersection(visit.projector.bounds(voxelsOf(layer, at)), visit.image);
  if (rect.empty()) return;
  ++visit.counts.nodes_tested;
  const bool hidden = visit.visibility.hidden(rect);
  if (visit.log != nullptr && (hidden || layer > 0)) visit.log->add(voxelsOf(layer, at), cell_levels_ + layer, hidden);
  if (hidden) {
    ++visit.counts.nodes_hidden;
    visit.counts.hidden += interesting;
    return;
  }
  if (layer == 0) {
    visit.draw(
        {level_, {static_cast<std::int32_t>(at.x), static_cast<std::int32_t>(at.y), static_cast<std::int32_t>(at.z)}},
        rect);
    return;
  }
  const std::int64_t half = brick_size_ << (layer - 1);
  const VoxelCoord mid = {(2 * at.x + 1) * half, (2 * at.y + 1) * half, (2 * at.z + 1) * half};
  for (const std::uint8_t child : visit.projector.order().children(mid))
    node(visit, layer - 1, {2 * at.x + (child & 1), 2 * at.y + (child >> 1 & 1), 2 * at.z + (child >> 2)});
}

}  // namespace kiln
