// The part of a frame's drawing that is its own where values are projected: bricks come in an order of values, and a
// pixel's value becomes a colour when all are there.
#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "frame/aov_planes.h"
#include "frame/frame_drawing.h"

namespace kiln {
namespace {

void putColors(const ProjectedValues& values, const TransferFunction& transfer_function, float* value_plane,
               Image& image) {
  const PixelRect& rect = values.rect();
  parallelFor(static_cast<std::size_t>(image.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < image.width; ++x) {
      const double value = values.value(rect.x0 + x, rect.y0 + y);
      if (std::isnan(value)) continue;
      const glm::dvec3 color = transfer_function.at(value).color;
      float* const pixel = image.pixel(x, y);
      for (int channel = 0; channel < 3; ++channel) pixel[channel] = static_cast<float>(color[channel]);
      pixel[3] = 1;
      if (value_plane != nullptr) value_plane[std::ptrdiff_t{y} * image.width + x] = static_cast<float>(value);
    }
  });
}

}  // namespace

void FrameDrawing::project(const PixelRect& pixels, Image& image) {
  const ValueProjection& projection = *plan_.projection;
  const ProfileScope span(Activity::kWalk);
  ProjectedValues values = projection.begin(pixels);
  const std::vector<BrickInView> bricks = projection.ordered(plan_.bricks->inView(pixels, walked_));
  std::vector<BrickInView> with_file;
  for (const BrickInView& brick : bricks) {
    if (!store_.index().at(brick.key).constant) with_file.push_back(brick);
  }
  // Nothing is opaque here: what lies behind something is no guess.
  lookahead_.emplace(std::move(with_file),
                     [&](const BrickInView& brick, auto /*covered*/) { return projection.hidden(brick, values); });
  announceNext();
  part_.emplace(progress_, "bricks", bricks.size());
  std::uint64_t passed = 0;
  for (const BrickInView& brick : bricks) {
    progress_.throwIfCancelled("rendering");
    part_->reached(passed++);
    const bool hidden = projection.hidden(brick, values);
    ++walked_.nodes_tested;
    walked_.nodes_hidden += hidden ? 1 : 0;
    walked_.hidden += hidden ? 1 : 0;
    if (hidden) continue;
    std::shared_ptr<const BrickBlock> block;
    if (!store_.index().at(brick.key).constant) {
      block = cache_.get(brick.key);
      lookahead_->turnOf(brick.key);
      announceNext();
      if (!block) {
        statistics_.damaged.insert({brick.key});
        continue;
      }
    }
    const ProfileScope drawing(Activity::kBrick);
    count(brick.key, projection.draw(brick, block.get(), tilesOf(pixels, brick.rect), values));
  }
  putColors(values, request_.transfer_function, valuePlane(request_.aovs, image), image);
}

}  // namespace kiln
