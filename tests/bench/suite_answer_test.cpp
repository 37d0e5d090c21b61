// Known answers: each key of a suite is read back, and each error names its place. The paper's printed ratios and
// speed-ups are quotients of its printed numbers, up to the rounding of both.
#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "bench/published.h"
#include "bench/suite.h"
#include "bench/views.h"
#include "grid/geometry.h"
#include "support/system/expect_error.h"

namespace kiln {
namespace {

constexpr const char* kSmallest = R"({"kiln_suite": 1, "cases": [{"name": "A", "volume": "a.nrrd"}]})";

TEST(BenchSuite, TheSmallestSuiteAsksForThePapersExperiment) {
  const Suite suite = parseSuite(kSmallest, "some/suite.json");
  ASSERT_EQ(suite.cases.size(), 1u);
  EXPECT_EQ(suite.cases[0].volume, "some/a.nrrd");
  EXPECT_EQ(suite.methods.size(), 5u);
  EXPECT_EQ(suite.methods.front(), VisibilityMethod::kNone);
  EXPECT_EQ(suite.projections.size(), 2u);
  EXPECT_EQ(suite.threshold, 0.95);
  EXPECT_EQ(suite.fov_deg, 60);
  EXPECT_EQ(suite.threads, 1u);
  EXPECT_EQ(suite.tile_px, 0);
  EXPECT_EQ(suite.area, ProjectedArea::kSphere);
  EXPECT_FALSE(suite.test_samples);
  EXPECT_EQ(suite.text, kSmallest);
}

TEST(BenchSuite, EveryKeyIsRead) {
  const Suite suite = parseSuite(R"({
    "kiln_suite": 1, "title": "T", "methods": ["none", "mask"], "projections": ["perspective"], "fov": 45,
    "threshold": 0.9, "views": 7, "turn_deg": 30, "repeat": 2, "threads": 3, "tile_px": 128, "area": "box",
    "test_samples": true, "memory": "1G", "epsilon_px": [0, 5], "cost": {"sizes": [128], "areas": [4, 9]},
    "scaling": {"volumes": ["phantom:body:8x8x16", "b.kiln"], "size": [30, 20], "transferFunction": "fog",
                "camera": {"azimuth": 5}, "repeat": 4},
    "cases": [
      {"name": "A", "classification": "bone", "volume": "phantom:head:8x9x10", "note": "n", "paper": "HEAD",
       "transferFunction": "ct-bone", "camera": {"azimuth": 10, "zoom": 2}, "sizes": [[10, 20], [30, 40]],
       "node_slice": {"axis": "z", "index": 3}, "artifacts": true, "quick": false, "repeat": 9},
      {"name": "B", "volume": "/b.kiln"}]})",
                                 "dir/suite.json");
  EXPECT_EQ(suite.title, "T");
  EXPECT_EQ(suite.methods, (std::vector{VisibilityMethod::kNone, VisibilityMethod::kMask}));
  EXPECT_EQ(suite.projections, std::vector{Projection::kPerspective});
  EXPECT_EQ(suite.fov_deg, 45);
  EXPECT_EQ(suite.threshold, 0.9);
  EXPECT_EQ(suite.views, 7);
  EXPECT_EQ(suite.turn_deg, 30);
  EXPECT_EQ(suite.threads, 3u);
  EXPECT_EQ(suite.tile_px, 128);
  EXPECT_EQ(suite.area, ProjectedArea::kBox);
  EXPECT_TRUE(suite.test_samples);
  EXPECT_EQ(suite.memory_bytes, 1ull << 30);
  EXPECT_EQ(suite.epsilons_px, (std::vector{0, 5}));
  EXPECT_EQ(suite.cost.sizes_px, std::vector{128});
  EXPECT_EQ(suite.cost.areas_px, (std::vector{4, 9}));
  EXPECT_EQ(suite.scaling.volumes, (std::vector<std::string>{"phantom:body:8x8x16", "dir/b.kiln"}));
  EXPECT_EQ(suite.scaling.size.width, 30);
  EXPECT_EQ(suite.scaling.size.height, 20);
  EXPECT_EQ(std::get<std::string>(suite.scaling.transfer_function), "fog");
  EXPECT_EQ(suite.scaling.camera.azimuth_deg, 5);
  EXPECT_EQ(suite.scaling.repeat, 4);
  const SuiteCase& a = suite.cases[0];
  EXPECT_EQ(a.volume, "phantom:head:8x9x10");  // no file, so no folder is prepended
  EXPECT_EQ(a.classification, "bone");
  EXPECT_EQ(a.note, "n");
  EXPECT_EQ(a.paper, "HEAD");
  EXPECT_EQ(std::get<std::string>(a.transfer_function), "ct-bone");
  EXPECT_EQ(a.camera.azimuth_deg, 10);
  ASSERT_EQ(a.sizes.size(), 2u);
  EXPECT_EQ(a.sizes[1].height, 40);
  ASSERT_TRUE(a.node_slice);
  EXPECT_EQ(a.node_slice->axis, 2);
  EXPECT_EQ(a.node_slice->index, 3);
  EXPECT_TRUE(a.artifacts);
  EXPECT_FALSE(a.quick);
  EXPECT_EQ(a.repeat, 9);
  EXPECT_EQ(suite.cases[1].repeat, 2);
  EXPECT_EQ(suite.cases[1].volume, "/b.kiln");
}

