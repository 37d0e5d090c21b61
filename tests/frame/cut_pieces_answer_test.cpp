// Pieces of rays at the border of a volume of few, large voxels, and at cuts. Known: a ray's optical depth is its
// length in what is shown of the box, also of rays that cross an edge between the middles of two slabs; an opaque box
// has the normal and the depth of the face through which the ray enters, up to the edges between faces; and the light
// of a ramp of colours has an integral in closed form.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <ostream>
#include <tuple>
#include <vector>

#include "scene/clip_region.h"
#include "support/reference/drawing.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr int kCutPixels = 200;
constexpr Extent3 kCutDims{5, 4, 1}, kThinCells{9, 17, 1};  // 9 and 17: the last cell is a voxel

// A ray's way through the convex part that planes show.
struct Way {
  double enter = -std::numeric_limits<double>::infinity(), leave = std::numeric_limits<double>::infinity();
  glm::dvec3 out_of_face{0};  // normal of the face of entry
  double length() const { return std::max(leave - enter, 0.0); }
};

Way wayThrough(const Ray& ray, const std::vector<ClipPlane>& planes) {
  Way out;
  for (const ClipPlane& plane : planes) {
    const double rate = glm::dot(plane.normal, ray.direction);
    const double at = -(glm::dot(plane.normal, ray.origin) + plane.offset) / rate;
    if (rate < 0) out.leave = std::min(out.leave, at);
    if (rate > 0 && at > out.enter) out.enter = at, out.out_of_face = -glm::normalize(plane.normal);
  }
  return out;
}

struct Cut {
  const char* name;
  std::vector<ClipPlane> planes;
};
void PrintTo(const Cut& cut, std::ostream* out) { *out << cut.name; }

// A box of voxels with an edge of 1, cut by planes.
class Pieces : public ::testing::TestWithParam<std::tuple<Projection, Cut>> {
 protected:
  static constexpr glm::dvec3 kFrom{0.5, -0.8, 0.35};
  explicit Pieces(const DenseVolume& volume) : volume_(volume), store_(makeStore(volume, "cut_pieces", 32)) {
    planes_ = cut().planes;
    const Extent3& dims = volume.geometry.dims;
    const glm::dvec3 size(dims.x, dims.y, dims.z);
    for (const ClipPlane& side : facesOf(glm::dvec3(-0.5), size - 0.5)) planes_.push_back(side);
  }
  Pieces() : Pieces(fill({kCutDims, VoxelType::u8}, [](auto...) { return 100; })) {}

  static Projection projection() { return std::get<0>(GetParam()); }
  static const Cut& cut() { return std::get<1>(GetParam()); }
  FrameRequest request(double opacity) const {
    FrameRequest out = answerRequest(volume_.geometry, kFrom, projection(), kCutPixels);
    out.opacity_threshold = 1;
    out.transfer_function = {1, {{0, glm::dvec3(1), opacity}}};
    out.clipping.planes = cut().planes;
    return out;
  }
  template <class F>
  void forEachPixel(const FrameRequest& request, F f) const {
    for (int y = 0; y < kCutPixels; ++y) {
      for (int x = 0; x < kCutPixels; ++x) {
        const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
        f(x, y, ray, wayThrough(ray, planes_));
      }
    }
  }

  DenseVolume volume_;
  std::filesystem::path store_;
  std::vector<ClipPlane> planes_;
};

TEST_P(Pieces, EachRayHasItsLengthInTheBox) {
  constexpr double kOpacity = 0.6;
  const double tau = -std::log1p(-kOpacity);
  const FrameRequest one = request(kOpacity);
  FrameRequest two = one;
  two.volumes = {{one.transfer_function, {}, one.clipping}, {one.transfer_function, {}, one.clipping}};
  const Image of_one = draw(store_, one), of_two = draw({store_, store_}, two);
  int short_ways = 0;
  forEachPixel(one, [&](int x, int y, const Ray&, const Way& way) {
    EXPECT_NEAR(of_one.pixel(x, y)[3], -std::expm1(-tau * way.length()), 1e-3) << x << ' ' << y;
    EXPECT_NEAR(of_two.pixel(x, y)[3], -std::expm1(-2 * tau * way.length()), 1e-3) << x << ' ' << y;
    short_ways += way.length() > 0.02 && way.length() < 0.25 ? 1 : 0;
  });
  EXPECT_GT(short_ways, 100);
}

