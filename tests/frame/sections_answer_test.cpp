// Cut faces that show values. Known:
// 1. A linear volume: the value at the point where a ray meets the plane, its depth and its normal.
// 2. Labels: the label with the largest share of the eight voxels around a point.
// 3. Any volume: the reference renderer, which draws the face as the first sample of a ray.
// 4. An opaque face hides what is behind: only bricks that the plane meets are read.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_access.hpp>
#include <glm/matrix.hpp>
#include <optional>

#include "base/thread/parallel.h"
#include "image/compare.h"
#include "image/srgb.h"
#include "scene/transfer/display_map.h"
#include "scene/transfer/label_styles.h"
#include "support/reference/companions.h"
#include "support/reference/drawing.h"
#include "support/reference/reference_renderer.h"
#include "support/system/expect_error.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr Projection kSectionProjections[] = {Projection::kOrthographic, Projection::kPerspective};
constexpr double kPaletteStep = 1.0 / 255;

// Shows nothing anywhere.
TransferFunction sectionOfAir() { return {0, {{-1e9, glm::dvec3(1), 0}}}; }

Section grayWindow(double lo, double hi) { return {"gray", glm::dvec2{0.5 * (lo + hi), hi - lo}}; }

// The plane through a point of the world that looks along `normal` at what is shown.
ClipPlane planeThrough(const glm::dvec3& point, const glm::dvec3& normal) { return {normal, -glm::dot(normal, point)}; }

// The point where a ray meets a plane on its way to what is shown.
struct FacePoint {
  glm::dvec3 index, world;
  double margin;  // distance from the border of the volume, inside positive. unit: voxels
};
std::optional<FacePoint> faceOf(const VolumeGeometry& volume, const ClipPlane& plane, const Ray& ray) {
  const double slope = glm::dot(plane.normal, ray.direction);
  if (!(slope > 0)) return std::nullopt;
  const double along = -(glm::dot(plane.normal, ray.origin) + plane.offset) / slope;
  FacePoint out;
  out.world = ray.origin + along * ray.direction;
  out.index = glm::dvec3(glm::inverse(volume.world_from_index) * glm::dvec4(out.world, 1));
  const glm::dvec3 to_lo = out.index + 0.5,
                   to_hi = glm::dvec3(volume.dims.x, volume.dims.y, volume.dims.z) - 0.5 - out.index;
  out.margin = std::min({to_lo.x, to_lo.y, to_lo.z, to_hi.x, to_hi.y, to_hi.z});
  return out;
}

// Calls f(x, y, at) for each pixel, with its point on the request's first plane.
template <class F>
void forEachPixel(const FrameRequest& request, const VolumeGeometry& volume, const F& f) {
  for (int y = 0; y < request.view.size.height; ++y) {
    for (int x = 0; x < request.view.size.width; ++x)
      f(x, y, faceOf(volume, request.clipping.planes.front(), rayThrough(request.view, {x + 0.5, y + 0.5})));
  }
}

double valueOfRamp(const DenseVolume& volume, const glm::dvec3& index) {
  const Extent3& n = volume.geometry.dims;
  const glm::dvec3 inside = glm::clamp(index, glm::dvec3(0), glm::dvec3(n.x, n.y, n.z) - 1.0);
  return 2 * inside.x - 3 * inside.y + 1.5 * inside.z + 120;
}

// Compares display values of a pixel.
void expectColor(const float* pixel, const glm::dvec3& linear, const std::string& where) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(srgbFromLinear(static_cast<double>(pixel[c])), srgbFromLinear(linear[c]), kPaletteStep) << where;
}

class SectionsOfARamp : public ::testing::Test {
 protected:
  SectionsOfARamp()
      : volume_(fill({{40, 37, 50}, VoxelType::f32, obliqueAffine()},
                     [](auto i, auto j, auto k) {
                       return 2.0 * static_cast<double>(i) - 3.0 * static_cast<double>(j) +
                              1.5 * static_cast<double>(k) + 120;
                     })),
        store_(makeStore(volume_, "ramp", 16)),
        centre_(glm::dvec3(volume_.geometry.world_from_index * glm::dvec4(19.6, 18.1, 24.7, 1))) {}

