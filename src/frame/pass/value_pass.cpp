#include "frame/pass/value_pass.h"

#include <utility>

#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "frame/pass/frame_progress.h"
#include "traverse/prefetcher.h"

namespace kiln {

PixelRect ValuePass::draw(const PassTarget& target, PassContext& context) {
  ValueProjection& projection = engine();
  const BrickIndex& index = store().index();
  const PixelRect& pixels = target.pixels.rect;
  BrickCache& cache = context.cache;
  BrickWalkCounts& walked = context.costs.walked;
  projection.begin(pixels);
  const std::vector<BrickInView> bricks = projection.ordered(walk().inView(pixels, walked));
  std::vector<BrickInView> with_file;
  for (const BrickInView& brick : bricks) {
    if (!index.at(brick.key).constant) with_file.push_back(brick);
  }
  // Nothing is opaque: earlier bricks cover no pixels.
  Prefetcher prefetcher(
      std::move(with_file), [&](const BrickInView& brick, auto /*covered*/) { return projection.hidden(brick); },
      place());
  prefetcher.announce(cache);
  PartProgress part(context.progress, "bricks", bricks.size());
  std::uint64_t passed = 0;
  for (const BrickInView& brick : bricks) {
    context.progress.throwIfCancelled("rendering");
    part.reached(passed++);
    const bool hidden = projection.hidden(brick);
    ++walked.nodes_tested;
    walked.nodes_hidden += hidden ? 1 : 0;
    walked.hidden += hidden ? 1 : 0;
    if (hidden) continue;
    std::shared_ptr<const BrickBlock> block;
    if (!index.at(brick.key).constant) {
      block = cache.get(stored(brick.key));
      prefetcher.turnOf(brick.key);
      prefetcher.announce(cache);
      if (!block) {
        context.costs.statistics.damaged.insert(stored(brick.key));
        continue;
      }
    }
    const ProfileScope drawing(Activity::kBrick);
    const DrawCounts drawn = drawBrick({{brick.key}, brick.rect, std::move(block)}, target);
    addCosts(brick.key, drawn, context.costs);
    prefetcher.drew(brick.key, drawn.changed);
  }
  projection.finish(request().transfer_function, target.pixels);
  part.finish();
  return pixels;
}

DrawCounts ValuePass::drawBrick(const BrickToDraw& brick, const PassTarget& target) {
  const std::unique_ptr<const PreparedBrick> prepared = engine().prepare(brick);
  const PreparedBrick* const bricks[] = {prepared.get()};
  const std::vector<PixelRect> tiles = tilesOf(request().tile_px, target.pixels.rect, brick.rect);
  std::vector<DrawCounts> counts(tiles.size());
  parallelFor(tiles.size(), [&](std::size_t i) {
    engine().draw(bricks,
                  {target.pixels.of(tiles[i]), target.visibility, target.opacity_threshold, std::span(&counts[i], 1)});
  });
  DrawCounts total;
  for (const DrawCounts& tile : counts) total.add(tile);
  return total;
}

}  // namespace kiln
