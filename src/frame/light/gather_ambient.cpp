#include "frame/light/gather_ambient.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "base/thread/parallel.h"

namespace kiln {
namespace {

// Calls work(i) for each i below `count` on all threads, until a stop is requested.
template <class Work>
void untilStopped(const Progress& progress, std::int64_t count, const Work& work) {
  parallelFor(static_cast<std::size_t>(count), [&](std::size_t i) {
    progress.throwIfCancelled("gathering ambient occlusion");
    work(i);
  });
}

// Cells of the lattice along an edge of the grid's cells.
constexpr int kCellsOfGrid = 2;
// Cones, evenly over the sphere. An estimate, not compared with other numbers.
constexpr int kCones = 32;
// Cells that see so little are inside matter, and their darkness is not seen.
constexpr float kDark = 0.02f;
constexpr std::uint8_t kInside = static_cast<std::uint8_t>(kDark * 255);
// Cells of the grid around visible matter whose occlusion samples may look up: the look-up reads a cell away from the
// surface, between eight cells.
constexpr int kNearMatter = 2;

// Transmittances of paths as long as a cell's edge, each level with cells twice as large.
struct Opacities {
  Extent3 dims;
  std::vector<std::uint8_t> open;  // unit: 1 / 255

  std::uint8_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    if (x < 0 || y < 0 || z < 0 || x >= dims.x || y >= dims.y || z >= dims.z) return 255;
    return open[static_cast<std::size_t>((z * dims.y + y) * dims.x + x)];
  }
  // Between eight cells. `p`: unit: cells, from the corner of the first.
  float between(const glm::vec3& p) const {
    const glm::vec3 q = p - 0.5f, low = glm::floor(q), f = q - low;
    const auto x = static_cast<std::int64_t>(low.x), y = static_cast<std::int64_t>(low.y),
               z = static_cast<std::int64_t>(low.z);
    const auto row = [&](std::int64_t j, std::int64_t k) {
      const float a = at(x, j, k);
      return a + f.x * (static_cast<float>(at(x + 1, j, k)) - a);
    };
    const auto plane = [&](std::int64_t k) {
      const float a = row(y, k);
      return a + f.y * (row(y + 1, k) - a);
    };
    const float a = plane(z);
    return (a + f.z * (plane(z + 1) - a)) * (1.0f / 255);
  }
};

Opacities firstLevel(const ExtinctionLattice& lattice, const Progress& progress) {
  const ImageSize& size = lattice.lattice().view.size;
  Opacities out{lattice.lattice().cells(), {}};
  out.open.resize(static_cast<std::size_t>(out.dims.count()));
  untilStopped(progress, out.dims.z, [&](std::size_t z) {
    std::uint8_t* to = &out.open[z * static_cast<std::size_t>(out.dims.x * out.dims.y)];
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x)
        *to++ = static_cast<std::uint8_t>(std::lround(255 * lattice.transmittance(x, y, static_cast<int>(z))));
    }
  });
  return out;
}

// A path through two cells along an axis; the mean over the four paths along each of the three axes.
Opacities coarser(const Opacities& fine, const Progress& progress) {
  const Extent3 n{(fine.dims.x + 1) / 2, (fine.dims.y + 1) / 2, (fine.dims.z + 1) / 2};
  Opacities out{n, {}};
  out.open.resize(static_cast<std::size_t>(n.count()));
  untilStopped(progress, n.z, [&](std::size_t slice) {
    const auto z = static_cast<std::int64_t>(slice);
    for (std::int64_t y = 0; y < n.y; ++y) {
      for (std::int64_t x = 0; x < n.x; ++x) {
        float t[8];
        for (int corner = 0; corner < 8; ++corner)
          t[corner] = fine.at(2 * x + (corner & 1), 2 * y + (corner >> 1 & 1), 2 * z + (corner >> 2));
        float sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
          for (const int beside : {1, 2, 4}) {
            if ((corner & beside) == 0) sum += t[corner] * t[corner | beside];
          }
        }
        out.open[static_cast<std::size_t>((z * n.y + y) * n.x + x)] =
            static_cast<std::uint8_t>(std::lround(sum / (12 * 255)));
      }
    }
  });
  return out;
}

