// Iso-surfaces against closed forms and against bisection in double precision. Known:
// 1. A ball: a ray meets the surface at the roots of a quadratic equation.
// 2. Any volume: crossings of the reference's own interpolation.
// 3. A closed surface: each ray crosses it an even number of times.
// 4. A cut opens a surface and moves nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vector_relational.hpp>
#include <limits>
#include <vector>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "support/reference/drawing.h"
#include "support/reference/surface_hits.h"
#include "support/system/expect_error.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr Projection kSurfaceProjections[] = {Projection::kOrthographic, Projection::kPerspective};
constexpr float kNoHit = std::numeric_limits<float>::infinity();

TransferFunction surfacesAt(std::vector<IsoSurface> surfaces) {
  TransferFunction out;
  out.surfaces = std::move(surfaces);
  return out;
}

double degreesBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::degrees(2 * std::asin(std::min(1.0, 0.5 * glm::length(a - b))));
}

// Distance along the pixel's ray of a depth in the picture. unit: world.
double alongOf(const View& view, const Ray& ray, double depth) {
  const glm::dvec4 origin = view.view_from_world * glm::dvec4(ray.origin, 1);
  const glm::dvec4 direction = view.view_from_world * glm::dvec4(ray.direction, 0);
  return (depth - origin.z) / direction.z;
}

struct Ball {
  glm::dvec3 centre;
  double radius;
  // Distance of the ray from the centre, and along the ray to the front of the ball.
  double nearest(const Ray& ray) const {
    const glm::dvec3 to = centre - ray.origin;
    return glm::length(to - glm::dot(to, ray.direction) * ray.direction);
  }
  double front(const Ray& ray) const { return glm::dot(centre - ray.origin, ray.direction) - halfChord(ray); }
  double halfChord(const Ray& ray) const {
    return std::sqrt(std::max(0.0, radius * radius - nearest(ray) * nearest(ray)));
  }
};

struct Largest {
  double depth = 0, angle = 0;  // unit: voxels, degrees
  int pixels = 0;
};

// Compares the pixels of an opaque ball with the closed form: distances of the points in the picture from the surface,
// and angles to the radius. Near the silhouette the front of the ball is ill-conditioned, but both of these are not.
Largest departureFrom(const Ball& ball, const FrameRequest& request, const Image& image) {
  Largest out;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
      const double beside = ball.radius - ball.nearest(ray);
      // The silhouette is as exact as the surface.
      if (std::abs(beside) > 0.02) {
        EXPECT_EQ(image.pixel(x, y)[3], beside > 0 ? 1.0f : 0.0f) << x << " " << y;
      }
      if (beside < 0.02) continue;
      const double along = alongOf(request.view, ray, planeAt(image, "Z", x, y));
      EXPECT_NEAR(along, ball.front(ray), beside < 1 ? 2 : 0.05);
      EXPECT_FLOAT_EQ(planeAt(image, "Z", x, y), planeAt(image, "depth.mean", x, y));
      const glm::dvec3 radius = ray.origin + along * ray.direction - ball.centre;
      out.depth = std::max(out.depth, std::abs(glm::length(radius) - ball.radius));
      out.angle = std::max(out.angle, degreesBetween(normalAt(image, x, y), glm::normalize(radius)));
      ++out.pixels;
    }
  }
  return out;
}

// The request's volume and a volume of which nothing shows, in one picture.
FrameRequest besideAnother(FrameRequest request) {
  request.volumes = {{request.transfer_function, request.shading, request.clipping},
                     {TransferFunction{1, {{0, glm::dvec3(1), 0}}}, request.shading, {}}};
  return request;
}

TEST(Surfaces, OfABallAreItsSurface) {
  const Ball ball{{40.3, 39.8, 40.1}, 34};
  const DenseVolume volume = fill({{81, 80, 82}, VoxelType::f32}, [&](auto i, auto j, auto k) {
    return 10 * (ball.radius - glm::length(glm::dvec3(i, j, k) - ball.centre));
  });
  const auto store = makeStore(volume, "ball", 32);
  for (const Projection projection : kSurfaceProjections) {
    for (const int size : {75, 140, 210}) {
      FrameRequest request = answerRequest(volume.geometry, {0.4, -0.8, 0.3}, projection, size);
      request.transfer_function = surfacesAt({{0}});
      for (const Image& image : {draw(store, request), draw({store, store}, besideAnother(request))}) {
        const Largest off = departureFrom(ball, request, image);
        std::printf("%d pixels: depth %.4f voxels, normal %.3f degrees\n", size, off.depth, off.angle);
        EXPECT_GT(off.pixels, size * size / 8);
        EXPECT_LT(off.depth, 0.02);
        EXPECT_LT(off.angle, 0.5);
      }
    }
  }
}

