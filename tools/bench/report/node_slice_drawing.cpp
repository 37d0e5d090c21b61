#include "bench/report/node_slice_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "job/job_names.h"

namespace kiln {
namespace {

constexpr double kLongSide_px = 340, kMargin_px = 2;
// Space above the volume for the arrow.
constexpr double kHead_px = 30;

// The volume's axes drawn to the right and up, and whether they are flipped.
struct Orientation {
  int right, up;
  bool flip_right, flip_up;
};

Orientation orientationOf(const NodeSlice& slice) {
  int a = (slice.log.axis + 1) % 3, b = (slice.log.axis + 2) % 3;
  if (std::abs(slice.forward[b]) > std::abs(slice.forward[a])) std::swap(a, b);
  return {a, b, slice.forward[a] < 0, false};
}

class Drawing {
 public:
  Drawing(const NodeSlice& slice, const VolumeSummary& volume) : at_(orientationOf(slice)), volume_(volume) {
    const double width = extent(at_.right), height = extent(at_.up);
    scale_ = kLongSide_px / std::max(width, height);
    width_px_ = width * scale_;
    height_px_ = height * scale_;
  }

  Svg draw(const NodeSlice& slice) const {
    Svg svg(width_px_ + 2 * kMargin_px, kHead_px + height_px_ + kMargin_px,
            fmt::format("The octree's nodes in a slice, {}, {}", nameIn(kVisibilityNames, slice.method),
                        nameIn(kProjectionNames, slice.projection)));
    std::string cells, nodes, hidden;
    int finest = 0;
    for (const LoggedNode& node : slice.log.nodes) finest = std::min(finest, node.level);
    for (const LoggedNode& node : slice.log.nodes) {
      std::string& path = node.hidden ? hidden : node.level == finest ? cells : nodes;
      path += boxPath(node.box);
    }
    svg.path(hidden, "hidden");
    svg.path(nodes, "node");
    svg.path(cells, "cell");
    svg.rect(kMargin_px, kHead_px, width_px_, height_px_, "volume");
    arrow(svg, slice);
    return svg;
  }

 private:
  double extent(int axis) const { return static_cast<double>(volume_.dims[axis]) * volume_.spacing[axis]; }

  double along(int axis, bool flip, std::int64_t voxel) const {
    const auto count = volume_.dims[axis];
    return static_cast<double>(flip ? count - voxel : voxel) * volume_.spacing[axis] * scale_;
  }

  std::string boxPath(const VoxelBox& box) const {
    double x0 = along(at_.right, at_.flip_right, box.lo[at_.right]);
    double x1 = along(at_.right, at_.flip_right, std::min(box.hi[at_.right], volume_.dims[at_.right]));
    // The drawing's up is opposite to SVG's y.
    double y0 = height_px_ - along(at_.up, at_.flip_up, box.lo[at_.up]);
    double y1 = height_px_ - along(at_.up, at_.flip_up, std::min(box.hi[at_.up], volume_.dims[at_.up]));
    if (x0 > x1) std::swap(x0, x1);
    if (y0 > y1) std::swap(y0, y1);
    return fmt::format("M{:.1f} {:.1f}h{:.1f}v{:.1f}h{:.1f}z", kMargin_px + x0, kHead_px + y0, x1 - x0, y1 - y0,
                       x0 - x1);
  }

  // Draws the view direction projected into the slice.
  void arrow(Svg& svg, const NodeSlice& slice) const {
    const double dx = std::abs(slice.forward[at_.right]), dy = -slice.forward[at_.up];
    const double length = std::hypot(dx, dy);
    if (length < 0.1) return;  // viewed across the slice
    const double ux = dx / length, uy = dy / length;
    constexpr double kHalf_px = 13;
    const SvgPoint middle{kMargin_px + kHalf_px + 2, kHead_px / 2};
    const SvgPoint tip{middle.x + kHalf_px * ux, middle.y + kHalf_px * uy};
    const SvgPoint tail{middle.x - kHalf_px * ux, middle.y - kHalf_px * uy};
    svg.path(fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}", tail.x, tail.y,
                         tip.x, tip.y, tip.x - 7 * ux + 4 * uy, tip.y - 7 * uy - 4 * ux, tip.x, tip.y,
                         tip.x - 7 * ux - 4 * uy, tip.y - 7 * uy + 4 * ux),
             "arrow");
    svg.text({middle.x + kHalf_px + 10, middle.y + 4}, "start", "view", "small faint");
  }

  Orientation at_;
  const VolumeSummary& volume_;
  double scale_ = 1, width_px_ = 0, height_px_ = 0;
};

}  // namespace

Svg drawNodeSlice(const NodeSlice& slice, const VolumeSummary& volume) { return Drawing(slice, volume).draw(slice); }

}  // namespace kiln
