// Annotations against geometry that the test computes: bars, ticks, arrows and edges to half a pixel, in both
// projections and at four sizes. Colours of the legend equal the transfer function; edges follow a depth plane.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>

#include "annotate/annotator.h"
#include "annotate/edge_letters.h"
#include "annotate/font.h"
#include "annotate/legend.h"
#include "annotate/orientation.h"
#include "annotate/places.h"
#include "annotate/round_numbers.h"
#include "annotate/scale_bar.h"
#include "annotate/volume_outline.h"

namespace kiln {
namespace {

constexpr double kHalf = 0.5;

// A box of 100 x 80 x 60 voxels of 0.5 x 0.5 x 1 micrometres.
VolumeGeometry boxOfTest() {
  VolumeGeometry out;
  out.dims = {100, 80, 60};
  out.world_from_index = {{0.5, 0, 0, 0}, {0, 0.5, 0, 0}, {0, 0, 1, 0}, {3, -2, 7, 1}};
  out.unit = "um";
  return out;
}

TransferFunction functionOfTest() {
  return {.points = {{-500, {1, 1, 0}, 0}, {100, {1, 0, 0}, 0}, {600, {0, 1, 0.5}, 0.5}, {1500, {0.2, 0.4, 1}, 1}}};
}

struct Case {
  Projection projection;
  ImageSize size;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << (c.projection == Projection::kPerspective ? "perspective " : "orthographic ") << c.size.width << "x"
             << c.size.height;
}

AnnotatedPicture pictureOf(const Case& c) {
  AnnotatedPicture out;
  out.box = boxOfTest();
  Camera camera;
  camera.projection = c.projection;
  camera.target = centreOf(out.box) + glm::dvec3(1, 2, -1);
  camera.eye = camera.target + glm::dvec3(105, -120, 95);
  camera.up = {0, 0, 1};
  camera.fov_deg = 35;
  camera.height = 110;
  out.view = resolve(camera, c.size);
  out.pixels = {0, 0, c.size.width, c.size.height};
  out.target_depth = glm::distance(camera.eye, camera.target);
  out.background = {{0, 0, 0, 1}, {0, 0, 0, 1}};
  out.shown = {{"volume", functionOfTest(), {}, {}}};
  out.annotations.color = glm::dvec3(1);
  return out;
}

// Annotations over black: the red channel is the coverage of white ink.
Image drawn(const AnnotatedPicture& picture, const float* depth = nullptr) {
  Image out(picture.pixels.width(), picture.pixels.height());
  Annotator(picture).over(out, 0, picture.pixels.y0, depth);
  return out;
}

glm::dvec3 seenFrom(const View& view, const glm::dvec3& world) {
  return glm::dvec3(view.view_from_world * glm::dvec4(world, 1));
}

class AnnotationsAt : public ::testing::TestWithParam<Case> {};

INSTANTIATE_TEST_SUITE_P(
    Views, AnnotationsAt,
    ::testing::Values(Case{Projection::kPerspective, {480, 360}}, Case{Projection::kPerspective, {1280, 720}},
                      Case{Projection::kPerspective, {900, 1400}}, Case{Projection::kPerspective, {3840, 2160}},
                      Case{Projection::kOrthographic, {480, 360}}, Case{Projection::kOrthographic, {1280, 720}},
                      Case{Projection::kOrthographic, {900, 1400}}, Case{Projection::kOrthographic, {3840, 2160}}));

// Known: two points at the target, apart across the view by the length that the label names.
TEST_P(AnnotationsAt, ScaleBar_hasTheLengthOfItsLabel) {
  AnnotatedPicture picture = pictureOf(GetParam());
  picture.annotations.scale_bar = true;
  const Image image = drawn(picture);
  const Style style(picture);
  // The middle row of the bar.
  const int row = static_cast<int>(std::lround(image.height - style.margin - 0.11 * style.em - 0.5));
  double length_px = 0, end = 0;
  for (int x = 0; x < image.width; ++x) {
    length_px += image.pixel(x, row)[0];
    if (image.pixel(x, row)[0] > 0) end = x + image.pixel(x, row)[0];
  }
  const ScaleBar bar = scaleBarOf(picture);
  double named = 0;
  char unit[8] = "";
  ASSERT_EQ(std::sscanf(bar.label.c_str(), "%lf %7s", &named, unit), 2) << bar.label;
  EXPECT_STREQ(unit, "µm");
  const glm::dvec3 middle = glm::dvec3(0, 0, picture.target_depth);
  const View& view = picture.view;
  const double expected = view.pixelOf(middle + glm::dvec3(named, 0, 0)).x - view.pixelOf(middle).x;
  EXPECT_NEAR(length_px, expected, kHalf);
  EXPECT_NEAR(end, image.width - style.margin, kHalf);
  const double digit = named / std::pow(10, std::floor(std::log10(named) + 1e-9));
  EXPECT_LT(std::min({std::abs(digit - 1), std::abs(digit - 2), std::abs(digit - 5)}), 1e-9) << bar.label;
  EXPECT_LE(length_px, 0.22 * image.width + kHalf);
  EXPECT_GT(2.5 * length_px, 0.22 * image.width - 2);
}

// Known: the projected corners. Each edge is tested where no other edge is near.
TEST_P(AnnotationsAt, EdgesOfTheBox_runBetweenItsProjectedCorners) {
  AnnotatedPicture picture = pictureOf(GetParam());
  picture.annotations.box = true;
  const Image image = drawn(picture);
  const auto corners = picture.box.corners();
  std::vector<std::pair<glm::dvec2, glm::dvec2>> lines;
  for (std::size_t a = 0; a < corners.size(); ++a) {
    for (std::size_t b = a + 1; b < corners.size(); ++b) {
      const glm::dvec3 along = corners[b] - corners[a];
      if ((along.x != 0) + (along.y != 0) + (along.z != 0) == 1)
        lines.emplace_back(picture.view.pixelOf(seenFrom(picture.view, corners[a])),
                           picture.view.pixelOf(seenFrom(picture.view, corners[b])));
    }
  }
  ASSERT_EQ(lines.size(), 12u);
  EXPECT_EQ(edgesOf(picture.box, {}).size(), 12u);
  const Style style(picture);
  const double reach = std::ceil(style.line) + 2;
  const auto distance = [](const std::pair<glm::dvec2, glm::dvec2>& line, const glm::dvec2& p) {
    const glm::dvec2 along = line.second - line.first;
    const double t = std::clamp(glm::dot(p - line.first, along) / glm::dot(along, along), 0.0, 1.0);
    return glm::distance(line.first + t * along, p);
  };
  int measured = 0;
  for (const auto& line : lines) {
    for (const double t : {0.15, 0.35, 0.5, 0.65, 0.85}) {
      const glm::dvec2 p = line.first + t * (line.second - line.first);
      const bool crowded = std::any_of(lines.begin(), lines.end(), [&](const auto& other) {
        return &other != &line && distance(other, p) < 3 * reach;
      });
      if (crowded || p.x < 3 * reach || p.y < 3 * reach || p.x > image.width - 3 * reach ||
          p.y > image.height - 3 * reach)
        continue;
      const glm::dvec2 along = glm::normalize(line.second - line.first);
      const bool steep = std::abs(along.y) > std::abs(along.x);
      // The middle of the ink in a column of pixels across a flat line, in a row across a steep one.
      const int fixed = static_cast<int>(std::floor(steep ? p.y : p.x));
      const double at = steep ? line.first.x + (fixed + 0.5 - line.first.y) * along.x / along.y
                              : line.first.y + (fixed + 0.5 - line.first.x) * along.y / along.x;
      double ink = 0, moment = 0;
      for (int i = static_cast<int>(at - 2 * reach); i <= static_cast<int>(at + 2 * reach); ++i) {
        const float here = steep ? image.pixel(i, fixed)[0] : image.pixel(fixed, i)[0];
        ink += here, moment += here * (i + 0.5);
      }
      ASSERT_GT(ink, 0.5 * style.line);
      EXPECT_NEAR(moment / ink, at, kHalf);
      ++measured;
    }
  }
  EXPECT_GE(measured, 20);
}

// Known: a tick of a value lies as far up the bar as the value lies between the ends.
TEST_P(AnnotationsAt, TicksOfTheLegend_lieAtTheirValues) {
  AnnotatedPicture picture = pictureOf(GetParam());
  picture.annotations.legend = true;
  const Image image = drawn(picture);
  const Style style(picture);
  const ColorBar bar = legendParts(picture, style).at(0).bar;
  EXPECT_EQ(bar.lo, 100);  // below, nothing is visible
  EXPECT_EQ(bar.hi, 1500);
  const std::vector<double> expected = {200, 400, 600, 800, 1000, 1200, 1400};
  EXPECT_EQ(bar.ticks, expected);
  const int column =
      bar.at.x1 + std::max(1, static_cast<int>(std::lround(style.line))) + static_cast<int>(0.15 * style.em);
  for (const double tick : expected) {
    const double y = bar.at.y1 - (tick - 100) / 1400 * bar.at.height();
    double ink = 0, moment = 0;
    const int reach = static_cast<int>(std::ceil(style.line)) + 2;
    for (int row = static_cast<int>(y) - reach; row <= static_cast<int>(y) + reach; ++row) {
      const float here = image.pixel(column, row)[0];
      ink += here, moment += here * (row + 0.5);
    }
    EXPECT_NEAR(ink, style.line, 0.1) << tick;
    EXPECT_NEAR(moment / ink, y, kHalf) << tick;
  }
}

// Known: colours of a companion are drawn at all values, whatever the opacities of their function.
TEST_P(AnnotationsAt, LegendOfColors_endsAtTheFunctionsEnds) {
  AnnotatedPicture picture = pictureOf(GetParam());
  picture.annotations.legend = true;
  picture.shown[0].colors_only = true;
  const ColorBar bar = legendParts(picture, Style(picture)).at(0).bar;
  EXPECT_EQ(bar.lo, picture.shown[0].function.points.front().value);
  EXPECT_LT(bar.lo, 100);
  EXPECT_EQ(bar.hi, picture.shown[0].function.points.back().value);
}

TEST_P(AnnotationsAt, ColorsOfTheLegend_areTheFunctionsAtTenValues) {
  AnnotatedPicture picture = pictureOf(GetParam());
  picture.annotations.legend = true;
  const Image image = drawn(picture);
  const ColorBar bar = legendParts(picture, Style(picture)).at(0).bar;
  const int column = (bar.at.x0 + bar.at.x1) / 2;
  for (int i = 0; i < 10; ++i) {
    const double value = 100 + 1400 * (i + 0.5) / 10;
    const double y = bar.at.y1 - (value - 100) / 1400 * bar.at.height();
    const float* const pixel = image.pixel(column, static_cast<int>(y));
    const glm::dvec3 color = picture.shown[0].function.at(value).color;
    // The function changes by less than this over a row of pixels.
    const double step = 1400.0 / bar.at.height() / 500;
    for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(pixel[channel], color[channel], step) << value;
    EXPECT_EQ(pixel[3], 1.0f);
  }
}

// Known: arrows point where the camera shows unit vectors. Each axis stands out in one mixture of channels.
TEST_P(AnnotationsAt, Arrows_pointAlongTheAxes) {
  AnnotatedPicture picture = pictureOf(GetParam());
  picture.annotations.axes = true;
  picture.annotations.color = glm::dvec3(0.2);  // letters are grey, their rims black
  const Image image = drawn(picture);
  const Style style(picture);
  const glm::dvec2 middle = middleOfDirections(picture, style);
  const glm::dvec3 mixtures[3] = {{1, -1, 0}, {-1, 2, -1}, {0, -1, 1}};
  for (int axis = 0; axis < 3; ++axis) {
    const auto seenAt = [&](double x, double y) {
      const float* const pixel = image.pixel(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
      return glm::dot(mixtures[axis], glm::dvec3(pixel[0], pixel[1], pixel[2]));
    };
    glm::dvec3 unit(0);
    unit[axis] = 1;
    const glm::dvec3 turned =
        seenFrom(picture.view, picture.view.eye_world + unit) - seenFrom(picture.view, picture.view.eye_world);
    const glm::dvec2 seen(turned.x, turned.y), along = glm::normalize(seen), tip = middle + 2 * style.em * seen;
    const glm::dvec2 before = tip - 0.8 * along, beyond = tip + 1.3 * along;
    EXPECT_GT(seenAt(before.x, before.y), 0.01) << axis;
    EXPECT_LT(seenAt(beyond.x, beyond.y), 0.01) << axis;
    // The middle of the shaft.
    const bool steep = std::abs(along.y) > std::abs(along.x);
    const glm::dvec2 p = middle + 0.4 * (tip - middle);
    const double fixed = std::floor(steep ? p.y : p.x) + 0.5;
    const double at =
        steep ? middle.x + (fixed - middle.y) * along.x / along.y : middle.y + (fixed - middle.x) * along.y / along.x;
    double ink = 0, moment = 0;
    for (double i = std::floor(at) - 6 - style.em / 4; i <= at + 6 + style.em / 4; ++i) {
      const double here = std::max(0.0, steep ? seenAt(i + 0.5, fixed) : seenAt(fixed, i + 0.5));
      ink += here, moment += here * (i + 0.5);
    }
    EXPECT_NEAR(moment / ink, at, kHalf) << axis;
  }
}

// Known: a plane of depth between the box's corners. Edges are solid in front, and behind dashed and dim.
TEST_P(AnnotationsAt, EdgesBehindTheDepth_areDashedAndDim) {
  AnnotatedPicture picture = pictureOf(GetParam());
  picture.annotations.box = true;
  picture.has_depth = true;
  const View& view = picture.view;
  const double wall = seenFrom(view, centreOf(picture.box)).z;
  const std::vector<float> depth(picture.pixels.count(), static_cast<float>(wall));
  const Image image = drawn(picture, depth.data());
  const Style style(picture);
  const double slack = glm::length(picture.box.spacing());
  int in_front = 0, behind = 0, gaps = 0;
  for (const auto& [a, b] : edgesOf(picture.box, {})) {
    for (double t = 0.02; t < 1; t += 0.005) {
      const glm::dvec3 p = seenFrom(view, a + t * (b - a));
      const glm::dvec2 px = view.pixelOf(p);
      // Other edges are tested elsewhere.
      bool crowded = px.x < 4 || px.y < 4 || px.x > image.width - 4 || px.y > image.height - 4;
      for (const auto& [c, d] : edgesOf(picture.box, {})) {
        const glm::dvec2 from = view.pixelOf(seenFrom(view, c)), to = view.pixelOf(seenFrom(view, d));
        const double s = std::clamp(glm::dot(px - from, to - from) / glm::dot(to - from, to - from), 0.0, 1.0);
        crowded = crowded || (c != a && glm::distance(from + s * (to - from), px) < style.line + 3) ||
                  (c == a && d != b && glm::distance(from + s * (to - from), px) < style.line + 3);
      }
      if (crowded) continue;
      double most = 0;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx)
          most = std::max<double>(most, image.pixel(static_cast<int>(px.x) + dx, static_cast<int>(px.y) + dy)[0]);
      }
      // A pixel's own distance from the change of depth along the edge.
      const glm::dvec3 next = seenFrom(view, a + (t + 0.001) * (b - a));
      const double depth_per_px = std::abs(next.z - p.z) / glm::distance(view.pixelOf(next), px);
      if (p.z < wall + slack - 2 * depth_per_px) {
        EXPECT_GT(most, std::min(0.95, 0.5 * style.line)) << t;
        ++in_front;
      } else if (p.z > wall + slack + 2 * depth_per_px) {
        EXPECT_LT(most, 0.6) << t;
        ++behind;
        gaps += most < 0.02 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(in_front, 100);
  EXPECT_GT(behind, 100);
  EXPECT_GT(gaps, behind / 10);
}

// A crop has the pixels of the whole, bit by bit; and the planes of an EXR are the layer that is laid over a picture.
TEST_P(AnnotationsAt, Crops_equalTheWhole) {
  AnnotatedPicture picture = pictureOf(GetParam());
  Annotations& all = picture.annotations;
  all.scale_bar = all.box = all.legend = all.axes = true;
  all.color.reset();
  all.text = "Grüße, {{µ}}";
  picture.has_depth = true;
  std::vector<float> depth(picture.pixels.count());
  for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = static_cast<float>(190 + 30 * std::sin(0.01 * i));
  const Image whole = drawn(picture, depth.data());
  const int w = whole.width, h = whole.height;
  for (const PixelRect& crop :
       {PixelRect{w / 3, h / 4, w / 3 + 101, h / 4 + 57}, PixelRect{w - 90, h - 80, w, h}, PixelRect{0, 0, 33, 29}}) {
    picture.pixels = crop;
    std::vector<float> of_crop;
    for (int y = crop.y0; y < crop.y1; ++y)
      of_crop.insert(of_crop.end(), depth.begin() + y * w + crop.x0, depth.begin() + y * w + crop.x1);
    const Image part = drawn(picture, of_crop.data());
    Image planes(crop.width(), crop.height());
    Annotator(picture).addPlanes(planes, crop.y0, of_crop.data());
    ASSERT_EQ(planes.planes.size(), 4u);
    std::size_t different = 0;
    for (int y = 0; y < part.height; ++y) {
      for (int x = 0; x < part.width; ++x) {
        for (int channel = 0; channel < 4; ++channel) {
          const auto c = static_cast<std::size_t>(channel);
          const float here = part.pixel(x, y)[channel];
          different += here != whole.pixel(crop.x0 + x, crop.y0 + y)[channel] ? 1 : 0;
          different += here != planes.planes[c].values[static_cast<std::size_t>(y * part.width + x)] ? 1 : 0;
        }
      }
    }
    EXPECT_EQ(different, 0u);
  }
}

// A plane cuts a corner off: 3 edges more. All points lie in the box and on the plane's side that is kept.
TEST(VolumeOutline, CutCorner_hasATriangle) {
  VolumeGeometry box;
  box.dims = {10, 10, 10};
  Clipping clipping;
  clipping.planes = {{{-1, -1, -1}, 24}};
  const std::vector<Edge> edges = edgesOf(box, clipping);
  EXPECT_EQ(edges.size(), 15u);
  for (const auto& [a, b] : edges) {
    for (const glm::dvec3& p : {a, b}) {
      EXPECT_LE(p.x + p.y + p.z, 24 + 1e-9);
      EXPECT_LE(std::max({p.x, p.y, p.z}), 9.5 + 1e-9);
    }
  }
}

// Planes on the box's faces change nothing; a region is a smaller box; a plane beside the box leaves nothing.
TEST(VolumeOutline, FacesAndRegions_areBoxes) {
  VolumeGeometry box;
  box.dims = {10, 20, 30};
  Clipping faces;
  faces.planes = {{{1, 0, 0}, 0.5}, {{-2, 0, 0}, 19}, {{0, 0, 1}, 0.5}};
  EXPECT_EQ(edgesOf(box, faces).size(), 12u);
  Clipping region;
  region.region = VoxelBox{{2, 3, 4}, {5, 6, 7}};
  double longest = 0;
  for (const auto& [a, b] : edgesOf(box, region)) longest = std::max(longest, glm::distance(a, b));
  EXPECT_NEAR(longest, 3, 1e-12);
  Clipping none;
  none.planes = {{{1, 0, 0}, -100}};
  EXPECT_TRUE(edgesOf(box, none).empty());
}

TEST(Directions, PatientFrames_haveTheirLetters) {
  AnnotatedPicture picture = pictureOf({Projection::kOrthographic, {100, 100}});
  for (const auto& [frame, positive_x] : {std::pair{PatientFrame::kLps, "L"}, std::pair{PatientFrame::kRas, "R"}}) {
    picture.box.frame = frame;
    const std::vector<Direction> all = directionsOf(picture);
    ASSERT_EQ(all.size(), 6u);
    for (const Direction& direction : all) {
      const glm::dvec3 x = glm::dvec3(picture.view.view_from_world[0]);
      if (direction.name == positive_x) {
        EXPECT_LT(glm::distance(direction.seen, x), 1e-12);
      }
    }
    EXPECT_GE(all.front().seen.z, all.back().seen.z);
  }
  picture.box.frame = PatientFrame::kUnknown;
  EXPECT_EQ(directionsOf(picture).size(), 3u);
}

// Known: seen from a quarter of a turn between two axes, both point to the same side of the picture.
TEST(Directions, LettersOfAxesThatPointToOneSide_areApart) {
  AnnotatedPicture picture = pictureOf({Projection::kOrthographic, {480, 400}});
  picture.box.frame = PatientFrame::kRas;
  for (const double azimuth : {0.0, 30.0, 40.0, 45.0, 50.0, 90.0}) {
    for (const double elevation : {0.0, 10.0, 45.0}) {
      Camera camera;
      camera.projection = Projection::kOrthographic;
      camera.target = centreOf(picture.box);
      const double a = azimuth * std::numbers::pi / 180, e = elevation * std::numbers::pi / 180;
      camera.eye =
          camera.target + 100.0 * glm::dvec3(std::cos(e) * std::sin(a), std::cos(e) * std::cos(a), std::sin(e));
      camera.up = {0, 0, 1};
      camera.height = 110;
      picture.view = resolve(camera, {480, 400});
      const Style style(picture);
      const auto places = letterPlaces(picture, directionsOf(picture), style);
      for (std::size_t i = 0; i < places.size(); ++i) {
        if (!places[i]) continue;
        EXPECT_GT(std::min(places[i]->x, 400 - places[i]->y), 0.5 * style.em);
        for (std::size_t j = 0; j < i; ++j) {
          if (!places[j]) continue;
          EXPECT_GT(glm::distance(*places[i], *places[j]), style.em) << azimuth << ' ' << elevation;
        }
      }
    }
  }
}

// Known: an axis along the view has its letter at the middle of the marker, where it would cross the other arrows.
TEST(Directions, LetterOfAnAxisTowardsTheEye_standsAside) {
  AnnotatedPicture picture = pictureOf({Projection::kOrthographic, {720, 720}});
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.target = centreOf(picture.box);
  camera.eye = camera.target + glm::dvec3(0, 0, 100);
  camera.up = {0, 1, 0};
  camera.height = 110;
  picture.view = resolve(camera, {720, 720});
  picture.annotations.axes = true;
  const Image image = drawn(picture);
  const Style style(picture);
  const glm::dvec2 middle = middleOfDirections(picture, style);
  // Letters are white, unlike arrows and rims.
  double nearest = 1e9;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float* const p = image.pixel(x, y);
      if (std::min({p[0], p[1], p[2]}) > 0.95f) nearest = std::min(nearest, glm::distance(middle, {x + 0.5, y + 0.5}));
    }
  }
  EXPECT_GT(nearest, 0.5 * style.em);
  EXPECT_LT(nearest, 1.2 * style.em);
}

// The pixels with more ink than a third: the least and the greatest column and row. A stem may lie between pixels.
PixelRect inkIn(const Image& image, const PixelRect& part) {
  PixelRect out{part.x1, part.y1, part.x0, part.y0};
  for (int y = part.y0; y < part.y1; ++y) {
    for (int x = part.x0; x < part.x1; ++x) {
      if (image.pixel(x, y)[0] < 0.34f) continue;
      out = {std::min(out.x0, x), std::min(out.y0, y), std::max(out.x1, x + 1), std::max(out.y1, y + 1)};
    }
  }
  return out;
}

// Known: I is narrower than all other letters.
TEST(EdgeLetters, StandAtTheMiddlesOfTheEdges) {
  for (const auto& [width, height] : {std::pair{320, 200}, {64, 90}, {kLeastLetteredSide, 400}}) {
    SCOPED_TRACE(width);
    Image image(width, height);
    drawEdgeLetters({'I', 'L', 'A', 'P'}, image);
    const int room = edgeLetterRoom({width, height});
    ASSERT_GT(room, 0);
    const PixelRect left = inkIn(image, {0, room, room, height - room});
    const PixelRect right = inkIn(image, {width - room, room, width, height - room});
    const PixelRect top = inkIn(image, {room, 0, width - room, room});
    const PixelRect bottom = inkIn(image, {room, height - room, width - room, height});
    for (const PixelRect& letter : {left, right, top, bottom}) ASSERT_LT(letter.x0, letter.x1);
    for (const PixelRect& letter : {left, right}) EXPECT_NEAR(0.5 * (letter.y0 + letter.y1), 0.5 * height, 1);
    for (const PixelRect& letter : {top, bottom}) EXPECT_NEAR(0.5 * (letter.x0 + letter.x1), 0.5 * width, 1.5);
    EXPECT_LT(left.x1 - left.x0, right.x1 - right.x0) << "I is at the left";
    EXPECT_GT(left.x0, 0);
    EXPECT_LT(right.x1, width);
    // The right edge has an L in both pictures.
    Image other(width, height);
    drawEdgeLetters({'R', 'L', 'S', 'I'}, other);
    for (int y = room; y < height - room; ++y) {
      for (int x = width - room; x < width; ++x) EXPECT_EQ(image.pixel(x, y)[0], other.pixel(x, y)[0]);
    }
    // Between the letters there is nothing.
    for (int y = room; y < height - room; ++y) {
      for (int x = room; x < width - room; ++x) ASSERT_EQ(image.pixel(x, y)[3], 0) << x << " " << y;
    }
  }
  Image small(kLeastLetteredSide - 1, 100), unknown(100, 100);
  drawEdgeLetters({'R', 'L', 'A', 'P'}, small);
  drawEdgeLetters({}, unknown);
  for (const Image* image : {&small, &unknown}) {
    EXPECT_TRUE(std::ranges::all_of(image->rgba, [](float value) { return value == 0; }));
  }
}

TEST(EdgeLetters, Planes_areTheLettersOfThePicture) {
  Image drawn_over(120, 90), with_planes(120, 90);
  drawEdgeLetters({'R', 'L', 'A', 'P'}, drawn_over);
  addEdgeLetterPlanes({'R', 'L', 'A', 'P'}, with_planes);
  ASSERT_EQ(with_planes.planes.size(), 4u);
  EXPECT_EQ(with_planes.planes[3].name, "annotation.A");
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 120; ++x) {
      for (std::size_t channel = 0; channel < 4; ++channel)
        EXPECT_EQ(with_planes.planes[channel].values[static_cast<std::size_t>(120 * y + x)],
                  drawn_over.pixel(x, y)[channel]);
      EXPECT_EQ(with_planes.pixel(x, y)[3], 0);
    }
  }
}