// Evenly over the sphere: a spiral. Source: Swinbank and Purser 2006.
std::array<glm::vec3, kCones> coneDirections() {
  std::array<glm::vec3, kCones> out;
  for (int i = 0; i < kCones; ++i) {
    const double z = 1 - (2 * i + 1.0) / kCones, r = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    out[static_cast<std::size_t>(i)] = glm::vec3(glm::dvec3(r * std::cos(angle), r * std::sin(angle), z));
  }
  return out;
}

// A look-up of a cone: the middle of a step of `1 << level` cells.
struct ConeStep {
  float at;  // distance. unit: cells
  int level;
  float weight;  // of matter at the distance
};

// Steps grow with the distance, as wide as the cone: 32 cones have an opening of about half their length.
std::vector<ConeStep> stepsWithin(float radius) {
  std::vector<ConeStep> out;
  for (float from = 0.5f; from < radius;) {
    const int level = from < 3.5f ? 0 : std::min(static_cast<int>(std::log2(from / 1.75f)), 6);
    const float length = static_cast<float>(1 << level), at = from + 0.5f * length;
    const float part = at / radius;
    if (part < 1) out.push_back({at, level, 1 - part * part});
    from += length;
  }
  return out;
}

class Gathering {
 public:
  Gathering(const ExtinctionLattice& lattice, double radius, const Progress& progress)
      : progress_(progress),
        steps_(stepsWithin(static_cast<float>(radius / lattice.edge()))),
        directions_(coneDirections()) {
    levels_.push_back(firstLevel(lattice, progress));
    const int coarsest = steps_.empty() ? 0 : steps_.back().level;
    while (static_cast<int>(levels_.size()) <= coarsest) levels_.push_back(coarser(levels_.back(), progress));
    const Extent3& n = levels_.front().dims;
    dims_ = {n.x / kCellsOfGrid + 2, n.y / kCellsOfGrid + 2, n.z / kCellsOfGrid + 2};
  }

  const Extent3& dims() const { return dims_; }

  std::vector<AmbientCell> run() const {
    const std::vector<std::uint8_t> marked = marks();
    std::vector<AmbientCell> out(marked.size());
    untilStopped(progress_, dims_.z * dims_.y, [&](std::size_t line) {
      const auto z = static_cast<std::int64_t>(line) / dims_.y, y = static_cast<std::int64_t>(line) % dims_.y;
      for (std::int64_t x = 0; x < dims_.x; ++x) {
        const std::size_t place = placeOf(x, y, z);
        if (marked[place] == (kMatter | kClear)) out[place] = cellAt({x, y, z});
      }
    });
    return out;
  }

 private:
  static constexpr std::uint8_t kMatter = 1, kClear = 2;

  std::size_t placeOf(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>((z * dims_.y + y) * dims_.x + x);
  }

  // Marks cells of the grid whose surroundings hold matter, and cells whose surroundings hold more than matter.
  std::vector<std::uint8_t> marks() const {
    const Opacities& fine = levels_.front();
    std::vector<std::uint8_t> out(static_cast<std::size_t>(dims_.count()));
    untilStopped(progress_, dims_.z, [&](std::size_t slice) {
      const auto z = static_cast<std::int64_t>(slice);
      for (std::int64_t k = kCellsOfGrid * z; k < std::min(kCellsOfGrid * (z + 1), fine.dims.z); ++k) {
        for (std::int64_t j = 0; j < fine.dims.y; ++j) {
          const std::uint8_t* const row = &fine.open[static_cast<std::size_t>((k * fine.dims.y + j) * fine.dims.x)];
          std::uint8_t* const to = &out[placeOf(0, j / kCellsOfGrid, z)];
          for (std::int64_t i = 0; i < fine.dims.x; ++i)
            to[i / kCellsOfGrid] |=
                static_cast<std::uint8_t>((row[i] < 255 ? kMatter : 0) | (row[i] > kInside ? kClear : 0));
        }
      }
      // Beyond the lattice nothing is in the way.
      for (std::int64_t y = 0; y < dims_.y; ++y) {
        for (std::int64_t x = 0; x < dims_.x; ++x) {
          const bool outside =
              kCellsOfGrid * x >= fine.dims.x || kCellsOfGrid * y >= fine.dims.y || kCellsOfGrid * z >= fine.dims.z;
          if (outside) out[placeOf(x, y, z)] |= kClear;
        }
      }
    });
    for (int axis = 0; axis < 3; ++axis) out = spread(out, axis);
    return out;
  }