struct Wrong {
  const char* suite;
  const char* message;
};

// A case's keys are reported in cases[0], the suite's keys before.
const Wrong kWrong[] = {
    {R"("vews": 3, "cases": [{"name": "A", "volume": "a"}])", "vews: unknown key; did you mean 'views'?"},
    {R"("cases": [])", "cases: expected a list of at least one case"},
    {R"("title": "no cases")", "cases"},
    {R"("cases": [{"volume": "a"}])", "cases[0].name: is missing"},
    {R"("cases": [{"name": "A"}])", "cases[0].volume: is missing"},
    {R"("cases": [{"name": "A", "volume": "a", "size": [[1, 1]]}])", "did you mean 'sizes'?"},
    {R"("cases": [{"name": "A", "volume": "a"}, {"name": "A", "volume": "b"}])", "another case has this name"},
    {R"("cases": [{"name": "A", "volume": "a", "paper": "HAED"}])", "did you mean 'HEAD'?"},
    {R"("cases": [{"name": "A", "volume": "a", "sizes": [[0, 8]]}])", "cases[0].sizes: expected a list of [width"},
    {R"("cases": [{"name": "A", "volume": "a", "sizes": []}])", "cases[0].sizes"},
    {R"("cases": [{"name": "A", "volume": "a", "sizes": [[8, 8.5]]}])", "cases[0].sizes"},
    {R"("cases": [{"name": "A", "volume": "a", "sizes": [8, 8]}])", "cases[0].sizes"},
    {R"("cases": [{"name": "A", "volume": "a", "camera": {"projection": "perspective"}}])", "camera.projection"},
    {R"("cases": [{"name": "A", "volume": "a", "transferFunction": "ct-bones"}])", "did you mean 'ct-bone'?"},
    {R"("cases": [{"name": "A", "volume": "a", "node_slice": {"axis": "w"}}])", "cases[0].node_slice.axis"},
    {R"("cases": [{"name": "A", "volume": "a", "artifacts": 1}])", "cases[0].artifacts: expected true or false"},
    {R"("methods": ["mask"], "cases": [{"name": "A", "volume": "a"}])", "methods: must begin with \"none\""},
    {R"("methods": ["none", "none"], "cases": [{"name": "A", "volume": "a"}])", "none of them twice"},
    {R"("methods": ["none", "magic"], "cases": [{"name": "A", "volume": "a"}])", "methods: expected a list of"},
    {R"("projections": [], "cases": [{"name": "A", "volume": "a"}])", "projections"},
    {R"("views": 0, "cases": [{"name": "A", "volume": "a"}])", "views: expected a whole number from 1"},
    {R"("threshold": 0, "cases": [{"name": "A", "volume": "a"}])", "threshold"},
    {R"("scaling": {"volumes": ["a"]}, "cases": [{"name": "A", "volume": "a"}])",
     "scaling.volumes: expected a list of at"},
    {R"("tile_px": 96, "cases": [{"name": "A", "volume": "a"}])", "tile_px: expected 0, the whole image"},
    {R"("epsilon_px": [1, 2], "cases": [{"name": "A", "volume": "a"}])", "epsilon_px"},
    {R"("epsilon_px": [0, 3, 2], "cases": [{"name": "A", "volume": "a"}])", "epsilon_px"},
    {R"("epsilon_px": [0, 0.5], "cases": [{"name": "A", "volume": "a"}])", "epsilon_px"},
    {R"("cost": {"sizes": [16]}, "cases": [{"name": "A", "volume": "a"}])", "cost.sizes"},
    {R"("memory": "lots", "cases": [{"name": "A", "volume": "a"}])", "memory"},
};

TEST(BenchSuite, EachMistakeNamesItsKey) {
  for (const Wrong& wrong : kWrong) {
    test::expectError([&] { parseSuite(std::string(R"({"kiln_suite": 1, )") + wrong.suite + "}", "suite.json"); },
                      ErrorCode::kUsage, wrong.message);
  }
  EXPECT_THROW(parseSuite(R"({"cases": [{"name": "A", "volume": "a"}]})", "suite.json"), Error);
  EXPECT_THROW(parseSuite(R"({"kiln_suite": 2, "cases": [{"name": "A", "volume": "a"}]})", "suite.json"), Error);
}

