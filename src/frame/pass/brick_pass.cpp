#include "frame/pass/brick_pass.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "frame/pass/frame_progress.h"
#include "frame/pass/tiles_of_bricks.h"
#include "traverse/prefetcher.h"

namespace kiln {
namespace {

// Returns the number of bricks drawn together. Bricks are drawn one by one
// - by a single thread, which gains nothing otherwise, so that its statistics repeat;
// - if the frame is one tile, which is tested in the order of a sequential walk;
// - with the quadtree, whose answers depend on the time of the test.
std::size_t drawnTogether(const FrameRequest& request) {
  const bool in_turn =
      ThreadLimit::active() == 1 || request.tile_px == 0 || request.visibility.method == VisibilityMethod::kQuadtree;
  return in_turn ? 1 : static_cast<std::size_t>(request.bricks_together);
}

// Returns the number of equal parts of the work not yet begun of which a joined tile has at most one. Two for each
// thread: from 1 to 4, times differ by less than noise, some 5 %.
std::uint64_t partsOf(const VolumeEngine& engine, VisibilityMethod method) {
  constexpr std::uint64_t kParts = 2, kNone = ~std::uint64_t{0};
  // Quadtrees test a rectangle by squares of its tile.
  const bool alone = method == VisibilityMethod::kQuadtree || method == VisibilityMethod::kOverlay;
  if (alone || !engine.joinsTiles()) return kNone;
  return ThreadLimit::active() == 1 ? 1 : kParts * ThreadLimit::active();
}

}  // namespace

// Draws one piece of the picture. A brick is due from its turn in the order until it is drawn.
class BrickPass::Drawing {
 public:
  Drawing(const BrickPass& pass, const PassTarget& target, PassContext& context)
      : pass_(pass),
        target_(target),
        context_(context),
        drawn_together_(drawnTogether(pass.request())),
        in_view_(bricksInView(target.pixels.rect)),
        bricks_in_view_(in_view_.size()),
        part_(context.progress, "bricks", bricks_in_view_),
        prefetcher_(std::move(in_view_), [&](const BrickInView& brick, std::span<const PixelRect> before) {
          return pass_.walk().hidden(brick, target_.visibility, before);
        }) {}

  PixelRect run() {
    // The first bricks, too, are read by all threads.
    prefetcher_.announce(context_.cache);
    std::size_t turns = 0;
    const auto draw = [&](const BrickKey& key, const PixelRect& rect) { ++turns, takeTurn({key, rect}); };
    pass_.walk().run(target_.pixels.rect, target_.visibility, draw, context_.costs.walked, pass_.request().node_log);
    context_.costs.walked.hidden += bricks_in_view_ - turns;
    drawDue();
    part_.finish();
    return shown_;
  }

 private:
  struct DueBrick {
    BrickToDraw brick;
    std::unique_ptr<const PreparedBrick> prepared;
    DrawCounts counts;
    const BrickKey& key() const { return brick.brick.key; }
  };

  std::vector<BrickInView> bricksInView(const PixelRect& pixels) const {
    BrickWalkCounts ignored;
    return pass_.walk().inView(pixels, ignored);
  }

  void takeTurn(const BrickInView& brick) {
    context_.progress.throwIfCancelled("rendering");
    std::shared_ptr<const BrickBlock> block = blockOf(brick);
    const std::size_t passed = prefetcher_.turnOf(brick.key);
    prefetcher_.announce(context_.cache);
    if (block)
      due_.push_back({{{brick.key}, brick.rect, std::move(block)}, nullptr, {}});
    else
      prefetcher_.drew(brick.key, false);
    // All bricks before are drawn or hidden, but for the due bricks.
    part_.reached(passed - due_.size());
    if (due_.size() == drawn_together_) drawDue();
  }