  // Checks each pixel of the plane; others have an alpha of 0.
  template <class ColorOf>
  void check(FrameRequest request, const ColorOf& color_of) {
    const Image image = draw(store_, request);
    int seen = 0;
    forEachPixel(request, volume_.geometry, [&](int x, int y, const std::optional<FacePoint>& at) {
      const std::string where = std::to_string(x) + " " + std::to_string(y);
      if (at && std::abs(at->margin) < 0.01) return;
      const std::optional<glm::dvec3> color =
          at && at->margin > 0 ? color_of(valueOfRamp(volume_, at->index)) : std::optional<glm::dvec3>();
      if (!color) {
        EXPECT_EQ(image.pixel(x, y)[3], 0) << where;
        return;
      }
      ++seen;
      EXPECT_EQ(image.pixel(x, y)[3], 1) << where;
      expectColor(image.pixel(x, y), *color, where);
      const double depth = (request.view.view_from_world * glm::dvec4(at->world, 1)).z;
      EXPECT_NEAR(planeAt(image, "Z", x, y), depth, 0.002) << where;
      EXPECT_NEAR(planeAt(image, "depth.mean", x, y), depth, 0.002) << where;
      const glm::dvec3 normal = normalAt(image, x, y);
      EXPECT_LT(glm::length(normal + glm::normalize(request.clipping.planes.front().normal)), 1e-4) << where;
    });
    EXPECT_GT(seen, image.width * image.height / 12);
  }

  const DenseVolume volume_;
  const std::filesystem::path store_;
  const glm::dvec3 centre_;
};

TEST_F(SectionsOfARamp, ShowTheWindowOfValues) {
  for (const Projection projection : kSectionProjections) {
    for (const char* const map : {"gray", "viridis", "cool-to-warm"}) {
      SCOPED_TRACE(map);
      FrameRequest request = answerRequest(volume_.geometry, {0.5, -0.8, 0.4}, projection, 90);
      request.transfer_function = sectionOfAir();
      request.clipping.planes = {planeThrough(centre_, {-0.6, 0.9, -0.2})};
      request.clipping.section = Section{map, glm::dvec2{140, 150}};
      check(request, [&](double value) -> std::optional<glm::dvec3> {
        glm::dvec3 color = displayMap(map).at(std::clamp((value - 65) / 150, 0.0, 1.0));
        for (int c = 0; c < 3; ++c) color[c] = linearFromSrgb(color[c]);
        return color;
      });
    }
  }
}

// Red grows with the value; values below 110 are air.
TEST_F(SectionsOfARamp, ShowTheFunctionsColoursAndNoAir) {
  for (const Projection projection : kSectionProjections) {
    FrameRequest request = answerRequest(volume_.geometry, {0.5, -0.8, 0.4}, projection, 90);
    request.transfer_function = {
        0, {{0, {0, 0.5, 0}, 0}, {110, {0.5, 0.5, 0}, 0}, {110.001, {0.5, 0.5, 0}, 0.9}, {220, {1, 0.5, 0}, 1}}};
    request.clipping.planes = {planeThrough(centre_, {-0.6, 0.9, -0.2})};
    request.clipping.section = Section{};
    const Image image = draw(store_, request);
    int seen = 0, air = 0;
    forEachPixel(request, volume_.geometry, [&](int x, int y, const std::optional<FacePoint>& at) {
      if (!at || at->margin < 0.01) return;
      const double value = valueOfRamp(volume_, at->index);
      if (value > 112) {
        ++seen;
        EXPECT_EQ(image.pixel(x, y)[3], 1);
        expectColor(image.pixel(x, y), {0.5 + 0.5 * std::min((value - 110.001) / 109.999, 1.0), 0.5, 0}, "");
      } else if (value < 108) {
        // The ray goes on to what is behind the air, which begins at 110.
        const double depth = (request.view.view_from_world * glm::dvec4(at->world, 1)).z;
        EXPECT_GT(planeAt(image, "Z", x, y), depth + 0.1);
        ++air;
      }
    });
    EXPECT_GT(seen, 300);
    EXPECT_GT(air, 100);
  }
}

