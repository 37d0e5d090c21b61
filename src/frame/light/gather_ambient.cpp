#include "frame/light/gather_ambient.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/thread/parallel.h"
#include "frame/light/march_cones.h"
#include "grid/spirals.h"

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

// Edge of the grid's cells. unit: cells of the lattice. An even number: all points of the grid then lie alike among the
// cells, and smooth surfaces show no rings. Figures: frame/decisions/occlusion-points.md.
constexpr int kCellsOfGrid = 2;
// Cones, evenly over the sphere.
constexpr int kCones = 24;
// Ratio of a step's distance to its length, at least.
constexpr float kSlender = 2.5f;
constexpr int kCoarsest = 6;
// Cells with so little transmittance are inside matter, and their darkness is not seen.
constexpr std::uint8_t kInside = static_cast<std::uint8_t>(kDarkCone * 255);
// Cells of the grid around visible matter whose occlusion samples may look up: the look-up reads a cell away from the
// surface, between eight cells.
constexpr int kNearMatter = 2;

OpenLevel firstLevel(const ExtinctionLattice& lattice, const Progress& progress) {
  OpenLevel out(lattice.lattice().cells());
  const Extent3& n = out.cells();
  untilStopped(progress, n.z, [&](std::size_t slice) {
    const auto z = static_cast<std::int64_t>(slice);
    for (std::int64_t y = 0; y < n.y; ++y) {
      const auto from = lattice.transmittances().begin() + (z * n.y + y) * n.x;
      std::copy(from, from + n.x, out.row(y, z));
    }
  });
  return out;
}

// A path through two cells along an axis; the mean over the four paths along each of the three axes.
OpenLevel coarser(const OpenLevel& fine, const Progress& progress) {
  const Extent3& from = fine.cells();
  OpenLevel out({(from.x + 1) / 2, (from.y + 1) / 2, (from.z + 1) / 2});
  untilStopped(progress, out.cells().z, [&](std::size_t slice) {
    const auto z = static_cast<std::int64_t>(slice);
    for (std::int64_t y = 0; y < out.cells().y; ++y) {
      // Cells behind the last are clear.
      const std::uint8_t* const rows[4] = {fine.row(2 * y, 2 * z), fine.row(2 * y + 1, 2 * z),
                                           fine.row(2 * y, 2 * z + 1), fine.row(2 * y + 1, 2 * z + 1)};
      std::uint8_t* const to = out.row(y, z);
      for (std::int64_t x = 0; x < out.cells().x; ++x) {
        int t[8];
        for (int corner = 0; corner < 8; ++corner) t[corner] = rows[corner >> 1][2 * x + (corner & 1)];
        int sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
          for (const int beside : {1, 2, 4}) {
            if ((corner & beside) == 0) sum += t[corner] * t[corner | beside];
          }
        }
        to[x] = static_cast<std::uint8_t>((sum + 6 * 255) / (12 * 255));
      }
    }
  });
  return out;
}

std::array<glm::vec3, kCones> coneDirections() {
  std::array<glm::vec3, kCones> out;
  for (int i = 0; i < kCones; ++i) out[static_cast<std::size_t>(i)] = glm::vec3(pointOfSphere(i, kCones));
  return out;
}

// Steps grow with the distance. unit: radius: cells.
std::vector<ConeStep> stepsWithin(float radius) {
  std::vector<ConeStep> out;
  for (float from = 0; from < radius;) {
    const int level = from < 2 * kSlender ? 0 : std::min(static_cast<int>(std::log2(from / kSlender)), kCoarsest);
    const float length = static_cast<float>(1 << level), at = from + 0.5f * length;
    const float part = at / radius;
    if (part < 1) out.push_back({at, level, 1 - part * part});
    from += length;
  }
  return out;
}