TEST(Legend, SurfacesAndLabels_areEntries) {
  TransferFunction surfaces;
  surfaces.surfaces = {{100, {1, 0, 0}, 1}, {200, {0, 1, 0}, 0}, {300.5, {0, 0, 1}, 0.5}};
  const std::vector<LegendEntry> of_surfaces = legendEntries({"", surfaces, {}, {}}, 14);
  ASSERT_EQ(of_surfaces.size(), 2u);
  EXPECT_EQ(of_surfaces[0].text, "300.5");
  EXPECT_EQ(of_surfaces[1].color, glm::dvec3(1, 0, 0));
  TransferFunction labels;
  for (int i = 0; i < 40; ++i)
    labels.labels.push_back({double(i), i == 1 ? "liver" : "", glm::dvec3(0.5), i > 0 ? 1.0 : 0.0});
  const std::vector<LegendEntry> of_labels = legendEntries({"", labels, {}, {}}, 14);
  ASSERT_EQ(of_labels.size(), 14u);
  EXPECT_EQ(of_labels[0].text, "liver");
  EXPECT_EQ(of_labels[1].text, "2");
  EXPECT_EQ(of_labels.back().text, "+26 more");
  // Labels without voxels are left out.
  const std::vector<LegendEntry> there =
      legendEntries({"", labels, {}, std::vector<double>{0, 1, 7, 50}}, kMostEntries);
  ASSERT_EQ(there.size(), 2u);
  EXPECT_EQ(there[0].text, "liver");
  EXPECT_EQ(there[1].text, "7");
}