// A face of an opacity of 0.25 over air.
TEST_F(SectionsOfARamp, HaveAnOpacity) {
  FrameRequest request = answerRequest(volume_.geometry, {0.5, -0.8, 0.4}, Projection::kOrthographic, 60);
  request.transfer_function = sectionOfAir();
  request.clipping.planes = {planeThrough(centre_, {-0.6, 0.9, -0.2})};
  request.clipping.section = grayWindow(65, 215);
  const Image opaque = draw(store_, request);
  request.clipping.section->opacity = 0.25;
  const Image thin = draw(store_, request);
  for (std::size_t i = 0; i < opaque.rgba.size(); ++i) EXPECT_NEAR(thin.rgba[i], 0.25 * opaque.rgba[i], 1e-6);
}

// An eye inside the shown part sees no face of the plane behind it.
TEST_F(SectionsOfARamp, AreNotSeenFromInside) {
  FrameRequest request = answerRequest(volume_.geometry, {0.5, -0.8, 0.4}, Projection::kPerspective, 40);
  Camera camera = cameraFrom(volume_.geometry, {0.5, -0.8, 0.4}, Projection::kPerspective);
  camera.eye = centre_;
  camera.target = centre_ + glm::dvec3(-0.6, 0.9, -0.2);
  request.view = resolve(camera, {40, 40});
  request.transfer_function = sectionOfAir();
  request.clipping.planes = {planeThrough(centre_ - 3.0 * glm::dvec3(-0.6, 0.9, -0.2), {-0.6, 0.9, -0.2})};
  request.clipping.section = grayWindow(65, 215);
  EXPECT_FALSE(showsSomething(draw(store_, request)));
}

// Planes in the border of the volume cut nothing: they show no values, although rays enter the volume through them.
TEST_F(SectionsOfARamp, AreNotInTheBorderOfTheVolume) {
  const glm::dmat4 index_from_world = glm::inverse(volume_.geometry.world_from_index);
  const Extent3& n = volume_.geometry.dims;
  const glm::dvec3 lo(-0.5), hi = glm::dvec3(n.x, n.y, n.z) - 0.5;
  std::vector<ClipPlane> border;
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 inward(glm::row(index_from_world, axis));
    border.push_back(planeThrough(volume_.geometry.worldOf(lo), inward));
    border.push_back(planeThrough(volume_.geometry.worldOf(hi), -inward));
  }
  for (const Projection projection : kSectionProjections) {
    FrameRequest request = answerRequest(volume_.geometry, {0.5, -0.8, 0.4}, projection, 60);
    request.transfer_function = sectionOfAir();
    request.clipping.section = grayWindow(65, 215);
    request.clipping.planes = border;
    EXPECT_FALSE(showsSomething(draw(store_, request)));
    request.clipping.planes = {planeThrough(centre_, {-0.6, 0.9, -0.2})};
    const Image alone = draw(store_, request);
    EXPECT_TRUE(showsSomething(alone));
    request.clipping.planes.insert(request.clipping.planes.end(), border.begin(), border.end());
    EXPECT_EQ(draw(store_, request).rgba, alone.rgba);
  }
}