TEST_P(Pieces, OpaqueFacesMeetInASharpEdge) {
  const FrameRequest opaque = request(1 - 1e-9);
  const Image image = draw(store_, opaque);
  int pixels = 0;
  forEachPixel(opaque, [&](int x, int y, const Ray& ray, const Way& way) {
    if (way.length() < 0.1) return;
    ++pixels;
    EXPECT_GT(glm::dot(normalAt(image, x, y), way.out_of_face), 0.999) << x << ' ' << y;
    const glm::dvec3 entry = ray.origin + way.enter * ray.direction;
    const double depth = (opaque.view.view_from_world * glm::dvec4(entry, 1)).z;
    EXPECT_NEAR(planeAt(image, "Z", x, y), depth, 0.1) << x << ' ' << y;
  });
  EXPECT_GT(pixels, 4000);
}

// All samples of a translucent box have no normal, or that of the face of entry.
TEST_P(Pieces, NoFaceLightsWhatIsBehindAnother) {
  const FrameRequest translucent = request(0.4);
  const Image image = draw(store_, translucent);
  forEachPixel(translucent, [&](int x, int y, const Ray&, const Way& way) {
    if (way.length() < 0.1) return;
    const glm::dvec3 normal = normalAt(image, x, y);
    EXPECT_GT(glm::dot(normal, way.out_of_face), 0.999 * glm::length(normal)) << x << ' ' << y;
  });
}

class PiecesOfARamp : public Pieces {
 protected:
  // The value is the place along x, and the colour the value.
  PiecesOfARamp() : Pieces(ramp({{20, 20, 20}, VoxelType::f32}, 0, 1)) {}
};

TEST_P(PiecesOfARamp, HaveTheLightOfTheClosedForm) {
  constexpr double kOpacity = 0.9;
  const double tau = -std::log1p(-kOpacity);
  FrameRequest ramped = request(kOpacity);
  ramped.shading.phong = false;
  ramped.transfer_function = {1, {{0, glm::dvec3(0), kOpacity}, {19, glm::dvec3(1), kOpacity}}};
  const Image image = draw(store_, ramped);
  double squares = 0, worst = 0;
  int pixels = 0;
  forEachPixel(ramped, [&](int x, int y, const Ray& ray, const Way& way) {
    const double enter = (ray.origin.x + way.enter * ray.direction.x) / 19, slope = ray.direction.x / 19;
    const double leave = (ray.origin.x + way.leave * ray.direction.x) / 19;
    // Beyond the voxels' centres values are constant.
    if (way.length() < 0.1 || std::min(enter, leave) < 0 || std::max(enter, leave) > 1) return;
    const double depth = tau * way.length(), seen = -std::expm1(-depth);
    const double light = enter * seen + slope * (seen - depth * std::exp(-depth)) / tau;
    const double error = static_cast<double>(image.pixel(x, y)[0]) - light;
    squares += error * error, worst = std::max(worst, std::abs(error)), ++pixels;
  });
  std::printf("rms %.6f, worst %.6f of %d pixels\n", std::sqrt(squares / pixels), worst, pixels);
  EXPECT_GT(pixels, 4000);
  EXPECT_LT(worst, 0.001);
}

// A headlight on a solid of one colour: the face's normal within a voxel of the face, the ramp's behind.
TEST_P(PiecesOfARamp, AreLitByTheFaceForAVoxel) {
  constexpr double kOpacity = 0.3;
  const double tau = -std::log1p(-kOpacity);
  FrameRequest lit = request(kOpacity);
  lit.shading.specular = 0;
  const Image image = draw(store_, lit);
  double worst = 0;
  int pixels = 0;
  forEachPixel(lit, [&](int x, int y, const Ray& ray, const Way& way) {
    const double exit = ray.origin.x + way.leave * ray.direction.x;
    // Beyond the voxels' centres the ramp has no direction.
    if (way.length() < 0.1 || exit < 0 || exit > 19) return;
    const auto lightOf = [&](const glm::dvec3& normal) {
      return lit.shading.ambient + lit.shading.diffuse * std::abs(glm::dot(normal, ray.direction));
    };
    const glm::dvec3& face = way.out_of_face;
    const double voxel = std::abs(face.x) + std::abs(face.y) + std::abs(face.z);
    const double near = std::min(voxel / std::abs(glm::dot(face, ray.direction)), way.length());
    const double of_face = -std::expm1(-tau * near), all = -std::expm1(-tau * way.length());
    const double light = of_face * lightOf(face) + (all - of_face) * lightOf({1, 0, 0});
    worst = std::max(worst, std::abs(static_cast<double>(image.pixel(x, y)[0]) - light)), ++pixels;
    const glm::dvec3 of_ramp(ray.direction.x < 0 ? 1 : -1, 0, 0);
    const glm::dvec3 normal = glm::normalize(of_face * face + (all - of_face) * of_ramp);
    EXPECT_GT(glm::dot(normalAt(image, x, y), normal), 0.999) << x << ' ' << y;
  });
  EXPECT_GT(pixels, 4000);
  EXPECT_LT(worst, 0.001);
}

