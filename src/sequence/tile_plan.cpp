#include "sequence/tile_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/thread/parallel.h"
#include "job/job_facts.h"
#include "occlusion/visibility.h"

namespace kiln {
namespace {

// Number of frames that the plan samples, evenly over the job.
constexpr std::size_t kSampled = 8;
// Tiles per rank: enough for other ranks to take over an uneven share.
constexpr int kTilesOfRank = 16, kFewestTilesOfRank = 4;
// Work of an empty pixel relative to a pixel of one brick; and the excess over an even share that a plan may give to a
// rank, since other ranks take over tiles.
constexpr double kEmptyWork = 0.02, kUneven = 0.15;
// Factor by which tiles must reduce the bytes read, to pay for bricks on their seams.
constexpr double kWorthTiles = 1.1;

struct SampledBrick {
  std::size_t place;  // number of the brick, equal in all frames
  PixelRect rect;
  std::uint64_t bytes;
};
using SampledFrames = std::vector<std::vector<SampledBrick>>;
using BrickPlaces = std::map<BrickKey, std::size_t>;

SampledFrames sample(const OpenedJob& opened, const std::vector<int>& frames, BrickPlaces& places) {
  SampledFrames out;
  // With several volumes one index predicts little: tiles are weighed by area.
  const std::size_t count = opened.job().volumes.empty() ? std::min(kSampled, frames.size()) : 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<SampledBrick> bricks;
    const FrameRequest request = opened.requestFor(opened.sceneAt(frames[i * frames.size() / count]));
    const int edge = subPixelsAlongEdge(request.samples);
    for (const BrickOfFrame& brick : bricksOnImage(opened.firstVolume(), request)) {
      const PixelRect& r = brick.rect;
      const BrickKey& key = brick.brick.key;
      bricks.push_back({places.emplace(key, places.size()).first->second,
                        {r.x0 / edge, r.y0 / edge, (r.x1 + edge - 1) / edge, (r.y1 + edge - 1) / edge},
                        opened.firstVolume().index().at(key).file_bytes});
    }
    out.push_back(std::move(bricks));
  }
  return out;
}

double areaOf(const PixelRect& r) { return static_cast<double>(r.count()); }

// The picture in squares of kVisibilityTile pixels ("steps"), with the estimated work of each. Cuts run between steps,
// so that no cut divides a thread's tile.
struct Grid {
  PixelRect crop;
  int columns, rows;
  std::vector<double> sums;  // work of all steps before a column and a row

  Grid(const PixelRect& pixels, const SampledFrames& frames)
      : crop(pixels),
        columns((crop.x1 - 1) / kVisibilityTile - crop.x0 / kVisibilityTile + 1),
        rows((crop.y1 - 1) / kVisibilityTile - crop.y0 / kVisibilityTile + 1),
        sums(static_cast<std::size_t>(columns + 1) * static_cast<std::size_t>(rows + 1)) {
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) at(x + 1, y + 1) = kEmptyWork * areaOf(rect({x, y, x + 1, y + 1}));
    }
    for (const auto& bricks : frames) {
      for (const SampledBrick& brick : bricks) addWork(brick.rect);
    }
    for (int y = 1; y <= rows; ++y) {
      for (int x = 1; x <= columns; ++x) at(x, y) += at(x - 1, y) + at(x, y - 1) - at(x - 1, y - 1);
    }
  }
  // Converts a rectangle of steps to pixels.
  PixelRect rect(const PixelRect& t) const {
    const int x = crop.x0 / kVisibilityTile, y = crop.y0 / kVisibilityTile;
    return intersection({(x + t.x0) * kVisibilityTile, (y + t.y0) * kVisibilityTile, (x + t.x1) * kVisibilityTile,
                         (y + t.y1) * kVisibilityTile},
                        crop);
  }
  double work(const PixelRect& t) const { return at(t.x1, t.y1) - at(t.x0, t.y1) - at(t.x1, t.y0) + at(t.x0, t.y0); }

 private:
  double& at(int x, int y) { return sums[static_cast<std::size_t>(y * (columns + 1) + x)]; }
  double at(int x, int y) const { return sums[static_cast<std::size_t>(y * (columns + 1) + x)]; }
  void addWork(const PixelRect& brick) {
    const PixelRect seen = intersection(brick, crop);
    if (seen.empty()) return;
    const int x0 = crop.x0 / kVisibilityTile, y0 = crop.y0 / kVisibilityTile;
    for (int y = seen.y0 / kVisibilityTile - y0; y <= (seen.y1 - 1) / kVisibilityTile - y0; ++y) {
      for (int x = seen.x0 / kVisibilityTile - x0; x <= (seen.x1 - 1) / kVisibilityTile - x0; ++x)
        at(x + 1, y + 1) += areaOf(intersection(seen, rect({x, y, x + 1, y + 1})));
    }
  }
};