// Every ray enters through a face of a box inside the volume, the region's or the world's.
TEST_F(SectionsOfARamp, AreFacesOfRegions) {
  FrameRequest request = answerRequest(volume_.geometry, {0.5, -0.8, 0.4}, Projection::kPerspective, 60);
  request.transfer_function = sectionOfAir();
  request.clipping.region = VoxelBox{{8, 9, 10}, {31, 30, 41}};
  const Image nothing = draw(store_, request);
  EXPECT_FALSE(showsSomething(nothing));
  request.clipping.section = grayWindow(65, 215);
  const Image box = draw(store_, request);
  request.clipping.section.reset();
  request.transfer_function = {0, {{-1e9, glm::dvec3(0.5), 1}}};
  const Image solid = draw(store_, request);
  int seen = 0;
  for (int i = 3; i < static_cast<int>(box.rgba.size()); i += 4) {
    const float alpha = box.rgba[static_cast<std::size_t>(i)];
    seen += alpha > 0 ? 1 : 0;
    EXPECT_TRUE(alpha == 0 || alpha == 1);
    EXPECT_TRUE(alpha == 1 || solid.rgba[static_cast<std::size_t>(i)] < 0.999f);
  }
  EXPECT_GT(seen, 150);
}

// Shares of the labels 0 to 3 between eight voxels, each label interpolated by itself.
std::array<double, 4> sharesAt(const DenseVolume& volume, const glm::dvec3& index) {
  std::array<double, 4> out{};
  const glm::dvec3 first = glm::floor(index), t = index - first;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::array<std::int64_t, 3> at{};
    for (int axis = 0; axis < 3; ++axis) {
      const bool next = (corner >> axis & 1) != 0;
      weight *= next ? t[axis] : 1 - t[axis];
      at[static_cast<std::size_t>(axis)] = std::clamp(static_cast<std::int64_t>(first[axis]) + (next ? 1 : 0),
                                                      std::int64_t{0}, volume.geometry.dims[axis] - 1);
    }
    out[static_cast<std::size_t>(volume.valueAt(at[0], at[1], at[2]))] += weight;
  }
  return out;
}

// Labels are blocks of voxels. A face has the borders of the labels' surfaces and the colours of labels alone.
TEST(Sections, OfLabels_haveTheLargestShare) {
  const DenseVolume volume = fill({{30, 30, 30}, VoxelType::u8}, [](auto i, auto j, auto k) {
    return static_cast<double>((i / 7 + j / 6 + k / 9) % 4);
  });
  const auto store = makeStore(volume, "labels", 16, true);
  const glm::dvec3 colors[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Projection projection : kSectionProjections) {
    FrameRequest request = answerRequest(volume.geometry, {0.2, -0.9, 0.3}, projection, 80);
    for (int label = 1; label <= 3; ++label)
      request.transfer_function.labels.push_back({static_cast<double>(label), "", colors[label], 0.5});
    request.clipping.planes = {planeThrough({14.2, 14.6, 14.9}, {0.2, 0.8, -0.3})};
    request.clipping.section = Section{};
    const Image image = draw(store, request);
    int seen = 0, other = 0, smooth = 0;
    forEachPixel(request, volume.geometry, [&](int x, int y, const std::optional<FacePoint>& at) {
      if (!at || at->margin < 0.01) return;
      const std::array<double, 4> shares = sharesAt(volume, at->index);
      const double shown = shares[1] + shares[2] + shares[3];
      const double depth = (request.view.view_from_world * glm::dvec4(at->world, 1)).z;
      // The rise from nothing to a solid takes a quarter of a voxel.
      if (shown < 0.5 - 0.5 / static_cast<double>(kLabelRise) - 0.02) {
        ++other;
        EXPECT_GT(planeAt(image, "Z", x, y), depth + 1e-3);
        return;
      }
      if (shown < 0.5 + 0.5 / static_cast<double>(kLabelRise) + 0.02) return;
      const auto most = static_cast<std::size_t>(std::max_element(shares.begin() + 1, shares.end()) - shares.begin());
      for (std::size_t label = 1; label <= 3; ++label) {
        if (label != most && shares[most] - shares[label] < 1e-4) return;
      }
      ++seen;
      const glm::dvec3 nearest = glm::floor(at->index + 0.5);
      const double own = volume.valueAt(static_cast<std::int64_t>(nearest.x), static_cast<std::int64_t>(nearest.y),
                                        static_cast<std::int64_t>(nearest.z));
      smooth += own == static_cast<double>(most) ? 0 : 1;
      for (int c = 0; c < 3; ++c) EXPECT_EQ(image.pixel(x, y)[c], static_cast<float>(colors[most][c])) << x << " " << y;
      EXPECT_NEAR(planeAt(image, "Z", x, y), depth, 1e-3);
    });
    EXPECT_GT(seen, 300);
    EXPECT_GT(other, 50);
    EXPECT_GT(smooth, 2) << "somewhere the nearest voxel has another label";
  }
}