// Six digits would give neighbours one text.
TEST(Legend, LargeNumbers_differFromTheirNeighbours) {
  TransferFunction function;
  function.labels = {{8388607, "", glm::dvec3(0.5), 1}, {8388608, "", glm::dvec3(0.2), 1}};
  function.surfaces = {{1234567, {1, 0, 0}, 1}, {1234568, {0, 1, 0}, 1}};
  const std::vector<LegendEntry> entries = legendEntries({"", function, {}, {}}, kMostEntries);
  ASSERT_EQ(entries.size(), 4u);
  EXPECT_EQ(entries[0].text, "1234568");
  EXPECT_EQ(entries[1].text, "1234567");
  EXPECT_EQ(entries[2].text, "8388607");
  EXPECT_EQ(entries[3].text, "8388608");
  function.surfaces = {{1234567, {1, 0, 0}, 1}};
  EXPECT_EQ(legendEntries({"", function, {}, {}}, kMostEntries)[0].text, "1234567");
  function.surfaces = {{0.25, {1, 0, 0}, 1}};
  EXPECT_EQ(legendEntries({"", function, {}, {}}, kMostEntries)[0].text, "0.25");
}

TEST(Legend, RegionsOfAColour_areEntries) {
  TransferFunction function = functionOfTest();
  function.regions.push_back({.values = {0, 300}, .gradients = {0, 40}});
  function.regions.push_back({.values = {200, 900}, .gradients = {20, 80.5}, .color = glm::dvec3(0.1, 0.6, 0.2)});
  const std::vector<LegendEntry> entries = legendEntries({"", function, {}, {}}, kMostEntries);
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_EQ(entries[0].text, "200 to 900, gradient 20 to 80.5");
  EXPECT_EQ(entries[0].color, glm::dvec3(0.1, 0.6, 0.2));
  AnnotatedPicture picture = pictureOf({Projection::kPerspective, {640, 480}});
  picture.shown = {{"volume", function, {}, {}}};
  EXPECT_EQ(legendParts(picture, Style(picture)).size(), 2u);
  // Points whose colours no region leaves have no bar.
  function.regions.front().color = glm::dvec3(1, 0, 0);
  picture.shown = {{"volume", function, {}, {}}};
  EXPECT_EQ(legendParts(picture, Style(picture)).size(), 1u);
}

