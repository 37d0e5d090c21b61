// The border of a volume of few, large voxels. Known: a ray's optical depth is its length in the box, also of rays that
// cross an edge of the box between the middles of two slabs; and the normal of an opaque box is that of the face
// through which the ray enters, up to the edges between faces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "support/reference/drawing.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr int kPixels = 200;
constexpr Extent3 kDims{5, 4, 1};

// A ray's way through the box of the volume, whose voxels have an edge of 1.
struct Way {
  double enter = -std::numeric_limits<double>::infinity(), leave = std::numeric_limits<double>::infinity();
  glm::dvec3 out_of_face{0};  // normal of the face of entry
  double length() const { return std::max(leave - enter, 0.0); }
};

Way wayThrough(const Ray& ray) {
  Way out;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (-0.5 - ray.origin[axis]) / ray.direction[axis];
    const double b = (static_cast<double>(kDims[axis]) - 0.5 - ray.origin[axis]) / ray.direction[axis];
    out.leave = std::min(out.leave, std::max(a, b));
    if (std::min(a, b) <= out.enter) continue;
    out.enter = std::min(a, b);
    out.out_of_face = glm::dvec3(0);
    out.out_of_face[axis] = ray.direction[axis] > 0 ? -1 : 1;
  }
  return out;
}

class VolumeBorder : public ::testing::TestWithParam<Projection> {
 protected:
  static constexpr glm::dvec3 kFrom{0.5, -0.8, 0.35};
  VolumeBorder()
      : volume_(fill({kDims, VoxelType::u8}, [](auto...) { return 100; })),
        store_(makeStore(volume_, "border_box", 32)) {}
  FrameRequest request(double opacity) const {
    FrameRequest out = answerRequest(volume_.geometry, kFrom, GetParam(), kPixels);
    out.opacity_threshold = 1;
    out.transfer_function = {1, {{0, glm::dvec3(1), opacity}}};
    return out;
  }
  template <class F>
  static void forEachPixel(const FrameRequest& request, F f) {
    for (int y = 0; y < kPixels; ++y) {
      for (int x = 0; x < kPixels; ++x) f(x, y, wayThrough(rayThrough(request.view, {x + 0.5, y + 0.5})));
    }
  }

  DenseVolume volume_;
  std::filesystem::path store_;
};

TEST_P(VolumeBorder, EachRayHasItsLengthInTheBox) {
  constexpr double kOpacity = 0.6;
  const double tau = -std::log1p(-kOpacity);
  const FrameRequest one = request(kOpacity);
  FrameRequest two = one;
  two.volumes = {{one.transfer_function, {}, {}}, {one.transfer_function, {}, {}}};
  const Image of_one = draw(store_, one), of_two = draw({store_, store_}, two);
  int short_ways = 0;
  forEachPixel(one, [&](int x, int y, const Way& way) {
    EXPECT_NEAR(of_one.pixel(x, y)[3], -std::expm1(-tau * way.length()), 1e-3) << x << ' ' << y;
    EXPECT_NEAR(of_two.pixel(x, y)[3], -std::expm1(-2 * tau * way.length()), 1e-3) << x << ' ' << y;
    short_ways += way.length() > 0.02 && way.length() < 0.25 ? 1 : 0;
  });
  EXPECT_GT(short_ways, 100);
}

TEST_P(VolumeBorder, OpaqueFacesMeetInASharpEdge) {
  const FrameRequest opaque = request(0.99999);
  const Image image = draw(store_, opaque);
  int faces[3] = {};
  forEachPixel(opaque, [&](int x, int y, const Way& way) {
    if (way.length() < 0.1) return;
    const double cosine = glm::dot(normalAt(image, x, y), way.out_of_face);
    EXPECT_GT(cosine, 0.999) << x << ' ' << y;
    for (int axis = 0; axis < 3; ++axis) faces[axis] += way.out_of_face[axis] != 0 ? 1 : 0;
  });
  for (const int pixels : faces) EXPECT_GT(pixels, 1000);
}

INSTANTIATE_TEST_SUITE_P(Projections, VolumeBorder,
                         ::testing::Values(Projection::kOrthographic, Projection::kPerspective));

}  // namespace
}  // namespace kiln::test