// Counts the bytes that a rank reads to draw a rectangle of all frames.
class Reading {
 public:
  explicit Reading(const SampledFrames& frames) : frames_(frames) {
    std::size_t bricks = 0;
    for (const auto& frame : frames) {
      for (const SampledBrick& brick : frame) bricks = std::max(bricks, brick.place + 1);
    }
    asked_.resize(bricks);
  }
  std::uint64_t bytesOf(const PixelRect& pixels) {
    ++question_;
    std::uint64_t out = 0;
    for (const auto& frame : frames_) {
      for (const SampledBrick& brick : frame) {
        if (asked_[brick.place] == question_ || intersection(brick.rect, pixels).empty()) continue;
        asked_[brick.place] = question_;
        out += brick.bytes;
      }
    }
    return out;
  }

 private:
  const SampledFrames& frames_;
  std::vector<std::uint64_t> asked_;  // last query in which a brick was counted
  std::uint64_t question_ = 0;
};

enum class Cuts { kRows, kColumns, kBoth };

// Bisects the picture. Candidates are cuts with about the ranks' share of work on either side. Takes the candidate with
// the fewest bytes to read, which runs between bricks if possible.
class Cutter {
 public:
  Cutter(const Grid& grid, Reading& reading, Cuts cuts) : grid_(grid), reading_(reading), cuts_(cuts) {}

  void cut(const PixelRect& t, int ranks, std::vector<PixelRect>& out) {
    if (ranks == 1 || t.empty() || t.width() * t.height() == 1) {
      out.push_back(t);
      for (int i = 1; i < ranks; ++i) out.push_back({t.x1, t.y1, t.x1, t.y1});
      return;
    }
    Choice best;
    if (cuts_ != Cuts::kColumns || t.width() == 1) tryRows(t, ranks, best);
    if (cuts_ != Cuts::kRows || t.height() == 1) tryColumns(t, ranks, best);
    if (best.first.empty()) cuts_ == Cuts::kColumns ? tryRows(t, ranks, best) : tryColumns(t, ranks, best);
    cut(best.first, ranks / 2, out);
    cut(best.second, ranks - ranks / 2, out);
  }

 private:
  struct Choice {
    PixelRect first, second;
    bool even = false;
    double cost = std::numeric_limits<double>::infinity();  // bytes of an even cut, else the unevenness
  };

  void tryRows(const PixelRect& t, int ranks, Choice& best) {
    for (int y = t.y0 + 1; y < t.y1; ++y) consider({t.x0, t.y0, t.x1, y}, {t.x0, y, t.x1, t.y1}, ranks, best);
  }
  void tryColumns(const PixelRect& t, int ranks, Choice& best) {
    for (int x = t.x0 + 1; x < t.x1; ++x) consider({t.x0, t.y0, x, t.y1}, {x, t.y0, t.x1, t.y1}, ranks, best);
  }
  void consider(const PixelRect& first, const PixelRect& second, int ranks, Choice& best) {
    const int before = ranks / 2;
    const double a = grid_.work(first), b = grid_.work(second), each = (a + b) / ranks;
    const double off = std::max(a / before, b / (ranks - before)) / each - 1;
    const bool even = off <= kUneven;
    if (best.even && !even) return;
    const double cost =
        even ? static_cast<double>(reading_.bytesOf(grid_.rect(first)) + reading_.bytesOf(grid_.rect(second))) : off;
    if (even == best.even && cost >= best.cost) return;
    best = {first, second, even, cost};
  }

  const Grid& grid_;
  Reading& reading_;
  const Cuts cuts_;
};