// Known: squares in the labels' colours, and the colours of both functions at their bars' middle values.
TEST_P(AnnotationsAt, LegendsOfSeveralVolumes_areStacked) {
  AnnotatedPicture picture = pictureOf(GetParam());
  picture.annotations.legend = picture.annotations.scale_bar = true;
  TransferFunction labels, fire = {.points = {{0, {0, 0, 0}, 0}, {9, {1, 0.5, 0}, 1}}};
  labels.labels = {{1, "liver", {0.6, 0.2, 0.1}, 1}, {2, "spleen", {0.1, 0.3, 0.7}, 0.5}, {3, "", {0, 1, 0}, 0}};
  picture.shown = {{"head", functionOfTest(), {}, {}}, {"organs", labels, {}, {}}, {"pet", fire, {}, {}}};
  const Image image = drawn(picture);
  const Style style(picture);
  const std::vector<LegendPart> parts = legendParts(picture, style);
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].title, "head");
  EXPECT_EQ(parts[1].title, "organs");
  EXPECT_EQ(parts[2].title, "pet");
  EXPECT_LT(parts[0].bar.at.y1, parts[1].first_square.y0);
  EXPECT_LT(parts[1].first_square.y1 + 1.5 * style.em, parts[2].bar.at.y0);
  EXPECT_GE(parts[0].bar.at.y0, style.margin);
  EXPECT_LE(parts[2].bar.at.y1, image.height - style.margin);
  for (const int i : {0, 2}) {
    const ColorBar& bar = parts[static_cast<std::size_t>(i)].bar;
    const int row = (bar.at.y0 + bar.at.y1) / 2;
    const glm::dvec3 color = parts[static_cast<std::size_t>(i)].shown->function.at(bar.valueOfRow(row)).color;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.pixel((bar.at.x0 + bar.at.x1) / 2, row)[c], color[c], 1e-6);
  }
  ASSERT_EQ(parts[1].entries.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const PixelRect& square = parts[1].first_square;
    const int row = (square.y0 + square.y1) / 2 + static_cast<int>(std::lround(i * 1.5 * style.em));
    const LabelStyle& label = labels.labels[static_cast<std::size_t>(i)];
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.pixel((square.x0 + square.x1) / 2, row)[c], label.color[c], 1e-6);
  }
}

