#include "engine/side_views.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kiln {
namespace {

// Share of all opacity that does not decide a picture. A head in 128³ voxels has about 3000 pixels: up to three stray
// voxels are left out.
constexpr double kNegligible = 0.001;

// A part of a view whose pixels touch.
struct Object {
  double opacity = 0;  // sum over its voxels
  int x0, y0, x1, y1;  // half-open
};

class Objects {
 public:
  Objects(std::vector<float> opacities, int width, int height)
      : open_(std::move(opacities)), opacities_(open_), width_(width), height_(height) {}

  /// Returns the objects, the faintest first.
  std::vector<Object> take() && {
    std::vector<Object> out;
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        if (open_[placeOf(x, y)] > 0) out.push_back(from(x, y));
      }
    }
    std::ranges::stable_sort(out, {}, &Object::opacity);
    return out;
  }

 private:
  std::size_t placeOf(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  // A voxel is in four cells, all of which show what the voxel shows: a speck of one voxel has four pixels. What is
  // only between voxels counts little.
  double ofVoxel(int x, int y) const {
    constexpr float kBetween = 1.0f / 16;
    const int left = std::max(x - 1, 0), above = std::max(y - 1, 0);
    const float here = opacities_[placeOf(x, y)];
    const float least =
        std::min({here, opacities_[placeOf(left, y)], opacities_[placeOf(x, above)], opacities_[placeOf(left, above)]});
    return static_cast<double>(std::max(least, kBetween * here));
  }

  // Takes the pixels that touch the pixel at (x, y).
  Object from(int x, int y) {
    Object out{0, x, y, x + 1, y + 1};
    std::vector<std::pair<int, int>> found;
    const auto visit = [&](int column, int row) {
      float& opacity = open_[placeOf(column, row)];
      if (!(opacity > 0)) return;
      out.opacity += ofVoxel(column, row);
      out.x0 = std::min(out.x0, column), out.x1 = std::max(out.x1, column + 1);
      out.y0 = std::min(out.y0, row), out.y1 = std::max(out.y1, row + 1);
      opacity = 0;
      found.emplace_back(column, row);
    };
    visit(x, y);
    while (!found.empty()) {
      const auto [column, row] = found.back();
      found.pop_back();
      for (int j = std::max(row - 1, 0); j <= std::min(row + 1, height_ - 1); ++j) {
        for (int i = std::max(column - 1, 0); i <= std::min(column + 1, width_ - 1); ++i) visit(i, j);
      }
    }
    return out;
  }

  std::vector<float> open_;  // 0: taken
  const std::vector<float> opacities_;
  int width_, height_;
};

}  // namespace

SideViews::SideViews(const Extent3& dims) : dims_(dims) {
  for (int axis = 0; axis < 3; ++axis) {
    View& view = views_[static_cast<std::size_t>(axis)];
    view.width = static_cast<int>(dims[(axis + 1) % 3]);
    view.height = static_cast<int>(dims[(axis + 2) % 3]);
    view.depths.assign(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height), 0);
    view.thin = view.depths;
  }
}

void SideViews::add(const VoxelCoord& cell, const std::array<double, 3>& depth) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    View& view = views_[axis];
    const std::int64_t x = cell[static_cast<int>(axis + 1) % 3], y = cell[static_cast<int>(axis + 2) % 3];
    view.depths[static_cast<std::size_t>(y * view.width + x)] += static_cast<float>(depth[axis]);
  }
}

void SideViews::addThin(const VoxelBox& box, double opacity) {
  const VoxelBox within = intersection(box, boxOf(dims_));
  for (std::size_t axis = 0; axis < 3 && !within.empty(); ++axis) {
    View& view = views_[axis];
    const int across = static_cast<int>(axis + 1) % 3, down = static_cast<int>(axis + 2) % 3;
    for (std::int64_t y = within.lo[down]; y < within.hi[down]; ++y) {
      for (std::int64_t x = within.lo[across]; x < within.hi[across]; ++x) {
        float& thin = view.thin[static_cast<std::size_t>(y * view.width + x)];
        thin = std::max(thin, static_cast<float>(opacity));
      }
    }
  }
}

std::vector<float> SideViews::View::opacities() const {
  std::vector<float> out(depths.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double depth = static_cast<double>(depths[i]);
    out[i] = depth >= kLeastColumn ? static_cast<float>(-std::expm1(-depth)) : thin[i];
  }
  return out;
}

VoxelBox SideViews::box() const {
  VoxelBox out = {{dims_.x, dims_.y, dims_.z}, {0, 0, 0}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const View& view = views_[axis];
    const int across = static_cast<int>(axis + 1) % 3, down = static_cast<int>(axis + 2) % 3;
    const std::vector<Object> objects = Objects(view.opacities(), view.width, view.height).take();
    double all = 0, left_out = 0;
    for (const Object& object : objects) all += object.opacity;
    for (const Object& object : objects) {
      left_out += object.opacity;
      if (left_out <= kNegligible * all) continue;
      out.lo[across] = std::min<std::int64_t>(out.lo[across], object.x0);
      out.hi[across] = std::max<std::int64_t>(out.hi[across], object.x1);
      out.lo[down] = std::min<std::int64_t>(out.lo[down], object.y0);
      out.hi[down] = std::max<std::int64_t>(out.hi[down], object.y1);
    }
  }
  // A cell reaches to its next neighbours.
  for (int axis = 0; axis < 3; ++axis) out.hi[axis] = std::min(out.hi[axis] + (out.hi[axis] > 0 ? 1 : 0), dims_[axis]);
  return out;
}

}  // namespace kiln