struct SectionCase {
  const char* name;
  Section section;
  TransferFunction function;
  Interpolation interpolation = Interpolation::kLinear;
};

std::vector<SectionCase> sectionCases(const ValueRange& range) {
  const double span = range.hi - range.lo;
  const auto at = [&](double share) { return range.lo + share * span; };
  const TransferFunction solid = {
      0, {{at(0.45), {0.9, 0.5, 0.3}, 0}, {at(0.55), {0.9, 0.7, 0.5}, 0.9}, {at(0.9), {0.4, 0.6, 1}, 1}}};
  const TransferFunction mist = {0, {{at(0.2), {0.9, 0.5, 0.3}, 0.02}, {at(0.9), {0.3, 0.6, 1}, 0.2}}};
  return {{"function, solid", {}, solid},
          {"function, mist", {}, mist},
          {"window, solid", grayWindow(at(0.2), at(0.9)), solid},
          {"map, catmull-rom", {"fire", glm::dvec2{at(0.5), span}}, solid, Interpolation::kCatmullRom},
          {"window of 0.5, solid", {"gray", glm::dvec2{at(0.5), span}, 0.5}, solid}};
}

TEST(Sections, AreLikeTheReference) {
  const DenseVolume volume = cheese({{50, 44, 47}, VoxelType::i16, anisotropicAffine()}, 5, usualRange(VoxelType::i16));
  const auto store = makeStore(volume, "cheese", 16);
  const glm::dvec3 centre(volume.geometry.world_from_index * glm::dvec4(24, 21, 22, 1));
  for (const SectionCase& each : sectionCases(volume.range())) {
    for (const Projection projection : kSectionProjections) {
      FrameRequest request = answerRequest(volume.geometry, {0.5, -0.9, 0.4}, projection, 80);
      request.aovs = {};
      request.samples = 16;
      request.opacity_threshold = 0.9999;
      request.transfer_function = each.function;
      request.interpolation = each.interpolation;
      request.clipping.planes = {planeThrough(centre, {-0.3, 0.9, -0.3}),
                                 planeThrough(centre + glm::dvec3(8, 0, 0), {-1, 0.1, 0})};
      request.clipping.section = each.section;
      ReferenceSettings settings;
      settings.clipping = request.clipping;
      settings.interpolation = each.interpolation;
      const Image truth = referenceImage(volume, request.view, each.function, request.shading, {0, 0, 0, 0}, settings);
      const ImageDifference d = compareImages(truth, draw(store, request));
      std::printf("%s: %.1f dB\n", each.name, d.psnr_db);
      EXPECT_GT(d.psnr_db, 40) << each.name;
    }
  }
}

TEST(Sections, OfSeveralVolumesAreLikeTheReference) {
  const DenseVolume first = cheese({{40, 44, 42}, VoxelType::i16}, 5, usualRange(VoxelType::i16));
  const DenseVolume second =
      cheese({{30, 30, 30}, VoxelType::u8, spacingAffine(glm::dvec3(1.1), glm::dvec3(9, 8, 5))}, 8, {0, 255});
  const std::vector<std::filesystem::path> stores = {makeStore(first, "first", 16), makeStore(second, "second", 16)};
  const std::vector<SectionCase> of_first = sectionCases(first.range()), of_second = sectionCases(second.range());
  FrameRequest request = answerRequest(first.geometry, {0.5, -0.9, 0.4}, Projection::kPerspective, 80);
  request.aovs = {};
  request.samples = 16;
  Clipping clipping;
  clipping.planes = {planeThrough({20, 20, 20}, {-0.3, 0.9, -0.3})};
  const auto compare = [&](const Section& a, const std::optional<Section>& b) {
    Clipping of_a = clipping, of_b = clipping;
    of_a.section = a, of_b.section = b;
    request.volumes = {{of_first[0].function, {}, of_a}, {of_second[1].function, {}, of_b}};
    const Image truth =
        referenceImage({{&first, of_first[0].function, {}, of_a}, {&second, of_second[1].function, {}, of_b}},
                       request.view, ReferenceSettings{});
    const double psnr = compareImages(truth, draw(stores, request)).psnr_db;
    std::printf("several volumes: %.1f dB\n", psnr);
    EXPECT_GT(psnr, 36);
  };
  compare(of_first[2].section, std::nullopt);
  compare(of_first[0].section, of_second[0].section);
}