// Eight volumes with a list of labels each fit into the picture.
TEST_P(AnnotationsAt, LegendsOfManyVolumes_fit) {
  AnnotatedPicture picture = pictureOf(GetParam());
  picture.annotations.legend = true;
  TransferFunction labels;
  for (int i = 1; i < 30; ++i) labels.labels.push_back({double(i), "label", glm::dvec3(0.5), 1});
  picture.shown.clear();
  for (int i = 0; i < 8; ++i) picture.shown.push_back({"volume", i % 2 == 0 ? labels : functionOfTest(), {}, {}});
  const Style style(picture);
  int end = 0;
  for (const LegendPart& part : legendParts(picture, style)) {
    const PixelRect& at = part.entries.empty() ? part.bar.at : part.first_square;
    EXPECT_GT(at.y0, end);
    end = at.y0 + static_cast<int>(part.entries.empty()
                                       ? at.height()
                                       : 1.5 * style.em * static_cast<double>(part.rows) - 0.5 * style.em);
    EXPECT_LE(end, picture.pixels.y1);
  }
}

AnnotatedPicture labelledPicture(const ImageSize& size, int labels) {
  AnnotatedPicture picture = pictureOf({Projection::kOrthographic, size});
  picture.annotations.legend = true;
  TransferFunction function;
  for (int i = 1; i <= labels; ++i)
    function.labels.push_back({double(i), "region " + std::to_string(i), glm::dvec3(0.5), 1});
  picture.shown = {{"labels", function, {}, {}}};
  return picture;
}