Extent3 gridOf(const Extent3& lattice) {
  const auto along = [](std::int64_t cells) { return cells / kCellsOfGrid + 2; };
  return {along(lattice.x), along(lattice.y), along(lattice.z)};
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
    dims_ = gridOf(levels_.front().cells());
  }

  const Extent3& dims() const { return dims_; }

  AmbientGrid::Cells run() const {
    const std::vector<std::uint8_t> marked = marks();
    AmbientGrid::Cells out(marked.size(), AmbientCell());
    const Cones cones{directions_, steps_, levels_};
    // Rows of a plane fill vectors together.
    const std::int64_t blocks = (dims_.y + kRowsTogether - 1) / kRowsTogether;
    untilStopped(progress_, dims_.z * blocks, [&](std::size_t item) {
      const auto z = static_cast<std::int64_t>(item) / blocks,
                 y0 = static_cast<std::int64_t>(item) % blocks * kRowsTogether;
      ConePoints points;
      std::vector<std::size_t> places;
      for (std::int64_t y = y0; y < std::min(y0 + kRowsTogether, dims_.y); ++y) {
        for (std::int64_t x = 0; x < dims_.x; ++x) {
          if (marked[placeOf(x, y, z)] != (kMatter | kClear)) continue;
          points.add(glm::vec3(kCellsOfGrid * x, kCellsOfGrid * y, kCellsOfGrid * z));
          places.push_back(placeOf(x, y, z));
        }
      }
      if (places.empty()) return;
      std::vector<AmbientCell> cells;
      marchCones(cones, points, cells);
      for (std::size_t i = 0; i < places.size(); ++i) out[places[i]] = cells[i];
    });
    return out;
  }

 private:
  static constexpr std::uint8_t kMatter = 1, kClear = 2;
  static constexpr std::int64_t kRowsTogether = 8;

  std::size_t placeOf(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>((z * dims_.y + y) * dims_.x + x);
  }

  // Marks cells of the grid whose surroundings hold matter, and cells whose surroundings hold more than matter.
  std::vector<std::uint8_t> marks() const {
    const OpenLevel& fine = levels_.front();
    const Extent3& n = fine.cells();
    std::vector<std::uint8_t> out(static_cast<std::size_t>(dims_.count()));
    untilStopped(progress_, dims_.z, [&](std::size_t slice) {
      const auto z = static_cast<std::int64_t>(slice);
      for (std::int64_t k = kCellsOfGrid * z; k < std::min(kCellsOfGrid * (z + 1), n.z); ++k) {
        for (std::int64_t j = 0; j < n.y; ++j) {
          const std::uint8_t* const row = fine.row(j, k);
          std::uint8_t* const to = &out[placeOf(0, j / kCellsOfGrid, z)];
          for (std::int64_t i = 0; i < n.x; ++i)
            to[i / kCellsOfGrid] |=
                static_cast<std::uint8_t>((row[i] < 255 ? kMatter : 0) | (row[i] > kInside ? kClear : 0));
        }
      }
      // Beyond the lattice nothing is in the way.
      for (std::int64_t y = 0; y < dims_.y; ++y) {
        for (std::int64_t x = 0; x < dims_.x; ++x) {
          const bool outside = kCellsOfGrid * x >= n.x || kCellsOfGrid * y >= n.y || kCellsOfGrid * z >= n.z;
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

  const Progress& progress_;
  std::vector<ConeStep> steps_;
  std::array<glm::vec3, kCones> directions_;
  std::vector<OpenLevel> levels_;
  Extent3 dims_;
};

}  // namespace

AmbientGrid gatherAmbient(const ExtinctionLattice& lattice, double radius, const Progress& progress) {
  const Gathering gathering(lattice, radius, progress);
  const auto& [view, near, depth] = lattice.lattice();
  // Rays of the lattice's view to cells of the grid.
  constexpr double rays = kRaysOfCell * kCellsOfGrid;
  glm::dmat4 grid_from_view(1.0);
  for (int axis = 0; axis < 3; ++axis) grid_from_view[axis][axis] = view.focal_px / rays;
  grid_from_view[3] = glm::dvec4(view.centre_px / rays, -near * view.focal_px / rays, 1);
  return AmbientGrid(gathering.dims(), grid_from_view * view.view_from_world, gathering.run());
}

std::uint64_t ambientBytes(const LatticeView& lattice) {
  const auto fine = static_cast<std::uint64_t>(lattice.cells().count());
  const auto grid = static_cast<std::uint64_t>(gridOf(lattice.cells()).count());
  // The lattice, levels, marks and the grid.
  return ExtinctionLattice::bytesOf(lattice) + fine + fine / 4 + 2 * grid + grid * sizeof(AmbientCell);
}

}  // namespace kiln
