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
  std::int32_t number;
};

class Objects {
 public:
  Objects(std::vector<float> opacities, int width, int height)
      : open_(std::move(opacities)), opacities_(open_), numbers_(open_.size()), width_(width), height_(height) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        if (open_[placeOf(x, y)] > 0) found_.push_back(from(x, y));
      }
    }
    std::ranges::stable_sort(found_, {}, &Object::opacity);
  }

  /// The faintest first.
  const std::vector<Object>& found() const { return found_; }
  /// The number of the object of each pixel; 0: none.
  const std::vector<std::int32_t>& numbers() const { return numbers_; }

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
    Object out{0, x, y, x + 1, y + 1, static_cast<std::int32_t>(found_.size() + 1)};
    std::vector<std::pair<int, int>> found;
    const auto visit = [&](int column, int row) {
      float& opacity = open_[placeOf(column, row)];
      if (!(opacity > 0)) return;
      out.opacity += ofVoxel(column, row);
      out.x0 = std::min(out.x0, column), out.x1 = std::max(out.x1, column + 1);
      out.y0 = std::min(out.y0, row), out.y1 = std::max(out.y1, row + 1);
      opacity = 0;
      numbers_[placeOf(column, row)] = out.number;
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
  std::vector<std::int32_t> numbers_;
  std::vector<Object> found_;
  int width_, height_;
};

}  // namespace

SideViews::SideViews(const Extent3& dims)
    : dims_(dims), words_((dims.x + 63) / 64), shown_(static_cast<std::size_t>(words_ * dims.y * dims.z)) {
  for (int axis = 0; axis < 3; ++axis) {
    View& view = views_[static_cast<std::size_t>(axis)];
    view.width = static_cast<int>(dims[(axis + 1) % 3]);
    view.height = static_cast<int>(dims[(axis + 2) % 3]);
    view.depths.assign(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height), 0);
    view.thin = view.depths;
  }
}

void SideViews::add(const VoxelCoord& cell, const std::array<double, 3>& depth) {
  wordOf(cell) |= std::uint64_t{1} << (cell.x % 64);
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
  for (std::int64_t z = within.lo.z; z < within.hi.z; ++z) {
    for (std::int64_t y = within.lo.y; y < within.hi.y; ++y) {
      for (std::int64_t x = within.lo.x; x < within.hi.x; ++x) wordOf({x, y, z}) |= std::uint64_t{1} << (x % 64);
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

SideViews::Counted SideViews::View::counted() const {
  const Objects objects(opacities(), width, height);
  double all = 0, left_out = 0;
  for (const Object& object : objects.found()) all += object.opacity;
  Counted out{std::vector<bool>(depths.size()), {width, height}, {0, 0}};
  std::vector<bool> counts(objects.found().size() + 1);
  for (const Object& object : objects.found()) {
    left_out += object.opacity;
    if (left_out <= kNegligible * all) continue;
    counts[static_cast<std::size_t>(object.number)] = true;
    out.lo = {std::min<std::int64_t>(out.lo[0], object.x0), std::min<std::int64_t>(out.lo[1], object.y0)};
    out.hi = {std::max<std::int64_t>(out.hi[0], object.x1), std::max<std::int64_t>(out.hi[1], object.y1)};
  }
  for (std::size_t i = 0; i < depths.size(); ++i)
    out.pixels[i] = counts[static_cast<std::size_t>(objects.numbers()[i])];
  return out;
}

VoxelBox SideViews::box() const {
  VoxelBox out = {{dims_.x, dims_.y, dims_.z}, {0, 0, 0}};
  for (int axis = 0; axis < 3; ++axis) {
    const Counted counted = views_[static_cast<std::size_t>(axis)].counted();
    const std::array<int, 2> across = {(axis + 1) % 3, (axis + 2) % 3};
    for (std::size_t i = 0; i < 2; ++i) {
      out.lo[across[i]] = std::min(out.lo[across[i]], counted.lo[i]);
      out.hi[across[i]] = std::max(out.hi[across[i]], counted.hi[i]);
    }
  }
  // A cell reaches to its next neighbours.
  for (int axis = 0; axis < 3; ++axis) out.hi[axis] = std::min(out.hi[axis] + (out.hi[axis] > 0 ? 1 : 0), dims_[axis]);
  return out;
}

bool SideViews::showsIn(const VoxelBox& box) const {
  const VoxelBox within = intersection(box, boxOf(dims_));
  for (std::int64_t z = within.lo.z; z < within.hi.z; ++z) {
    for (std::int64_t y = within.lo.y; y < within.hi.y; ++y) {
      for (std::int64_t x = within.lo.x; x < within.hi.x; ++x) {
        if (shows({x, y, z})) return true;
      }
    }
  }
  return false;
}

std::vector<VoxelBox> SideViews::rows() const {
  std::array<Counted, 3> counted = {views_[0].counted(), views_[1].counted(), views_[2].counted()};
  // The cell's pixels in the three views.
  const auto pixelsOf = [&](const VoxelCoord& cell) {
    const auto placeOf = [](const View& view, std::int64_t across, std::int64_t down) {
      return static_cast<std::size_t>(down * view.width + across);
    };
    return std::array<std::size_t, 3>{placeOf(views_[0], cell.y, cell.z), placeOf(views_[1], cell.z, cell.x),
                                      placeOf(views_[2], cell.x, cell.y)};
  };
  const auto viewsOf = [&](const std::array<std::size_t, 3>& pixels) {
    return counted[0].pixels[pixels[0]] + counted[1].pixels[pixels[1]] + counted[2].pixels[pixels[2]];
  };
  std::array<std::vector<bool>, 3> bare = {counted[0].pixels, counted[1].pixels, counted[2].pixels};
  forEachCoord(boxOf(dims_), [&](const VoxelCoord& cell) {
    if (!shows(cell)) return;
    const std::array<std::size_t, 3> pixels = pixelsOf(cell);
    if (viewsOf(pixels) < 2) return;
    for (std::size_t axis = 0; axis < 3; ++axis) bare[axis][pixels[axis]] = false;
  });
  const auto counts = [&](const VoxelCoord& cell) {
    if (!shows(cell)) return false;
    const std::array<std::size_t, 3> pixels = pixelsOf(cell);
    return viewsOf(pixels) >= 2 || bare[0][pixels[0]] || bare[1][pixels[1]] || bare[2][pixels[2]];
  };
  std::vector<VoxelBox> out;
  for (std::int64_t z = 0; z < dims_.z; ++z) {
    for (std::int64_t y = 0; y < dims_.y; ++y) {
      std::int64_t first = 0, last = dims_.x - 1;
      while (first <= last && !counts({first, y, z})) ++first;
      if (first > last) continue;
      while (!counts({last, y, z})) --last;
      out.push_back(intersection({{first, y, z}, {last + 2, y + 2, z + 2}}, boxOf(dims_)));
    }
  }
  return out;
}

}  // namespace kiln