// Known by counting: entries are as many as there is room for, and the last one names the rest.
TEST(Legend, OfLabels_usesHeightAndColumns) {
  const auto partOfLabels = [](const ImageSize& size, int labels) {
    const AnnotatedPicture picture = labelledPicture(size, labels);
    return legendParts(picture, Style(picture)).at(0);
  };
  const LegendPart column = partOfLabels({1280, 720}, 20);
  EXPECT_EQ(column.entries.size(), 20u);
  EXPECT_EQ(column.columns.size(), 1u);
  const LegendPart columns = partOfLabels({1280, 720}, 40);
  EXPECT_EQ(columns.entries.size(), 40u);
  EXPECT_EQ(columns.columns.size(), 2u);
  EXPECT_EQ(columns.rows, 20u);
  EXPECT_GT(columns.columns[1], columns.columns[0]);
  EXPECT_LE(columns.width, kMostOfWidth * 1280);
  for (const ImageSize& size : {ImageSize{480, 360}, {1280, 720}, {900, 1400}, {200, 150}}) {
    const LegendPart many = partOfLabels(size, 150);
    const std::size_t named = many.entries.size() - 1;
    EXPECT_GE(named, size.width == 1280 ? 40u : 8u) << size.width;
    EXPECT_EQ(many.entries.back().text, "+" + std::to_string(150 - named) + " more") << size.width;
  }
}

std::vector<Room> roomsOf(const AnnotatedPicture& picture, const Style& style) {
  std::vector<Room> out = {cornerText(picture, style).room, scaleBarRoom(picture, style),
                           directionsRoom(picture, style)};
  for (const LegendPart& part : legendParts(picture, style)) {
    const PixelRect& first = part.entries.empty() ? part.bar.at : part.first_square;
    const double height = part.entries.empty() ? part.bar.at.height() : 1.5 * static_cast<double>(part.rows) * style.em;
    const double above = part.title.empty() ? 0 : 1.4 * style.em;
    const double left = first.x0, top = first.y0;
    out.push_back({left, top - above, left + part.width, top + height});
  }
  return out;
}

