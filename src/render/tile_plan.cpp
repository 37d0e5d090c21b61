#include "render/tile_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <set>

#include "base/parallel.h"
#include "occlusion/visibility.h"

namespace kiln {
namespace {

// Frames that are looked at; a job's others lie between them.
constexpr std::size_t kSampled = 8;
// Of each rank, so that what one has too much, others take.
constexpr int kTilesOfRank = 16, kFewestTilesOfRank = 4;
// Bytes that tiles must save to be worth their seams.
constexpr double kWorthTiles = 1.1;

struct SampledBrick {
  BrickKey key;
  PixelRect rect;
  std::uint64_t bytes;
};
using SampledFrames = std::vector<std::vector<SampledBrick>>;

SampledFrames sample(const OpenedJob& opened, const std::vector<int>& frames) {
  SampledFrames out;
  // Of several volumes the index of one says little: tiles count by their areas.
  const std::size_t count = opened.job().volumes.empty() ? std::min(kSampled, frames.size()) : 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<SampledBrick> bricks;
    const FrameRequest request = opened.requestFor(opened.sceneAt(frames[i * frames.size() / count]));
    const int edge = subPixelsAlongEdge(request.samples);
    for (const BrickInView& brick : bricksOnImage(opened.store(), request)) {
      const PixelRect& r = brick.rect;
      bricks.push_back({brick.key,
                        {r.x0 / edge, r.y0 / edge, (r.x1 + edge - 1) / edge, (r.y1 + edge - 1) / edge},
                        opened.store().index().at(brick.key).file_bytes});
    }
    out.push_back(std::move(bricks));
  }
  return out;
}

// Squares of a multiple of kVisibilityTile, so that a thread's tiles are not cut: of each rank enough to share, and in
// each enough for its threads.
int tileEdge(const PixelRect& crop, int ranks) {
  const double pixels = static_cast<double>(crop.width()) * crop.height();
  const auto steps = [](double edge) { return static_cast<int>(edge / kVisibilityTile); };
  const int least = static_cast<int>(std::ceil(std::sqrt(4.0 * std::min(ThreadLimit::active(), 64u))));
  return kVisibilityTile * std::max(least, steps(std::sqrt(pixels / (kTilesOfRank * ranks))));
}

// Tiles by column and row, with what drawing each may take.
struct Grid {
  PixelRect crop;
  int edge, columns, rows;
  std::vector<double> weights;

  Grid(const PixelRect& pixels, int tile_edge, const SampledFrames& frames) : crop(pixels), edge(tile_edge) {
    columns = (crop.x1 - 1) / edge - crop.x0 / edge + 1;
    rows = (crop.y1 - 1) / edge - crop.y0 / edge + 1;
    for (int i = 0; i < columns * rows; ++i) {
      const PixelRect tile = rect({i % columns, i / columns, i % columns + 1, i / columns + 1});
      double weight = 0.02 * tile.width() * tile.height();
      for (const auto& bricks : frames) {
        for (const SampledBrick& brick : bricks) {
          const PixelRect both = intersection(brick.rect, tile);
          if (!both.empty()) weight += static_cast<double>(both.width()) * both.height();
        }
      }
      weights.push_back(weight);
    }
  }
  // Of a rectangle of tiles, in the picture.
  PixelRect rect(const PixelRect& t) const {
    const int x = crop.x0 / edge * edge, y = crop.y0 / edge * edge;
    return intersection({x + t.x0 * edge, y + t.y0 * edge, x + t.x1 * edge, y + t.y1 * edge}, crop);
  }
  double weight(const PixelRect& t) const {
    double out = 0;
    for (int y = t.y0; y < t.y1; ++y) {
      for (int x = t.x0; x < t.x1; ++x) out += weights[static_cast<std::size_t>(y * columns + x)];
    }
    return out;
  }
};

enum class Cut { kRows, kColumns, kBlocks };

// Cuts `t` among `ranks`, as evenly as whole rows or columns of tiles can be.
void cutTiles(const Grid& grid, const PixelRect& t, int ranks, Cut cut, std::vector<PixelRect>& out) {
  const bool empty = t.x0 >= t.x1 || t.y0 >= t.y1;
  if (ranks == 1 || empty || t.width() * t.height() == 1) {
    out.push_back(t);
    for (int i = 1; i < ranks; ++i) out.push_back({t.x1, t.y1, t.x1, t.y1});
    return;
  }
  bool rows = cut == Cut::kRows || (cut == Cut::kBlocks && t.height() >= t.width());
  if (rows ? t.height() == 1 : t.width() == 1) rows = !rows;
  const int before = ranks / 2;
  const double wanted = grid.weight(t) * before / ranks;
  PixelRect first = t, best = t;
  double nearest = std::numeric_limits<double>::infinity();
  int& end = rows ? first.y1 : first.x1;
  const int begin = rows ? t.y0 : t.x0, last = rows ? t.y1 : t.x1;
  for (end = begin + 1; end < last; ++end) {
    const double off = std::abs(grid.weight(first) - wanted);
    if (off >= nearest) continue;
    nearest = off;
    best = first;
  }
  PixelRect second = t;
  (rows ? second.y0 : second.x0) = rows ? best.y1 : best.x1;
  cutTiles(grid, best, before, cut, out);
  cutTiles(grid, second, ranks - before, cut, out);
}

using BricksOfRank = std::set<BrickKey>;

std::uint64_t bytesOfTiles(const Grid& grid, const std::vector<PixelRect>& parts, const SampledFrames& frames) {
  std::uint64_t out = 0;
  for (const PixelRect& part : parts) {
    const PixelRect rect = grid.rect(part);
    BricksOfRank bricks;
    for (const auto& frame : frames) {
      for (const SampledBrick& brick : frame) {
        if (!intersection(brick.rect, rect).empty() && bricks.insert(brick.key).second) out += brick.bytes;
      }
    }
  }
  return out;
}

std::uint64_t bytesOfFrames(const SampledFrames& frames, int ranks) {
  std::uint64_t out = 0;
  std::vector<BricksOfRank> bricks(static_cast<std::size_t>(ranks));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    // Where there are more ranks than samples, those between draw much the same.
    const std::size_t copies = std::max<std::size_t>(bricks.size() / frames.size(), 1);
    for (const SampledBrick& brick : frames[i]) {
      if (bricks[i * bricks.size() / frames.size()].insert(brick.key).second) out += copies * brick.bytes;
    }
  }
  return out;
}