// Known because powers of two scale floats exactly, and a surface has no size of values.
TEST(Surfaces, OfHugeAndTinyValues_lookTheSame) {
  const auto ballOf = [](double scale) {
    return fill({{40, 41, 42}, VoxelType::f32}, [scale](auto i, auto j, auto k) {
      return scale * (15 - glm::length(glm::dvec3(i, j, k) - glm::dvec3(20.3, 19.8, 20.1)));
    });
  };
  const auto drawn = [&](double scale) {
    const DenseVolume volume = ballOf(scale);
    FrameRequest request = answerRequest(volume.geometry, {0.4, -0.8, 0.3}, Projection::kOrthographic, 80);
    request.transfer_function = surfacesAt({{2 * scale}});
    request.clipping.planes = {{{1, 0.3, 0.2}, 8}};
    return draw(makeStore(volume, "scaled", 32), request);
  };
  const Image truth = drawn(1);
  EXPECT_GT(glm::length(normalAt(truth, 40, 40)), 0.9);
  for (const double scale : {std::ldexp(1.0, 80), std::ldexp(1.0, -80)}) {
    const Image other = drawn(scale);
    float most = 0;
    for (std::size_t i = 0; i < truth.rgba.size(); ++i) most = std::max(most, std::abs(other.rgba[i] - truth.rgba[i]));
    EXPECT_LT(most, 1e-5f) << scale;
  }
}

// Values rise linearly, so that differences of all distances are the gradient. The surface ends at a gap of NaN.
TEST(Surfaces, AreLitUpToAGap) {
  const glm::dvec3 slope = glm::normalize(glm::dvec3(0.3, -1, 0.2));
  constexpr std::int64_t kGap = 24;
  const DenseVolume volume = fill({{41, 40, 42}, VoxelType::f32}, [&](auto i, auto j, auto k) {
    return i >= kGap && i < kGap + 4 ? NAN : 20 - glm::dot(slope, glm::dvec3(i - 20.0, j - 20.0, k - 20.0)) * 10;
  });
  FrameRequest request = answerRequest(volume.geometry, {0.4, -0.8, 0.3}, Projection::kOrthographic, 160);
  request.transfer_function = surfacesAt({{20}});
  const Image image = draw(makeStore(volume, "gap", 16), request);
  int beside = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float depth = planeAt(image, "Z", x, y);
      if (depth == kNoHit) continue;
      const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
      const glm::dvec3 at = ray.origin + alongOf(request.view, ray, depth) * ray.direction;
      if (at.y < 2 || at.y > 37 || at.z < 2 || at.z > 39 || at.x < 2 || at.x > 38) continue;
      EXPECT_LT(degreesBetween(normalAt(image, x, y), slope), 0.1) << at.x << " " << at.y << " " << at.z;
      beside += at.x > kGap - 2 && at.x < kGap - 1 ? 1 : 0;
    }
  }
  EXPECT_GT(beside, 100);
}

// Between voxels of R² - r², the Catmull-Rom spline is exact and the B-spline averages over a variance of 1/3 along
// each axis.
TEST(Surfaces, OfCubicsAreTheSurfaceOfTheInterpolation) {
  const glm::dvec3 centre(20.3, 19.8, 20.1);
  const double radius2 = 256;
  const DenseVolume volume = fill({{41, 40, 42}, VoxelType::f32}, [&](auto i, auto j, auto k) {
    const glm::dvec3 r = glm::dvec3(i, j, k) - centre;
    return radius2 - glm::dot(r, r);
  });
  const auto store = makeStore(volume, "ball", 16);
  for (const Projection projection : kSurfaceProjections) {
    for (const Interpolation interpolation : {Interpolation::kCubic, Interpolation::kCatmullRom}) {
      FrameRequest request = answerRequest(volume.geometry, {0.4, -0.8, 0.3}, projection, 90);
      request.transfer_function = surfacesAt({{0}});
      request.interpolation = interpolation;
      const Ball ball{centre, std::sqrt(radius2 - (interpolation == Interpolation::kCubic ? 1 : 0))};
      const Largest off = departureFrom(ball, request, draw(store, request));
      EXPECT_GT(off.pixels, 1000);
      EXPECT_LT(off.depth, 0.002);
      EXPECT_LT(off.angle, 0.05);
    }
  }
}