// Nothing lies over anything else, and all of it in the picture, whatever is drawn where and how large.
TEST(Places, OfAnnotations_areApart) {
  for (const ImageSize& size : {ImageSize{480, 360}, {200, 150}, {1280, 720}, {300, 900}, {360, 360}}) {
    for (const double factor : {1.0, 2.0}) {
      for (std::size_t place = 0; place <= 6; ++place) {
        for (const bool labels : {false, true}) {
          AnnotatedPicture picture = labelledPicture(size, 30);
          if (!labels) picture.shown = {{"volume", functionOfTest(), {}, {}}};
          Annotations& all = picture.annotations;
          all.size = factor;
          all.scale_bar = all.axes = true;
          all.legend_title = "value";
          all.text = "a volume, 512 × 512 × 245 voxels, and its subject\nframe 7";
          if (place < 6) all.legend_place = static_cast<LegendPlace>(place);
          const Style style(picture);
          const std::vector<Room> rooms = roomsOf(picture, style);
          const std::string where = std::to_string(size.width) + " " + std::to_string(factor) + " " +
                                    std::to_string(place) + (labels ? " labels" : " bar");
          for (std::size_t i = 0; i < rooms.size(); ++i) {
            const Room& a = rooms[i];
            EXPECT_GE(std::min(a.x0, a.y0), 0) << where << " " << i;
            EXPECT_LE(a.x1, size.width) << where << " " << i;
            EXPECT_LE(a.y1, size.height) << where << " " << i;
            for (std::size_t j = 0; j < i; ++j) {
              const Room& b = rooms[j];
              EXPECT_TRUE(a.x0 >= b.x1 - 1 || b.x0 >= a.x1 - 1 || a.y0 >= b.y1 - 1 || b.y0 >= a.y1 - 1)
                  << where << ": " << i << " over " << j;
            }
          }
        }
      }
    }
  }
}

TEST(Places, OfTheLegend_areItsCorners) {
  for (const ImageSize& size : {ImageSize{480, 360}, {300, 600}}) {
    AnnotatedPicture picture = pictureOf({Projection::kOrthographic, size});
    picture.annotations.legend = true;
    const Style style(picture);
    const auto barAt = [&](LegendPlace place) {
      picture.annotations.legend_place = place;
      return legendParts(picture, style).at(0).bar.at;
    };
    const double margin = style.margin;
    for (const LegendPlace left : {LegendPlace::kLeft, LegendPlace::kTopLeft, LegendPlace::kBottomLeft})
      EXPECT_NEAR(barAt(left).x0, margin, 1);
    for (const LegendPlace top : {LegendPlace::kTopLeft, LegendPlace::kTopRight}) EXPECT_NEAR(barAt(top).y0, margin, 1);
    for (const LegendPlace bottom : {LegendPlace::kBottomLeft, LegendPlace::kBottomRight})
      EXPECT_NEAR(barAt(bottom).y1, size.height - margin, 1);
    const PixelRect right = barAt(LegendPlace::kRight);
    EXPECT_NEAR(right.y0 + right.y1, size.height, 1);
    EXPECT_GT(right.x0, size.width / 2);
    // Room that a fitted volume leaves in a tall picture.
    picture.annotations.legend_place.reset();
    EXPECT_EQ(legendParts(picture, style).at(0).bar.at,
              barAt(size.height > size.width ? LegendPlace::kTopRight : LegendPlace::kRight));
  }
}

// Known: the rectangles of the legend, of which a choice of edges holds all; edges leave at least half of the picture.
TEST(LegendEdges, HoldTheLegend) {
  for (const ImageSize& size : {ImageSize{480, 360}, {200, 150}, {1280, 720}, {300, 900}, {360, 360}, {100, 80}}) {
    for (std::size_t place = 0; place <= 6; ++place) {
      for (const int labels : {0, 5, 200}) {
        AnnotatedPicture picture = labelledPicture(size, labels);
        if (labels == 0) picture.shown = {{"volume", functionOfTest(), {}, {}}};
        Annotations& all = picture.annotations;
        all.scale_bar = all.axes = true;
        all.legend_title = "a title of some length";
        all.text = "frame 7";
        if (place < 6) all.legend_place = static_cast<LegendPlace>(place);
        const std::string where =
            std::to_string(size.width) + " " + std::to_string(place) + " " + std::to_string(labels);
        const std::vector<FreeEdges> choices = legendEdges(picture);
        AnnotatedPicture unseen = picture;
        unseen.view = {};
        unseen.view.size = size;
        EXPECT_EQ(legendEdges(unseen), choices) << where << ": a camera has no say";
        ASSERT_FALSE(choices.empty()) << where;
        const std::vector<Room> rooms = roomsOf(picture, Style(picture));
        for (const FreeEdges& edges : choices) {
          const glm::dvec2 left = edges.rectangle(size);
          EXPECT_GE(std::min(left.x / size.width, left.y / size.height), 0.5 - 1e-9) << where;
          if (left.x < 0.5 * size.width + 1e-9) continue;  // too wide a legend
          for (std::size_t i = 3; i < rooms.size(); ++i) {
            const Room& room = rooms[i];
            EXPECT_TRUE(room.x0 > size.width - edges.right || room.x1 < edges.left || room.y1 < edges.top ||
                        room.y0 > size.height - edges.bottom)
                << where << " " << i;
          }
        }
      }
    }
  }
}