// Each beside the next, row by row to and fro, from what is far from the picture's middle on: what another rank takes
// over, from the end, is then beside its own tiles, and shares bricks with them.
void addTiles(const Grid& grid, const PixelRect& part, std::vector<PixelRect>& out) {
  const bool upwards = part.y0 + part.y1 > grid.rows, leftwards = part.x0 + part.x1 > grid.columns;
  const int rows = part.y1 - part.y0, columns = part.x1 - part.x0;
  for (int row = 0; row < rows; ++row) {
    const int y = upwards ? part.y1 - 1 - row : part.y0 + row;
    // The last row ends in the middle.
    const bool back = leftwards == ((rows - 1 - row) % 2 == 0);
    for (int i = 0; i < columns; ++i) {
      const int x = back ? part.x1 - 1 - i : part.x0 + i;
      out.push_back(grid.rect({x, y, x + 1, y + 1}));
    }
  }
}

}  // namespace

TilePlan planTiles(OpenedJob& opened, const std::vector<int>& frames, int ranks, Distribution distribution) {
  const PictureOptions& picture = opened.job().picture;
  TilePlan out;
  if (distribution == Distribution::kFrames) return out;
  const PixelRect crop = drawnPixels(picture.size, picture.crop);
  const SampledFrames sampled = sample(opened, frames);
  const Grid grid(crop, tileEdge(crop, ranks), sampled);
  std::vector<PixelRect> parts;
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  for (const Cut cut : {Cut::kBlocks, Cut::kRows, Cut::kColumns}) {
    std::vector<PixelRect> some;
    cutTiles(grid, {0, 0, grid.columns, grid.rows}, ranks, cut, some);
    const std::uint64_t bytes = bytesOfTiles(grid, some, sampled);
    if (bytes >= least) continue;
    least = bytes;
    parts = std::move(some);
  }
  if (distribution == Distribution::kAuto && frames.size() >= static_cast<std::size_t>(2 * ranks)) {
    const bool few = sampled.empty() || grid.columns * grid.rows < kFewestTilesOfRank * ranks;
    if (few || static_cast<double>(bytesOfFrames(sampled, ranks)) <= kWorthTiles * static_cast<double>(least))
      return out;
  }
  out.bounds.push_back(0);
  for (const PixelRect& part : parts) {
    addTiles(grid, part, out.tiles);
    out.bounds.push_back(static_cast<std::uint32_t>(out.tiles.size()));
  }
  return out;
}

}  // namespace kiln
