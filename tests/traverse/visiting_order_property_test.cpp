// Visiting order is front to back: voxels along any ray from the eye (or any parallel ray) are visited in the order of
// their depth. The test walks a ray in small steps; the visiting positions of the voxels must rise.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <map>
#include <tuple>
#include <vector>

#include "grid/visiting_order.h"
#include "support/volumes/random_scene.h"

namespace kiln::test {
namespace {

constexpr int kEdge = 32;
using Position = std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, int>;

// Numbers the voxels in the order of the octree recursion and the loops within a cell, as the renderer visits them.
void visit(const VisitingOrder& order, const VoxelCoord& lo, int edge, Position& positions) {
  if (edge == 8) {
    std::uint8_t offsets[3][8];
    for (int axis = 0; axis < 3; ++axis) order.axisOrder(axis, lo[axis], 8, offsets[axis]);
    for (int k = 0; k < 8; ++k) {
      for (int j = 0; j < 8; ++j) {
        for (int i = 0; i < 8; ++i) {
          positions.emplace(std::tuple(lo.x + offsets[0][i], lo.y + offsets[1][j], lo.z + offsets[2][k]),
                            static_cast<int>(positions.size()));
        }
      }
    }
    return;
  }
  const int half = edge / 2;
  for (const unsigned child : order.children({lo.x + half, lo.y + half, lo.z + half})) {
    visit(order, {lo.x + half * (child & 1), lo.y + half * (child >> 1 & 1), lo.z + half * (child >> 2)}, half,
          positions);
  }
}

void expectFrontToBack(const Position& positions, const glm::dvec3& origin, const glm::dvec3& direction,
                       std::uint64_t seed) {
  int last = -1;
  for (double t = 0; t < 4 * kEdge; t += 0.01) {
    const glm::dvec3 p = origin + t * direction + 0.5;
    const auto it =
        positions.find({static_cast<std::int64_t>(std::floor(p.x)), static_cast<std::int64_t>(std::floor(p.y)),
                        static_cast<std::int64_t>(std::floor(p.z))});
    if (it == positions.end()) continue;
    ASSERT_GE(it->second, last) << "seed " << seed;
    last = it->second;
  }
}

TEST(VisitingOrder, IsFrontToBackFromAnyEye) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    const auto coordinate = [&] {
      return random.chance(0.3) ? random.between(-1, kEdge) - 0.5 : random.uniform(-kEdge, 2 * kEdge);
    };
    const glm::dvec3 eye(coordinate(), coordinate(), coordinate());
    Position positions;
    visit(VisitingOrder::fromEye(eye), {0, 0, 0}, kEdge, positions);
    ASSERT_EQ(positions.size(), std::size_t{kEdge} * kEdge * kEdge);
    for (int ray = 0; ray < 50; ++ray) expectFrontToBack(positions, eye, random.direction(), seed);
  }
}

TEST(VisitingOrder, IsFrontToBackAlongParallelRays) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    glm::dvec3 direction = random.direction();
    if (random.chance(0.3)) direction[random.between(0, 2)] = 0;
    direction = glm::normalize(direction);
    Position positions;
    visit(VisitingOrder::parallel(direction), {0, 0, 0}, kEdge, positions);
    ASSERT_EQ(positions.size(), std::size_t{kEdge} * kEdge * kEdge);
    for (int ray = 0; ray < 50; ++ray) {
      const glm::dvec3 through(random.uniform(0, kEdge), random.uniform(0, kEdge), random.uniform(0, kEdge));
      expectFrontToBack(positions, through - direction * (2.0 * kEdge), direction, seed);
    }
  }
}

}  // namespace
}  // namespace kiln::test