TEST(LegendEdges, AreThoseOfALegend) {
  AnnotatedPicture picture = labelledPicture({480, 360}, 5);
  ASSERT_EQ(legendEdges(picture).size(), 1u);
  const double narrow = legendEdges(picture)[0].right;
  EXPECT_GT(narrow, 0);
  picture.annotations.legend_title = "a title that is wider than the list";
  const double titled = legendEdges(picture)[0].right;
  EXPECT_GT(titled, narrow);
  picture.annotations.legend_title += ", wider than a third of the picture, and cut where the picture ends";
  const Style style(picture);
  EXPECT_NEAR(legendEdges(picture)[0].right, kMostOfWidth * 480 + style.margin + kApart * style.em, 1);
  picture.annotations.legend_place = LegendPlace::kBottomLeft;
  const std::vector<FreeEdges> choices = legendEdges(picture);
  ASSERT_EQ(choices.size(), 2u);
  EXPECT_GT(choices[0].left, 0);
  EXPECT_GT(choices[1].bottom, 0);
  picture.annotations.legend = false;
  EXPECT_TRUE(legendEdges(picture).empty());
  picture.annotations.legend = true;
  picture.view.size = {50, 40};
  EXPECT_TRUE(legendEdges(picture).empty()) << "no letters";
}

TEST(Letters, AreLegibleOrAbsent) {
  for (const double factor : {0.5, 1.0}) {
    AnnotatedPicture picture = pictureOf({Projection::kOrthographic, {200, 150}});
    picture.annotations.size = factor;
    EXPECT_EQ(Style(picture).em, kLeastText);
  }
  AnnotatedPicture tiny = pictureOf({Projection::kOrthographic, {48, 40}});
  tiny.annotations.text = "text";
  tiny.annotations.scale_bar = tiny.annotations.axes = tiny.annotations.legend = true;
  const Image image = drawn(tiny);
  EXPECT_EQ(std::ranges::count(image.rgba, 0.0f), static_cast<std::ptrdiff_t>(image.rgba.size()));
}

TEST(Letters, TextsThatAreTooLong_areCut) {
  EXPECT_EQ(cutToWidth("short", 10, 1000), "short");
  const std::string text = "Grüße aus dem Bauch";
  for (const double width : {20.0, 40.0, 70.0}) {
    const std::string cut = cutToWidth(text, 10, width);
    EXPECT_TRUE(cut.ends_with("…")) << cut;
    EXPECT_TRUE(text.starts_with(cut.substr(0, cut.size() - std::string("…").size()))) << cut;
    EXPECT_LE(lineOf(cut, 10).width, width);
    EXPECT_GT(lineOf(cut, 10).width, width - 12);
  }
}

TEST(ScaleBar, OfAGivenLength_hasThisLength) {
  AnnotatedPicture picture = pictureOf({Projection::kOrthographic, {480, 360}});
  picture.annotations.scale_bar = true;
  picture.annotations.scale_bar_length = 12.5;
  const ScaleBar bar = scaleBarOf(picture);
  EXPECT_EQ(bar.label, "12.5 µm");
  EXPECT_NEAR(bar.length_px, 12.5 * 360 / 110, 1e-9);  // the picture is 110 high
  EXPECT_FALSE(scaleBarRoom(picture, Style(picture)).empty());
  picture.annotations.scale_bar_length = 500;
  EXPECT_TRUE(scaleBarRoom(picture, Style(picture)).empty());
  picture.annotations.scale_bar_length = 1234567;
  EXPECT_EQ(scaleBarOf(picture).label, "1234567 µm");
}

TEST(RoundNumbers, TextsAndTicks) {
  EXPECT_EQ(roundNumberBelow(1), 1);
  EXPECT_EQ(roundNumberBelow(4.99), 2);
  EXPECT_EQ(roundNumberBelow(0.0501), 0.05);
  EXPECT_EQ(roundNumberBelow(1e5), 1e5);
  EXPECT_EQ(textOfNumber(0.05, 0.05), "0.05");
  EXPECT_EQ(textOfNumber(-200, 100), "−200");
  EXPECT_EQ(textOfNumber(0, 0.5), "0.0");
  EXPECT_EQ(textOfNumber(2e9, 1e9), "2e+09");
  EXPECT_EQ(textOfNumber(2100000, 100000), "2.1e+06");
  EXPECT_EQ(textOfNumber(4194306, 2), "4194306");
  EXPECT_EQ(textOfNumber(1000000.5, 0.5), "1000000.5");
  EXPECT_EQ(roundTicks(0x1p60, 0x1p60 + 1024, 7).size(), 5u) << "six multiples of 200, two of them one double";
  EXPECT_LE(roundTicks(0x1p62, 0x1p62 + 1024, 7).size(), 2u) << "doubles are 1024 apart";
  EXPECT_EQ(roundTicks(-0.1, 1.1, 7), (std::vector<double>{0, 0.2, 0.4, 0.6, 0.8, 1}));
  EXPECT_EQ(roundTicks(3, 3, 7), std::vector<double>{3});
  for (double lo = -3; lo < 3; lo += 0.37) {
    for (double span = 0.001; span < 1e5; span *= 3.7) {
      const std::vector<double> ticks = roundTicks(lo, lo + span, 7);
      EXPECT_GE(ticks.size(), 2u) << lo << " " << span;
      EXPECT_LE(ticks.size(), 7u) << lo << " " << span;
    }
  }
}

// Known: the area of an outline, and that overlapping parts count once.
TEST(Coverage, Areas_areExactToALine) {
  const auto areaOf = [](const Outline& outline) {
    const Coverage coverage(outline);
    double out = 0;
    for (int row = 0; row < 60; ++row) {
      std::vector<std::int32_t> sums(60);
      coverage.addRow(row, 0, sums);
      for (const std::int32_t sum : sums) {
        EXPECT_LE(sum, Coverage::kFull);
        out += static_cast<double>(sum) / Coverage::kFull;
      }
    }
    return out;
  };
  EXPECT_NEAR(areaOf({rectangle({10.25, 5.5}, {30.75, 20.5})}), 20.5 * 15, 1e-9);
  EXPECT_NEAR(areaOf({disc({30, 30}, 20, 64)}), 0.5 * 64 * 400 * std::sin(2 * 3.14159265358979 / 64), 0.5);
  EXPECT_NEAR(areaOf({rectangle({0, 0}, {20, 20}), rectangle({10, 10}, {30, 30})}), 700, 1e-9);
  EXPECT_NEAR(areaOf(stroke({5, 5}, {35, 45}, 4)), 200, 0.5);
  EXPECT_NEAR(areaOf({rectangle({-500, 10}, {500, 20})}), 600, 1e-9);
}

}  // namespace
}  // namespace kiln