const Cut kCuts[] = {{"nothing", {}},
                     {"corner", {{{-0.7, 0.5, -0.3}, 1.1}}},
                     {"wedge", {{{-0.7, 0.5, -0.3}, 1.3}, {{0.4, 0.8, 0.1}, -0.6}}}};
const auto kAll = ::testing::Combine(::testing::Values(Projection::kOrthographic, Projection::kPerspective),
                                     ::testing::ValuesIn(kCuts));
INSTANTIATE_TEST_SUITE_P(Cuts, Pieces, kAll);

// Rays whose last sample is in the cell before a thin one, at slabs of several voxels.
TEST(PiecesOfThinCells, EachRayHasItsLengthInTheBox) {
  constexpr double kOpacity = 0.2;
  const double tau = -std::log1p(-kOpacity);
  const DenseVolume volume = fill({kThinCells, VoxelType::u8}, [](auto...) { return 100; });
  const std::filesystem::path store = makeStore(volume, "thin_cells", 32);
  for (const int pixels : {5, 9, 20, 60}) {
    FrameRequest request = answerRequest(volume.geometry, {0.5, -0.8, 0.35}, Projection::kOrthographic, pixels);
    request.opacity_threshold = 1;
    request.transfer_function = {1, {{0, glm::dvec3(1), kOpacity}}};
    const Image image = draw(store, request);
    const glm::dvec3 size(kThinCells.x, kThinCells.y, kThinCells.z);
    for (int y = 0; y < pixels; ++y) {
      for (int x = 0; x < pixels; ++x) {
        const Way way = wayThrough(rayThrough(request.view, {x + 0.5, y + 0.5}), facesOf(glm::dvec3(-0.5), size - 0.5));
        EXPECT_NEAR(image.pixel(x, y)[3], -std::expm1(-tau * way.length()), 1e-3) << pixels << ' ' << x << ' ' << y;
      }
    }
  }
}

// Rays in the face between two regions, and beside the face: the optical depths of both regions are the whole.
TEST(PiecesOfRegions, HaveTheLengthOfTheWhole) {
  const DenseVolume volume = fill({{8, 8, 8}, VoxelType::u8}, [](auto...) { return 100; });
  const std::filesystem::path store = makeStore(volume, "regions", 32);
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    FrameRequest request = answerRequest(volume.geometry, {0, -1, 0}, projection, 9);
    request.opacity_threshold = 1;
    request.transfer_function = {1, {{0, glm::dvec3(1), 0.3}}};
    const Image whole = draw(store, request);
    request.clipping.region = VoxelBox{{0, 0, 0}, {4, 8, 8}};
    const Image left = draw(store, request);
    request.clipping.region = VoxelBox{{4, 0, 0}, {8, 8, 8}};
    const Image right = draw(store, request);
    for (int y = 0; y < 9; ++y) {
      for (int x = 0; x < 9; ++x) {
        const auto clear = [&](const Image& image) { return 1 - double{image.pixel(x, y)[3]}; };
        EXPECT_NEAR(clear(left) * clear(right), clear(whole), 1e-5) << x << ' ' << y;
      }
    }
  }
}

const Cut kRampCuts[] = {{"nothing", {}}, {"slant", {{{-0.5, 0.9, -0.3}, -4}}}};
INSTANTIATE_TEST_SUITE_P(Cuts, PiecesOfARamp,
                         ::testing::Combine(::testing::Values(Projection::kOrthographic, Projection::kPerspective),
                                            ::testing::ValuesIn(kRampCuts)));

}  // namespace
}  // namespace kiln::test