// A volume without a section has matter in the slabs of the other volume's face, a varying part of each slab behind it.
TEST(Sections, AreNotTintedByOtherVolumes) {
  const DenseVolume values = cheese({{40, 44, 42}, VoxelType::i16}, 5, usualRange(VoxelType::i16));
  const DenseVolume solid = fill({{40, 44, 42}, VoxelType::u8}, [](auto, auto, auto) { return 1; });
  const std::vector<std::filesystem::path> stores = {makeStore(values, "values", 16),
                                                     makeStore(solid, "solid", 16, true)};
  FrameRequest request = answerRequest(values.geometry, {0.5, -0.9, 0.4}, Projection::kPerspective, 80);
  request.aovs = {};
  Clipping cut, with_face;
  cut.planes = with_face.planes = {planeThrough({20, 20, 20}, {-0.3, 0.9, -0.3})};
  with_face.section = grayWindow(values.range().lo, values.range().hi);
  TransferFunction label;
  label.labels = {{1, "", {0, 1, 0}, 1}};
  request.transfer_function = sectionCases(values.range())[0].function;
  request.clipping = with_face;
  for (const auto& [distance, unit] : {std::pair(0.25, 0.0), {0.5, 0.0}, {1.0, 0.0}, {1.0, 1e-4}}) {
    request.sample_distance = distance;
    label.unit = unit;
    request.volumes = {};
    const Image alone = draw(stores[0], request);
    request.volumes = {{request.transfer_function, {}, with_face}, {label, {}, cut}};
    const Image both = draw(stores, request);
    int seen = 0;
    forEachPixel(request, values.geometry, [&](int x, int y, const std::optional<FacePoint>& at) {
      if (!at || at->margin < 0.6) return;
      ++seen;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(both.pixel(x, y)[c], alone.pixel(x, y)[c], 2e-4) << x << ' ' << y;
    });
    EXPECT_GT(seen, 1000) << distance;
  }
}

// The plane lies in the first of eight layers of 64 bricks. Readers are at most eight bricks ahead of the drawing, so
// that they read some bricks that turn out to be hidden.
TEST(Sections, HideBricksBehindThem) {
  const DenseVolume volume = cheese({{64, 64, 64}, VoxelType::u8}, 3, {0, 255});
  const auto store = makeStore(volume, "bricks", 8);
  FrameRequest request = answerRequest(volume.geometry, {0, 0, 1}, Projection::kOrthographic, 100);
  request.aovs = {};
  request.crop = PixelRect{20, 20, 80, 80};  // pixels at the volume's border stay open
  const ThreadLimit one(1);
  request.bricks_together = 1;
  request.transfer_function = {0, {{-1e9, glm::dvec3(1), 0.01}}};
  request.clipping.planes = {planeThrough({0, 0, 60}, {0, 0, -1})};
  FrameStatistics all, faces;
  draw(store, request, 1ull << 30, &all);
  request.clipping.section = grayWindow(0, 255);
  draw(store, request, 1ull << 30, &faces);
  EXPECT_EQ(all.bricks_contributing, all.bricks_read);
  EXPECT_EQ(8 * faces.bricks_contributing, all.bricks_contributing);
  EXPECT_LT(faces.bricks_read, all.bricks_read / 2);
  EXPECT_EQ(faces.bricks_read + faces.bricks_hidden, all.bricks_read);
  // Bricks of air are read for their values.
  request.transfer_function = sectionOfAir();
  draw(store, request, 1ull << 30, &faces);
  EXPECT_EQ(8 * faces.bricks_read, all.bricks_read);
}