  // Cell x of the grid is a corner of cells x - 1 and x of the marks.
  std::vector<std::uint8_t> spread(const std::vector<std::uint8_t>& marks, int axis) const {
    std::vector<std::uint8_t> out(marks.size());
    const std::int64_t last = dims_[axis] - 1;
    const std::size_t step = axis == 0 ? 1 : axis == 1 ? placeOf(0, 1, 0) : placeOf(0, 0, 1);
    untilStopped(progress_, dims_.z, [&](std::size_t slice) {
      const auto z = static_cast<std::int64_t>(slice);
      for (std::int64_t y = 0; y < dims_.y; ++y) {
        for (std::int64_t x = 0; x < dims_.x; ++x) {
          const std::int64_t here = axis == 0 ? x : axis == 1 ? y : z;
          const std::uint8_t* const at = &marks[placeOf(x, y, z)];
          std::uint8_t mark = 0;
          for (std::int64_t beside = -kNearMatter; beside < kNearMatter; ++beside) {
            if (here + beside < 0 || here + beside > last)
              mark |= kClear;
            else
              mark |= at[beside * static_cast<std::ptrdiff_t>(step)];
          }
          out[placeOf(x, y, z)] = mark;
        }
      }
    });
    return out;
  }

  float visibilityAlong(const glm::vec3& from, const glm::vec3& direction) const {
    float open = 1, seen = 1;
    for (const ConeStep& step : steps_) {
      const float scale = 1.0f / static_cast<float>(1 << step.level);
      const Opacities& level = levels_[static_cast<std::size_t>(step.level)];
      const float through = level.between(scale * (from + step.at * direction));
      seen -= open * (1 - through) * step.weight;
      open *= through;
      if (open < kDark) break;
    }
    return seen;
  }

  AmbientCell cellAt(const VoxelCoord& cell) const {
    const glm::vec3 from(static_cast<float>(kCellsOfGrid) * glm::vec3(cell.x, cell.y, cell.z));
    float mean = 0;
    glm::vec3 along(0);
    for (const glm::vec3& direction : directions_) {
      const float seen = visibilityAlong(from, direction);
      mean += seen, along += seen * direction;
    }
    AmbientCell out;
    out.mean = static_cast<std::uint8_t>(std::lround(255 * mean / kCones));
    for (int axis = 0; axis < 3; ++axis)
      out.along[axis] = static_cast<std::int8_t>(std::lround(std::clamp(4 * along[axis] / kCones, -1.0f, 1.0f) * 127));
    return out;
  }

  const Progress& progress_;
  std::vector<ConeStep> steps_;
  std::array<glm::vec3, kCones> directions_;
  std::vector<Opacities> levels_;
  Extent3 dims_;
};

}  // namespace

AmbientGrid gatherAmbient(const ExtinctionLattice& lattice, double radius, const Progress& progress) {
  const Gathering gathering(lattice, radius, progress);
  const auto& [view, near, depth] = lattice.lattice();
  // Pixels and slabs of the lattice to cells of the grid.
  glm::dmat4 grid_from_view(1.0);
  for (int axis = 0; axis < 3; ++axis) grid_from_view[axis][axis] = view.focal_px / kCellsOfGrid;
  grid_from_view[3] = glm::dvec4(view.centre_px / double{kCellsOfGrid}, -near * view.focal_px / kCellsOfGrid, 1);
  return AmbientGrid(gathering.dims(), grid_from_view * view.view_from_world, gathering.run());
}

std::uint64_t ambientBytes(const Extent3& cells) {
  const auto fine = static_cast<std::uint64_t>(cells.count());
  const Extent3 grid{cells.x / kCellsOfGrid + 2, cells.y / kCellsOfGrid + 2, cells.z / kCellsOfGrid + 2};
  return fine * sizeof(std::uint16_t) + fine + fine / 4 +
         static_cast<std::uint64_t>(grid.count()) * sizeof(AmbientCell);
}

}  // namespace kiln