// Rays that touch a surface may cross the surface twice or three times within an eighth of a voxel; a pair of these
// crossings is not found.
TEST(Surfaces, AreWhereBisectionFindsThem) {
  constexpr int kSize = 200, kEvery = 5;  // rays that are compared
  std::vector<DenseVolume> volumes;
  volumes.push_back(cheese({{50, 41, 60}, VoxelType::i16, anisotropicAffine()}, 1, usualRange(VoxelType::i16)));
  volumes.push_back(cheese({{40, 57, 45}, VoxelType::f32, obliqueAffine()}, 2, usualRange(VoxelType::f32)));
  for (const DenseVolume& volume : volumes) {
    const auto store = makeStore(volume, "cheese", 16);
    const double value = 0.5 * (volume.range().lo + volume.range().hi), edge = volume.geometry.shortestEdge();
    for (const Interpolation interpolation : {Interpolation::kLinear, Interpolation::kCatmullRom}) {
      const SurfaceHits truth(volume, interpolation, 0.05);
      for (const Projection projection : kSurfaceProjections) {
        FrameRequest request = answerRequest(volume.geometry, {0.4, -0.8, 0.3}, projection, kSize);
        request.transfer_function = surfacesAt({{value}});
        request.interpolation = interpolation;
        const Image image = draw(store, request);
        int hits = 0, touched = 0;
        Largest off;
        for (int y = 0; y < kSize; y += kEvery) {
          for (int x = 0; x < kSize; x += kEvery) {
            const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
            const std::vector<SurfaceHit> all = truth.along(ray, value);
            const float depth = planeAt(image, "Z", x, y);
            if (all.empty()) {
              EXPECT_EQ(depth, kNoHit);
              continue;
            }
            ++hits;
            const double along = alongOf(request.view, ray, depth);
            const auto departure = [&](const SurfaceHit& hit) { return std::abs(along - hit.along) / edge; };
            const auto nearest =
                std::min_element(all.begin(), all.end(),
                                 [&](const SurfaceHit& a, const SurfaceHit& b) { return departure(a) < departure(b); });
            if (nearest != all.begin()) {
              ++touched;
              EXPECT_LT((all[1].along - all[0].along) / edge, 0.15);
            }
            if (depth == kNoHit) continue;
            off.depth = std::max(off.depth, departure(*nearest));
            off.angle = std::max(off.angle, degreesBetween(normalAt(image, x, y), nearest->normal));
          }
        }
        std::printf("%d of 1600 rays, %d touch: depth %.5f voxels, normal %.4f degrees\n", hits, touched, off.depth,
                    off.angle);
        EXPECT_GT(hits, 200);
        EXPECT_LE(touched, hits / 200);
        EXPECT_LT(off.depth, 0.002);
        EXPECT_LT(off.angle, 0.05);
      }
    }
  }
}

// Crossings of the pixels' rays with a surface: most of a ray, and rays with an odd number.
struct Crossings {
  int most = 0, odd = 0;
};
Crossings crossingsIn(const Image& image, double opacity) {
  Crossings out;
  for (std::size_t at = 3; at < image.rgba.size(); at += 4) {
    const double crossings = std::log1p(-static_cast<double>(image.rgba[at])) / std::log1p(-opacity);
    const auto count = static_cast<int>(std::lround(crossings));
    EXPECT_NEAR(crossings, count, 0.01);
    out.odd += count % 2;
    out.most = std::max(out.most, count);
  }
  return out;
}