// The mask shows one half of the face.
TEST(Sections, ShowNothingBesideAMask) {
  const DenseVolume volume = ramp({{32, 32, 32}, VoxelType::u8}, 10, 4);
  const DenseVolume mask = fill({{32, 32, 32}, VoxelType::u8}, [](auto i, auto, auto) { return i < 16 ? 1 : 0; });
  const auto store = makeStore(volume, "volume", 16), of_mask = makeStore(mask, "mask", 16, true);
  FrameRequest request = answerRequest(volume.geometry, {0, 0, 1}, Projection::kOrthographic, 64);
  request.transfer_function = sectionOfAir();
  request.clipping.planes = {planeThrough({0, 0, 20.3}, {0, 0, -1})};
  request.clipping.section = grayWindow(0, 200);
  const Image image = draw(*masked(store, of_mask, {1}), request);
  int shown = 0, hidden = 0;
  forEachPixel(request, volume.geometry, [&](int x, int y, const std::optional<FacePoint>& at) {
    if (!at || at->margin < 0.01) return;
    const bool inside = at->index.x<14.9, outside = at->index.x> 16.1;
    shown += inside ? 1 : 0, hidden += outside ? 1 : 0;
    EXPECT_TRUE(!inside || image.pixel(x, y)[3] == 1);
    EXPECT_TRUE(!outside || image.pixel(x, y)[3] == 0);
  });
  EXPECT_GT(shown, 300);
  EXPECT_GT(hidden, 300);
}

// The plane runs away from the eye through several levels. Each pixel of it is covered, once, at its own depth.
TEST(Sections, HaveNoHolesBetweenLevels) {
  const DenseVolume volume = cheese({{160, 160, 60}, VoxelType::u8}, 3, {0, 255});
  const auto store = makeStore(volume, "levels", 16);
  Camera camera = cameraFrom(volume.geometry, {0, -1, 0.3}, Projection::kPerspective);
  camera.eye = {81.3, 4, 37.7};
  camera.target = {80, 80, 28};
  camera.up = {0, 0, 1};
  camera.fov_deg = 100;
  FrameRequest request = answerRequest(volume.geometry, {0, -1, 0.3}, Projection::kPerspective, 70);
  request.view = resolve(camera, {70, 70});
  request.level.reset();
  request.transfer_function = sectionOfAir();
  request.clipping.planes = {planeThrough({80, 80, 30.3}, {0.02, 0.01, -1})};
  request.clipping.section = grayWindow(0, 255);
  request.clipping.section->opacity = 0.5;
  FrameStatistics statistics;
  const Image image = draw(store, request, 1ull << 30, &statistics);
  for (const std::size_t level : {0, 1, 2}) EXPECT_GT(statistics.levels[level].voxels_visited, 0u) << level;
  int seen = 0;
  forEachPixel(request, volume.geometry, [&](int x, int y, const std::optional<FacePoint>& at) {
    const double depth = at ? (request.view.view_from_world * glm::dvec4(at->world, 1)).z : 0;
    if (!at || at->margin < 0.1 || depth < 1) return;
    ++seen;
    EXPECT_EQ(image.pixel(x, y)[3], 0.5f) << x << " " << y;
    EXPECT_NEAR(planeAt(image, "depth.mean", x, y), depth, 1e-3 * depth) << x << " " << y;
  });
  EXPECT_GT(seen, 1000);
}

