// Opacity over values and gradients, against the reference renderer, and against functions of values alone.
// Known because the reference renderer evaluates the function at each sample without a grid, and a table whose rows are
// equal is a function of values.
#include <gtest/gtest.h>

#include <cmath>

#include "image/compare.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr int kPlanePixels = 64;

// Waves: many values with many gradients each.
DenseVolume waves() {
  return fill({{40, 36, 44}, VoxelType::u8, anisotropicAffine()}, [](auto x, auto y, auto z) {
    return 110 + 50 * std::sin(0.35 * static_cast<double>(x)) + 40 * std::cos(0.2 * static_cast<double>(y + z));
  });
}

class GradientPlane : public ::testing::Test {
 protected:
  GradientPlane() : volume_(waves()), store_(makeStore(volume_, "plane_waves", 16)) {
    request_.view =
        resolve(cameraFrom(volume_.geometry, {0.5, -1, 0.3}, Projection::kPerspective), {kPlanePixels, kPlanePixels});
    request_.level = 0;
    request_.opacity_threshold = 0.9999;
    request_.sample_distance = 0.25;
    request_.transfer_function = {1, {{0, {0.9, 0.6, 0.3}, 0}, {60, {0.9, 0.4, 0.2}, 0.1}, {220, {0.3, 0.6, 1}, 0.3}}};
  }
  void expectReference(double least_psnr_db) {
    const Image drawn = draw(store_, request_);
    const Image judged = referenceImage(volume_, request_.view, request_.transfer_function, request_.shading, {},
                                        {2, 0.25, 0.9999, true, {}});
    const double psnr = compareImages(judged, drawn).foreground_psnr_db;
    RecordProperty("psnr_db", std::to_string(psnr));
    EXPECT_GT(psnr, least_psnr_db);
    EXPECT_TRUE(showsSomething(drawn));
    request_.transfer_function.gradient_opacity.clear();
    request_.transfer_function.regions.clear();
    request_.transfer_function.table = {};
    EXPECT_LT(compareImages(draw(store_, request_), drawn).foreground_psnr_db, 28) << "shows all gradients";
  }

  DenseVolume volume_;
  std::filesystem::path store_;
  FrameRequest request_;
};

constexpr double kGoodPsnr = 36;

TEST_F(GradientPlane, OfPoints_isTheReference) {
  request_.transfer_function.gradient_opacity = {{4, 0}, {9, 0.2}, {12, 1}, {25, 0.5}};
  expectReference(kGoodPsnr);
}

TEST_F(GradientPlane, OfRectangles_isTheReference) {
  GradientRegion low, high;
  low.values = {40, 110}, low.gradients = {6, 30}, low.color = glm::dvec3(0.1, 0.8, 0.2);
  high.values = {90, 210}, high.gradients = {0, 12}, high.opacity = 0.4;
  request_.transfer_function.regions = {low, high};
  expectReference(kGoodPsnr);
}

TEST_F(GradientPlane, OfATriangle_isTheReference) {
  GradientRegion boundary;
  boundary.shape = RegionShape::kTriangle;
  boundary.values = {60, 180}, boundary.gradients = {2, 22}, boundary.softness = 0.5;
  request_.transfer_function.regions = {boundary};
  expectReference(kGoodPsnr);
}

TEST_F(GradientPlane, OfATable_isTheReference) {
  request_.transfer_function.table = {{30, 200}, {3, 24}, 4, 3, {0, 1, 0, 0.2f, 0.4f, 0, 1, 0, 1, 0.5f, 0, 0.8f}};
  expectReference(kGoodPsnr);
}

TEST_F(GradientPlane, OnTheVoxelLattice_isTheReference) {
  request_.lattice = Lattice::kVoxel;
  request_.sample_distance = FrameRequest().sample_distance;
  GradientRegion low;
  low.values = {40, 140}, low.gradients = {6, 30}, low.color = glm::dvec3(0.1, 0.8, 0.2);
  request_.transfer_function.regions = {low};
  expectReference(25);
}

// All values have opacity 1, and a table with equal rows has the opacity of the function.
TEST_F(GradientPlane, OfEqualRows_isTheFunctionOfValues) {
  const TransferFunction by_value = request_.transfer_function;
  const Image expected = draw(store_, request_);
  TransferFunction& function = request_.transfer_function;
  GradientTable& table = function.table;
  table = {{0, 255}, {0, 100}, 256, 2, {}};
  for (int row = 0; row < table.rows; ++row) {
    for (int value = 0; value < table.columns; ++value)
      table.opacity.push_back(static_cast<float>(by_value.at(value).opacity));
  }
  for (TransferPoint& point : function.points) point.opacity = 1;
  EXPECT_LT(compareImages(draw(store_, request_), expected).largest, 1.0 / 510);
  GradientRegion all;
  all.values = {-1, 300}, all.gradients = {0, 1000}, all.softness = 0;
  function = by_value;
  function.regions = {all};
  // With opacity by gradient, no sample represents two slabs.
  EXPECT_LT(compareImages(draw(store_, request_), expected).largest, 1e-2);
}

// Bricks whose values no gradient shows are not read.
TEST(GradientPlaneCulling, IsThatOfTheShownValues) {
  const DenseVolume halves =
      fill({{64, 32, 32}, VoxelType::u8}, [](auto x, auto, auto z) { return x < 32 ? 50 + (z & 3) : 200 + (z & 3); });
  const auto store = makeStore(halves, "plane_halves", 16);
  FrameRequest request;
  request.view = resolve(cameraFrom(halves.geometry, {0.2, -1, 0.3}, Projection::kOrthographic), {64, 64});
  request.level = 0;
  const auto bricksOf = [&](const TransferFunction& function) {
    request.transfer_function = function;
    FrameStatistics statistics;
    draw(store, request, 1ull << 30, &statistics);
    return statistics.bricks_interesting;
  };
  const TransferFunction all{1, {{0, glm::dvec3(1), 0.1}}};
  TransferFunction plane = all;
  GradientRegion bright;
  bright.values = {150, 250}, bright.gradients = {0, 100};
  plane.regions = {bright};
  const std::uint64_t shown = bricksOf(plane);
  EXPECT_LT(shown, bricksOf(all));
  EXPECT_EQ(shown, bricksOf({1, {{149, glm::dvec3(1), 0}, {151, glm::dvec3(1), 0.1}}}));
}

}  // namespace
}  // namespace kiln::test