std::uint64_t bytesOfFrames(const SampledFrames& frames, int ranks) {
  std::uint64_t out = 0;
  std::vector<std::set<std::size_t>> bricks(static_cast<std::size_t>(ranks));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    // With more ranks than sampled frames, ranks between two samples draw nearly the same bricks.
    const std::size_t copies = std::max<std::size_t>(bricks.size() / frames.size(), 1);
    for (const SampledBrick& brick : frames[i]) {
      if (bricks[i * bricks.size() / frames.size()].insert(brick.place).second) out += copies * brick.bytes;
    }
  }
  return out;
}

// Returns the edge of tiles in a part, large enough to occupy all threads of a rank. unit: steps.
int tileEdge(const PixelRect& part) {
  const int least = static_cast<int>(std::ceil(std::sqrt(4.0 * std::min(ThreadLimit::active(), 64u))));
  return std::max(least, static_cast<int>(std::sqrt(areaOf(part) / kTilesOfRank)));
}

// Adds tiles row by row in alternating direction, starting far from the picture's middle. Another rank takes tiles from
// the end, beside its own tiles, and shares bricks with them.
void addTiles(const Grid& grid, const PixelRect& part, std::vector<PixelRect>& out) {
  if (part.empty()) return;
  const bool upwards = part.y0 + part.y1 > grid.rows, leftwards = part.x0 + part.x1 > grid.columns;
  const int edge = tileEdge(part), rows = (part.height() + edge - 1) / edge, columns = (part.width() + edge - 1) / edge;
  for (int row = 0; row < rows; ++row) {
    const int y = part.y0 + edge * (upwards ? rows - 1 - row : row);
    // The last row ends in the middle.
    const bool back = leftwards == ((rows - 1 - row) % 2 == 0);
    for (int i = 0; i < columns; ++i) {
      const int x = part.x0 + edge * (back ? columns - 1 - i : i);
      out.push_back(grid.rect(intersection({x, y, x + edge, y + edge}, part)));
    }
  }
}

std::vector<BrickHome> homesOf(const SampledFrames& frames, const BrickPlaces& places,
                               const std::vector<PixelRect>& parts) {
  std::vector<std::map<std::size_t, double>> seen(places.size());  // pixels per rank
  for (const auto& bricks : frames) {
    for (const SampledBrick& brick : bricks) {
      for (std::size_t rank = 0; rank < parts.size(); ++rank) {
        const PixelRect there = intersection(brick.rect, parts[rank]);
        if (!there.empty()) seen[brick.place][rank] += areaOf(there);
      }
    }
  }
  std::vector<BrickHome> out;
  for (const auto& [key, place] : places) {
    const auto most = std::max_element(seen[place].begin(), seen[place].end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most == seen[place].end()) continue;
    out.push_back({key, static_cast<std::int32_t>(most->first), static_cast<std::int32_t>(seen[place].size() - 1)});
  }
  return out;
}

}  // namespace

TilePlan planTiles(OpenedJob& opened, const std::vector<int>& frames, int ranks, Distribution distribution) {
  const PictureOptions& picture = opened.job().picture;
  TilePlan out;
  BrickPlaces places;
  const SampledFrames sampled = sample(opened, frames, places);
  const Grid grid(drawnPixels(picture.size, picture.crop), sampled);
  Reading reading(sampled);
  std::vector<PixelRect> parts;
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  for (const Cuts cuts : {Cuts::kBoth, Cuts::kRows, Cuts::kColumns}) {
    std::vector<PixelRect> some;
    Cutter(grid, reading, cuts).cut({0, 0, grid.columns, grid.rows}, ranks, some);
    std::uint64_t bytes = 0;
    for (const PixelRect& part : some) bytes += part.empty() ? 0 : reading.bytesOf(grid.rect(part));
    if (bytes >= least) continue;
    least = bytes;
    parts = std::move(some);
  }
  out.bounds.push_back(0);
  for (PixelRect& part : parts) {
    addTiles(grid, part, out.tiles);
    part = part.empty() ? PixelRect{} : grid.rect(part);
    out.bounds.push_back(static_cast<std::uint32_t>(out.tiles.size()));
  }
  if (distribution == Distribution::kAuto && frames.size() >= static_cast<std::size_t>(2 * ranks)) {
    const bool few = sampled.empty() || out.tiles.size() < static_cast<std::size_t>(kFewestTilesOfRank * ranks);
    if (few || static_cast<double>(bytesOfFrames(sampled, ranks)) <= kWorthTiles * static_cast<double>(least))
      return {};
  }
  out.homes = homesOf(sampled, places, parts);
  return out;
}

}  // namespace kiln