// Rays that enter through the volume's own faces meet no cut face, and faces cast no shadow.
TEST(Sections, ChangeNoPixelBesideThem) {
  const DenseVolume volume = cheese({{40, 40, 40}, VoxelType::u8}, 3, {0, 255});
  const auto store = makeStore(volume, "volume", 16);
  FrameRequest request = answerRequest(volume.geometry, {0.4, -0.9, 0.5}, Projection::kPerspective, 70);
  request.transfer_function = {0, {{100, {0.9, 0.5, 0.3}, 0}, {140, {0.9, 0.7, 0.5}, 0.9}}};
  request.shading.lights.front() = {LightKind::kDirectional, {-0.2, -0.6, 1}};
  request.shading.lights.front().shadow.strength = 1;
  request.shading.occlusion.strength = 0.5;
  request.clipping.planes = {planeThrough({20, 20, 20}, {-1, 0.6, -0.5})};
  const Image before = draw(store, request);
  request.clipping.section = grayWindow(0, 255);
  const Image after = draw(store, request);
  int on = 0, beside = 0;
  forEachPixel(request, volume.geometry, [&](int x, int y, const std::optional<FacePoint>& at) {
    if (at && at->margin > -0.1) {
      ++on;
      return;
    }
    ++beside;
    for (int c = 0; c < 4; ++c) EXPECT_EQ(before.pixel(x, y)[c], after.pixel(x, y)[c]) << x << " " << y;
  });
  EXPECT_GT(on, 200);
  EXPECT_GT(beside, 1000);
}

// A surface behind its cut face: each pixel of the plane has the value's grey.
TEST(Sections, StandInFrontOfSurfaces) {
  const DenseVolume volume = ramp({{32, 32, 32}, VoxelType::u8}, 10, 4);
  const auto store = makeStore(volume, "volume", 16);
  FrameRequest request = answerRequest(volume.geometry, {0.1, 0.2, 1}, Projection::kPerspective, 64);
  request.transfer_function.surfaces = {{70.0}};
  request.clipping.planes = {planeThrough({0, 0, 20.3}, {0, 0, -1})};
  request.clipping.section = grayWindow(0, 200);
  const Image image = draw(store, request);
  int seen = 0;
  forEachPixel(request, volume.geometry, [&](int x, int y, const std::optional<FacePoint>& at) {
    if (!at || at->margin < 0.6) return;
    ++seen;
    expectColor(image.pixel(x, y), glm::dvec3(linearFromSrgb((10 + 4 * at->index.x) / 200)), "");
  });
  EXPECT_GT(seen, 500);
}

// A ball cut above its middle: the first voxel of its outside below the rim.
TEST(Sections, LeaveTheNormalsBelowTheirRim) {
  const glm::dvec3 centre(15.5);
  const DenseVolume volume = ball({{32, 32, 32}, VoxelType::u8}, centre, 11, 200);
  FrameRequest request = answerRequest(volume.geometry, {0.5, -0.9, 0.4}, Projection::kOrthographic, 160);
  request.transfer_function = {1, {{90, glm::dvec3(1), 0}, {110, glm::dvec3(1), 1}}};
  const double top = 18;
  request.clipping.planes = {planeThrough({0, 0, top}, {0, 0, -1})};
  request.clipping.section = Section{};
  const Image image = draw(makeStore(volume, "ball_below_rim", 32), request);
  int below = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double depth = planeAt(image, "Z", x, y);
      if (!std::isfinite(depth) || image.pixel(x, y)[3] < 1) continue;
      const Ray ray = rayThrough(request.view, {x + 0.5, y + 0.5});
      const double origin = (request.view.view_from_world * glm::dvec4(ray.origin, 1)).z;
      const double along = (depth - origin) / glm::dot(request.view.forward_world, ray.direction);
      const glm::dvec3 at = ray.origin + along * ray.direction;
      if (at.z > top - 0.1 || at.z < top - 0.8) continue;
      ++below;
      EXPECT_GT(glm::dot(normalAt(image, x, y), glm::normalize(at - centre)), 0.9) << x << ' ' << y;
    }
  }
  EXPECT_GT(below, 100);
}

}  // namespace
}  // namespace kiln::test