  // Returns the brick from memory if it may be drawn with the due bricks. Otherwise draws the due bricks, and reads the
  // brick if still visible.
  std::shared_ptr<const BrickBlock> blockOf(const BrickInView& brick) {
    if (!due_.empty()) {
      std::shared_ptr<const BrickBlock> block = mayHide(brick) ? nullptr : context_.cache.find(brick.key);
      if (block) return block;
      // The prefetcher reads the brick while the due bricks, which may hide it, are drawn.
      drawDue();
      if (pass_.walk().hidden(brick, target_.visibility)) {
        ++context_.costs.walked.hidden;
        return nullptr;
      }
    }
    std::shared_ptr<const BrickBlock> block = context_.cache.get(brick.key);
    if (!block) context_.costs.statistics.damaged.insert({brick.key});
    return block;
  }

  // True if the due bricks keep the threads busy and would hide the brick if they were opaque.
  bool mayHide(const BrickInView& brick) const {
    if (due_.size() < kEnoughBricksTogether) return false;
    std::vector<PixelRect> covered;
    for (const DueBrick& due : due_) covered.push_back(due.brick.rect);
    return pass_.walk().hidden(brick, target_.visibility, covered);
  }

  // Draws the due bricks, tiles in parallel.
  void drawDue() {
    if (due_.empty()) return;
    ProfileScope span(Activity::kBrick);
    if (span.traced()) span.note("bricks", due_.size());
    parallelFor(due_.size(), [&](std::size_t i) {
      context_.progress.throwIfCancelled("rendering");
      due_[i].prepared = pass_.engine().prepare(due_[i].brick);
    });
    const std::vector<TileOfBricks> tiles = dueTiles();
    std::vector<std::vector<DrawCounts>> counts(tiles.size());
    std::uint64_t all = 0;
    for (const TileOfBricks& tile : tiles) all += tile.pixels;
    std::atomic<std::uint64_t> drawn = 0;
    parallelForInOrder(tiles.size(), [&](std::size_t i) {
      context_.progress.throwIfCancelled("rendering");
      drawTile(tiles[i], counts[i]);
      part_.within(due_.size(), drawn += tiles[i].pixels, all);
    });
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      for (std::size_t k = 0; k < counts[i].size(); ++k) {
        DueBrick& due = due_[tiles[i].bricks[k]];
        due.counts.add(counts[i][k]);
        if (counts[i][k].changed) shown_ = aroundBoth(shown_, intersection(tiles[i].rect, due.brick.rect));
      }
    }
    for (const DueBrick& due : due_) {
      pass_.addCosts(due.key(), due.counts, context_.costs);
      prefetcher_.drew(due.key(), due.counts.changed);
    }
    due_.clear();
  }

  void drawTile(const TileOfBricks& tile, std::vector<DrawCounts>& counts) {
    std::vector<const PreparedBrick*> bricks;
    bricks.reserve(tile.bricks.size());
    for (const std::size_t brick : tile.bricks) bricks.push_back(due_[brick].prepared.get());
    counts.resize(bricks.size());
    pass_.engine().draw(bricks, {target_.pixels.of(tile.rect), target_.visibility, target_.opacity_threshold, counts});
  }

  std::vector<TileOfBricks> dueTiles() const {
    std::vector<PixelRect> rects;
    rects.reserve(due_.size());
    for (const DueBrick& due : due_) rects.push_back(due.brick.rect);
    return tilesOfBricks(rects, target_.pixels.rect, pass_.request().tile_px,
                         partsOf(pass_.engine(), pass_.request().visibility.method));
  }

  const BrickPass& pass_;
  const PassTarget& target_;
  PassContext& context_;
  const std::size_t drawn_together_;
  std::vector<BrickInView> in_view_;  // until the prefetcher has them
  const std::size_t bricks_in_view_;
  PartProgress part_;
  Prefetcher prefetcher_;
  std::vector<DueBrick> due_;
  PixelRect shown_;
};

PixelRect BrickPass::draw(const PassTarget& target, PassContext& context) {
  return Drawing(*this, target, context).run();
}

}  // namespace kiln