// The voxels at the faces of the volume are outside the surface, so all rays begin and end outside. A crossing that is
// lost or found twice, at a border of slabs, cells, bricks or zones, makes the number odd.
TEST(Surfaces, AreCrossedAnEvenNumberOfTimes) {
  const DenseVolume rough = noise({{50, 43, 47}, VoxelType::u8}, 3, {0, 255});
  const DenseVolume volume = fill({{50, 43, 47}, VoxelType::u8}, [&](auto i, auto j, auto k) {
    const bool at_face = i == 0 || j == 0 || k == 0 || i == 49 || j == 42 || k == 46;
    return at_face ? 0 : rough.valueAt(i, j, k);
  });
  // An opacity for which alpha still tells 40 crossings apart.
  constexpr double kOpacity = 0.125;
  const auto store = makeStore(volume, "rough", 16);
  struct Case {
    Interpolation interpolation;
    double value;
    std::vector<int> sizes;  // a voxel is between a quarter of a pixel and six pixels wide
  };
  // The B-spline flattens noise.
  const std::array cases = {Case{Interpolation::kLinear, 230, {20, 64, 333}}, Case{Interpolation::kCubic, 150, {64}},
                            Case{Interpolation::kCatmullRom, 230, {64}}};
  for (const Case& c : cases) {
    int most = 0;
    for (const Projection projection : kSurfaceProjections) {
      for (const int size : c.sizes) {
        for (const double distance : {0.25, 0.5, 1.0}) {
          FrameRequest request = answerRequest(volume.geometry, {0.4, -0.8, 0.3}, projection, size);
          request.aovs = {};
          request.opacity_threshold = 1;
          request.interpolation = c.interpolation;
          request.sample_distance = distance;
          request.transfer_function = surfacesAt({{c.value, glm::dvec3(1), kOpacity}});
          const Crossings found = crossingsIn(draw(store, request), kOpacity);
          most = std::max(most, found.most);
          EXPECT_EQ(found.odd, 0) << static_cast<int>(c.interpolation) << ", " << size << " pixels, distance "
                                  << distance;
        }
      }
    }
    EXPECT_GT(most, 6) << static_cast<int>(c.interpolation);
  }
}

// Values rise along x, so rays along x meet the surfaces in order: behind a translucent red surface an opaque green.
TEST(Surfaces, HaveColorsAndOpacitiesOfTheirOwn) {
  const DenseVolume volume = ramp({{16, 16, 16}, VoxelType::u8}, 0, 10);
  const auto store = makeStore(volume, "ramp", 16);
  for (const bool rising : {true, false}) {
    FrameRequest request = answerRequest(volume.geometry, {rising ? -1 : 1, 0, 0}, Projection::kOrthographic, 20);
    request.shading.phong = false;
    // Two surfaces in one slab keep their order.
    request.transfer_function = surfacesAt({{71, {1, 0, 0}, 0.25}, {72, {0, 1, 0}, 1}, {200, {0, 0, 1}, 1}});
    const Image image = draw(store, request);
    const float* const middle = image.pixel(10, 10);
    EXPECT_FLOAT_EQ(middle[0], rising ? 0.25f : 0.0f);
    EXPECT_FLOAT_EQ(middle[1], rising ? 0.75f : 1.0f);
    EXPECT_EQ(middle[2], 0);
    EXPECT_EQ(middle[3], 1);
    const Ray ray = rayThrough(request.view, {10.5, 10.5});
    const glm::dvec3 at = ray.origin + alongOf(request.view, ray, planeAt(image, "Z", 10, 10)) * ray.direction;
    EXPECT_NEAR(at.x, 7.2, 1e-4);
  }
}

TEST(Surfaces, AreOpenedByACut) {
  const Ball ball{{20.3, 19.8, 20.1}, 16};
  const DenseVolume volume = fill({{41, 40, 42}, VoxelType::f32}, [&](auto i, auto j, auto k) {
    return ball.radius - glm::length(glm::dvec3(i, j, k) - ball.centre);
  });
  const auto store = makeStore(volume, "ball", 16);
  FrameRequest request = answerRequest(volume.geometry, {0, -1, 0}, Projection::kPerspective, 80);
  // Cuts off the half in front.
  request.clipping.planes = {{{0, 1, 0}, -ball.centre.y}};
  request.transfer_function = surfacesAt({{0}});
  const Image image = draw(store, request);
  int seen = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
      const double at_plane = (ball.centre.y - ray.origin.y) / ray.direction.y;
      const bool through = glm::length(ray.origin + at_plane * ray.direction - ball.centre) < ball.radius - 0.1;
      if (!through) continue;
      ++seen;
      const double back = ball.front(ray) + 2 * ball.halfChord(ray);
      EXPECT_NEAR(alongOf(request.view, ray, planeAt(image, "Z", x, y)), back, 0.1);
      const glm::dvec3 inward = glm::normalize(ball.centre - (ray.origin + back * ray.direction));
      EXPECT_LT(degreesBetween(normalAt(image, x, y), inward), 3);
    }
  }
  EXPECT_GT(seen, 500);
}