TEST(BenchSuite, AQuickRunLeavesOutWhatSaysSo) {
  Suite suite = parseSuite(
      R"({"kiln_suite": 1, "cases": [{"name": "A", "volume": "a", "sizes": [[8, 8], [9, 9]]},
                                     {"name": "B", "volume": "b", "quick": false}]})",
      "suite.json");
  const Suite quick = quickened(suite);
  ASSERT_EQ(quick.cases.size(), 1u);
  EXPECT_EQ(quick.cases[0].sizes.size(), 1u);
  EXPECT_EQ(quick.cases[0].repeat, 1);
  EXPECT_EQ(quick.views, 2);
  suite.cases.erase(suite.cases.begin());
  EXPECT_THROW(quickened(suite), Error);
}

// The eye keeps its distance and its height, and the first and the last view are turn_deg apart.
TEST(BenchSuite, ViewsTurnAboutTheUpAxis) {
  Suite suite = parseSuite(kSmallest, "suite.json");
  suite.views = 3;
  suite.turn_deg = 50;
  VolumeGeometry volume;
  volume.dims = {40, 50, 60};
  const glm::dvec3 centre(19.5, 24.5, 29.5);
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    const std::vector<SuiteView> views = suiteViews(suite, suite.cases[0], volume, {64, 64}, projection);
    ASSERT_EQ(views.size(), 3u);
    EXPECT_DOUBLE_EQ(views[0].turn_deg, -25);
    EXPECT_DOUBLE_EQ(views[middleView(suite)].turn_deg, 0);
    const glm::dvec3 a = views[0].view.eye_world - centre, b = views[2].view.eye_world - centre;
    EXPECT_NEAR(a.x * a.x + a.y * a.y, b.x * b.x + b.y * b.y, 1e-6);
    EXPECT_NEAR(a.z, b.z, 1e-9);
    const double cosine = (a.x * b.x + a.y * b.y) / (a.x * a.x + a.y * a.y);
    EXPECT_NEAR(std::acos(cosine) * 180 / 3.14159265358979, 50, 1e-6);
    EXPECT_DOUBLE_EQ(views[0].view.focal_px, views[2].view.focal_px);
  }
}

// Half a unit of the last printed digit on either side.
TEST(Published, RatiosAndSpeedUpsFollowFromTheNumbers) {
  std::size_t checked = 0;
  for (const PublishedRow& row : publishedRows()) {
    for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
      for (const VisibilityMethod method :
           {VisibilityMethod::kRangeTree, VisibilityMethod::kQuadtree, VisibilityMethod::kOverlay}) {
        const auto visits = publishedVisits(row.name, row.size, projection, method);
        const auto times = publishedTimes(row.name, row.size, projection, method);
        ASSERT_EQ(visits.has_value(), times.has_value());
        if (!visits) continue;
        ++checked;
        SCOPED_TRACE(std::string(row.name) + " " + std::to_string(row.size.width) + " " +
                     std::to_string(static_cast<int>(projection)) + " " + std::to_string(static_cast<int>(method)));
        const double ratio = 100 * static_cast<double>(visits->visited) / static_cast<double>(visits->octree_only);
        EXPECT_NEAR(visits->ratio_percent, ratio, 0.0051);
        const double least = (times->octree_only_s - 0.005) / (times->method_s + 0.005);
        const double most = (times->octree_only_s + 0.005) / (times->method_s - 0.005);
        EXPECT_GE(times->speed_up, least - 0.005);
        EXPECT_LE(times->speed_up, most + 0.005);
      }
    }
  }
  // 12 rows by range tree and quadtree, 8 by overlay, in two projections.
  EXPECT_EQ(checked, 2u * (2 * 12 + 8));
}

TEST(Published, WhatThePaperDoesNotHaveIsEmpty) {
  EXPECT_EQ(publishedNames().size(), 7u);
  EXPECT_FALSE(publishedVisits("HEAD", {640, 480}, Projection::kOrthographic, VisibilityMethod::kRangeTree));
  EXPECT_FALSE(publishedVisits("HEAD", {256, 256}, Projection::kOrthographic, VisibilityMethod::kMask));
  EXPECT_FALSE(publishedTimes("VM2SKIN", {340, 1024}, Projection::kPerspective, VisibilityMethod::kOverlay));
  EXPECT_FALSE(publishedData(""));
  EXPECT_EQ(publishedData("VM2SKIN")->size, "587×341×1878");
}

}  // namespace
}  // namespace kiln