// A slope from near the eye to far away, drawn in several levels. Each coarser level blurs the edge, and its surface at
// a low value lies farther out. Rays do not pass between the surfaces of two levels.
TEST(Surfaces, HaveNoHolesWhereLevelsMeet) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.1, -0.15, 1)), foot(64, 64, 50);
  const DenseVolume volume = fill({{128, 128, 128}, VoxelType::u8}, [&](auto i, auto j, auto k) {
    return std::clamp(128 - 255 * glm::dot(glm::dvec3(i, j, k) - foot, normal), 0.0, 255.0);
  });
  const auto store = makeStore(volume, "slope", 16);
  Camera camera = cameraFrom(volume.geometry, {0, -1, 0.3}, Projection::kPerspective);
  camera.eye = {60, -4, 52};
  camera.target = {64, 100, 45};
  camera.fov_deg = 80;
  // Sums of optical depths are rounded.
  constexpr float kRounding = 1e-4f;
  for (const auto& [opacity, volumes] : {std::pair{1.0f, 1}, {0.5f, 1}, {1.0f, 2}, {0.5f, 2}}) {
    int levels = 0, seen = 0, twice = 0;
    for (const int size : {60, 83, 120}) {
      FrameRequest request = answerRequest(volume.geometry, {0, -1, 0}, Projection::kPerspective, size);
      request.view = resolve(camera, {size, size});
      request.level.reset();
      request.opacity_threshold = 1;
      request.transfer_function = surfacesAt({{20, glm::dvec3(1), opacity}});
      FrameStatistics statistics;
      const Image image = volumes == 1 ? draw(store, request, 1ull << 30, &statistics)
                                       : draw({store, store}, besideAnother(request), 1ull << 30, &statistics);
      for (const auto& level : statistics.levels) levels += level.bricks > 0 ? 1 : 0;
      for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
          const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
          const double along = glm::dot(foot - ray.origin, normal) / glm::dot(ray.direction, normal);
          const glm::dvec3 at = ray.origin + along * ray.direction;
          if (!(along > 0) || glm::any(glm::lessThan(at, glm::dvec3(12))) ||
              glm::any(glm::greaterThan(at, glm::dvec3(116))))
            continue;
          ++seen;
          const float alpha = image.pixel(x, y)[3];
          EXPECT_GE(alpha, opacity - kRounding) << x << " " << y;
          twice += alpha > opacity + kRounding ? 1 : 0;
        }
      }
    }
    std::printf("%d of %d rays cross the surfaces of two levels\n", twice, seen);
    EXPECT_GE(levels, 5);
    EXPECT_GT(seen, 3000);
    EXPECT_LT(twice, seen / 200);
  }
}

// `request` is the picture's without shadows.
void expectShadowBelow(const Ball& ball, const FrameRequest& request, const Image& lit, const Image& shadowed) {
  int dark = 0, same = 0;
  for (int y = 0; y < lit.height; ++y) {
    for (int x = 0; x < lit.width; ++x) {
      if (lit.pixel(x, y)[3] != 1) continue;
      const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
      const glm::dvec3 at = ray.origin + alongOf(request.view, ray, planeAt(lit, "Z", x, y)) * ray.direction;
      const bool on_floor = at.z < 9;
      const double from_axis = glm::length(glm::dvec2(at - ball.centre));
      if (on_floor && from_axis < ball.radius - 2) {
        EXPECT_NEAR(shadowed.pixel(x, y)[0], request.shading.ambient, 0.01) << x << " " << y;
        ++dark;
      } else if (on_floor ? from_axis > ball.radius + 2 : at.z > ball.centre.z + 2) {
        EXPECT_NEAR(shadowed.pixel(x, y)[0], lit.pixel(x, y)[0], 0.01) << x << " " << y;
        ++same;
      }
    }
  }
  EXPECT_GT(dark, 50);
  EXPECT_GT(same, 1000);
}

// A ball above a floor in light from straight above. The floor under the ball has ambient light only; far from the
// shadow the light is that of a picture without shadows, and the ball's lit half has no shadow of its own.
TEST(Surfaces, CastShadows) {
  const Ball ball{{32, 32, 40}, 10};
  const DenseVolume volume = fill({{65, 65, 65}, VoxelType::f32}, [&](auto i, auto j, auto k) {
    return std::max(8.3 - static_cast<double>(k), ball.radius - glm::length(glm::dvec3(i, j, k) - ball.centre));
  });
  const auto store = makeStore(volume, "above", 32);
  FrameRequest request = answerRequest(volume.geometry, {0.6, -1, 0.7}, Projection::kPerspective, 120);
  request.transfer_function = surfacesAt({{0, glm::dvec3(1)}});
  request.shading.specular = 0;
  request.shading.lights = {Light{}};
  request.shading.lights[0].kind = LightKind::kDirectional;
  FrameRequest with_shadows = request;
  with_shadows.shading.shadows = true;
  const auto beside = [](const FrameRequest& one) {
    FrameRequest out = besideAnother(one);
    out.volumes[0].shading = out.volumes[1].shading = one.shading;
    return out;
  };
  expectShadowBelow(ball, request, draw(store, request), draw(store, with_shadows));
  expectShadowBelow(ball, request, draw({store, store}, beside(request)), draw({store, store}, beside(with_shadows)));
}

// Two opaque balls of two volumes, each inside the other in part. Known: a ray meets the nearer front first.
TEST(Surfaces, OfTwoVolumesHideEachOther) {
  const Ball red{{24, 32, 32}, 16}, blue{{40, 30, 34}, 14};
  const auto volumeOf = [](const Ball& ball) {
    return fill({{65, 65, 65}, VoxelType::f32},
                [&](auto i, auto j, auto k) { return ball.radius - glm::length(glm::dvec3(i, j, k) - ball.centre); });
  };
  const DenseVolume of_red_ball = volumeOf(red);
  const std::vector<std::filesystem::path> stores = {makeStore(of_red_ball, "red", 32),
                                                     makeStore(volumeOf(blue), "blue", 32)};
  for (const Projection projection : kSurfaceProjections) {
    FrameRequest request = answerRequest(of_red_ball.geometry, {0.2, -1, 0.3}, projection, 240);
    request.volumes = {{surfacesAt({{0, glm::dvec3(1, 0, 0)}}), request.shading, {}},
                       {surfacesAt({{0, glm::dvec3(0, 0, 1)}}), request.shading, {}}};
    for (VolumeRequest& volume : request.volumes) volume.shading.phong = false;
    const Image image = draw(stores, request);
    int seen[2] = {};
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
        const auto front = [&](const Ball& ball) {
          return ball.nearest(ray) < ball.radius ? ball.front(ray) : std::numeric_limits<double>::infinity();
        };
        const double of_red = front(red), of_blue = front(blue);
        // Samples of a slab mix, and the silhouettes are those of other tests.
        const bool silhouette =
            std::abs(red.nearest(ray) - red.radius) < 0.3 || std::abs(blue.nearest(ray) - blue.radius) < 0.3;
        if (std::min(of_red, of_blue) == std::numeric_limits<double>::infinity() || silhouette) continue;
        if (std::abs(of_red - of_blue) < 1) continue;
        const int nearer = of_red < of_blue ? 0 : 2;
        EXPECT_NEAR(image.pixel(x, y)[nearer], 1, 1e-3) << x << " " << y;
        EXPECT_NEAR(image.pixel(x, y)[2 - nearer], 0, 1e-3) << x << " " << y;
        EXPECT_NEAR(alongOf(request.view, ray, planeAt(image, "Z", x, y)), std::min(of_red, of_blue), 0.1);
        ++seen[nearer / 2];
      }
    }
    EXPECT_GT(seen[0], 1000);
    EXPECT_GT(seen[1], 1000);
  }
}

TEST(Surfaces, AreRefusedByOtherEngines) {
  const DenseVolume volume = ramp({{16, 16, 16}, VoxelType::u8}, 0, 10);
  const auto store = makeStore(volume, "ramp", 16);
  FrameRequest request = answerRequest(volume.geometry, {1, 0, 0}, Projection::kOrthographic, 20);
  request.transfer_function = surfacesAt({{71}});
  request.aovs = {};
  request.lattice = Lattice::kVoxel;
  expectError([&] { draw(store, request); }, ErrorCode::kUsage,
              "--tf: surfaces (iso:VALUE) need --lattice pixel, or several volumes (found --lattice voxel); choose "
              "solid:VALUE");
  request.lattice = Lattice::kPixel;
  request.mode = Mode::kMip;
  expectError([&] { draw(store, request); }, ErrorCode::kUsage, "found --mode mip");
}

}  // namespace
}  // namespace kiln::test
