// Slices along any plane. Known: the voxels' values are linear in the world, which trilinear interpolation keeps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "frame/plane_slice.h"
#include "image/srgb.h"
#include "store/store_reader.h"
#include "support/system/expect_error.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr double kWindow = 400;  // values 0 to 400
constexpr glm::dvec3 kSlope(3, 2, 5);

double valueAt(const glm::dvec3& world) { return glm::dot(kSlope, world) + 20; }

// Voxels of 1 x 1 x 1.5, the first at 2,-1,4. The values are not whole numbers.
DenseVolume sloped() {
  const glm::dmat4 place = spacingAffine({1, 1, 1.5}, {2, -1, 4});
  return fill({{33, 27, 21}, VoxelType::f32, place}, [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    return valueAt(glm::dvec3(place * glm::dvec4(i, j, k, 1)));
  });
}

class PlaneSlice : public ::testing::Test {
 protected:
  PlaneSlice() : store_(makeStore(sloped(), "plane_slice", 8)) {}

  static PlaneSliceRequest requestOf(const glm::dvec3& normal, double offset, double thickness = 0,
                                     const char* statistic = "average") {
    PlaneSliceRequest out;
    out.normal = normal;
    out.offset = offset;
    out.thickness = thickness;
    out.statistic = statistic;
    out.window = Window{kWindow / 2, kWindow};
    return out;
  }
  const VolumeGeometry& level() const { return store_.level(0).geometry; }
  Image draw(const PlaneSliceRequest& request) const {
    Progress progress;
    return renderPlaneSlice(store_, request, progress);
  }
  // True if a place lies between the centres of the outermost voxels.
  bool isInside(const glm::dvec3& at) const {
    return at.x >= 2 && at.x <= 34 && at.y >= -1 && at.y <= 25 && at.z >= 4 && at.z <= 34;
  }
  // Expects the value at each pixel whose samples lie within the volume, plus `more`. Returns the number of such
  // pixels.
  int expectValues(const PlaneSliceRequest& request, double more = 0) const {
    const Image image = draw(request);
    const PlanePixels pixels = pixelsOfPlane(level(), request);
    EXPECT_EQ(image.width, pixels.width);
    EXPECT_EQ(image.height, pixels.height);
    int compared = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const glm::dvec3 at = pixels.at(x, y), half = 0.5 * request.thickness * glm::normalize(request.normal);
        if (!isInside(at - half) || !isInside(at + half)) continue;
        ++compared;
        EXPECT_EQ(image.pixel(x, y)[3], 1);
        EXPECT_NEAR(srgbFromLinear(image.pixel(x, y)[0]), (valueAt(at) + more) / kWindow, 1.0 / 1024) << x << " " << y;
      }
    }
    return compared;
  }

  StoreReader store_;
};

TEST_F(PlaneSlice, Oblique_hasTheValuesOfItsPlaces) {
  EXPECT_GT(expectValues(requestOf({1, 2, 3}, -80)), 500);
  EXPECT_GT(expectValues(requestOf({-0.3, 0.1, 0.02}, 5)), 500);
  const PlaneSliceRequest request = requestOf({1, 2, 3}, -80);
  const PlanePixels pixels = pixelsOfPlane(level(), request);
  for (const double x : {0.0, 7.0}) EXPECT_NEAR(glm::dot(request.normal, pixels.at(x, 3)), 80, 1e-9);
  EXPECT_DOUBLE_EQ(glm::length(pixels.right), 1);
  EXPECT_LT(pixels.down.z, 0) << "z is up";
}

TEST_F(PlaneSlice, ThickSlice_hasItsMeanAndItsEnds) {
  const glm::dvec3 normal(2, 1, 2);
  const double end = 4 * glm::dot(kSlope, normal) / 3;
  EXPECT_GT(expectValues(requestOf(normal, -60, 8)), 100);
  EXPECT_GT(expectValues(requestOf(normal, -60, 8, "mip"), end), 100);
  EXPECT_GT(expectValues(requestOf(normal, -60, 8, "minip"), -end), 100);
}

// A sheet of 200 in a volume of 0, in the middle of slices of any thickness.
TEST_F(PlaneSlice, ThickSlice_hasThePeakBetweenItsSamples) {
  const DenseVolume sheet = fill({{32, 32, 32}, VoxelType::u8}, [](auto, auto j, auto) { return j == 16 ? 200 : 0; });
  const StoreReader store(makeStore(sheet, "sheet_slice", 8));
  Progress progress;
  for (const double thickness : {0.3, 1.0, 2.0, 3.0, 4.0}) {
    PlaneSliceRequest request = requestOf({0, 1, 0}, -16.1, thickness, "mip");
    request.window = Window{100, 200};
    const Image greatest = renderPlaneSlice(store, request, progress);
    request.statistic = "minip";
    const Image least = renderPlaneSlice(store, request, progress);
    const double from_sheet = 0.5 * thickness + 0.1;
    for (int i = 0; i < 32; ++i) {
      EXPECT_NEAR(srgbFromLinear(greatest.pixel(i, 31 - i)[0]), 1, 1e-3) << thickness;
      EXPECT_NEAR(srgbFromLinear(least.pixel(i, 31 - i)[0]), std::max(1 - from_sheet, 0.0), 1e-3) << thickness;
    }
  }
}

// Holes and infinities in a volume of noise, in small bricks and in one.
TEST_F(PlaneSlice, ThickExtrema_areTheSameForAllBricks) {
  const DenseVolume volume = fill({{30, 31, 29}, VoxelType::f32}, [](auto i, auto j, auto k) {
    if (i == 15 && j == 12 && k % 4 == 0) return k % 8 == 0 ? HUGE_VAL : -HUGE_VAL;
    if ((i + 2 * j + 3 * k) % 23 == 0) return double{NAN};
    return 200 * hashUnit(9, static_cast<std::uint64_t>((k * 31 + j) * 30 + i));
  });
  const StoreReader small(makeStore(volume, "slice_of_8", 8)), large(makeStore(volume, "slice_of_64", 64));
  Progress progress;
  for (const char* const mode : {"mip", "minip"}) {
    for (const auto& [normal, offset] : {std::pair(glm::dvec3(1, 2, 3), -80.0), {glm::dvec3(1, 1, 0), -28}}) {
      PlaneSliceRequest request = requestOf(normal, offset, 5, mode);
      request.window = Window{100, 200};
      const Image image = renderPlaneSlice(large, request, progress);
      EXPECT_TRUE(showsSomething(image));
      EXPECT_TRUE(equalBits(image, renderPlaneSlice(small, request, progress))) << mode;
    }
  }
  // A slice through a voxel of infinity shows the window's end.
  PlaneSliceRequest request = requestOf({0, 0, 1}, -8, 1, "mip");
  request.window = Window{100, 200};
  const PlanePixels pixels = pixelsOfPlane(large.level(0).geometry, request);
  const Image image = renderPlaneSlice(large, request, progress);
  int infinite = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const glm::dvec3 at = pixels.at(x, y);
      if (std::abs(at.x - 15) > 0.5 || std::abs(at.y - 12) > 0.5) continue;
      ++infinite;
      EXPECT_EQ(image.pixel(x, y)[0], 1) << x << ' ' << y;
      EXPECT_EQ(image.pixel(x, y)[3], 1);
    }
  }
  EXPECT_GT(infinite, 0);
}

TEST_F(PlaneSlice, PixelsOfAnySize_haveTheValuesOfTheirPlaces) {
  for (const double pixel : {0.37, 2.5}) {
    PlaneSliceRequest request = requestOf({1, 2, 3}, -80, 4);
    const PlanePixels of_voxels = pixelsOfPlane(level(), request);
    request.pixel = pixel;
    const PlanePixels pixels = pixelsOfPlane(level(), request);
    EXPECT_NEAR(static_cast<double>(pixels.width), static_cast<double>(of_voxels.width) / pixel, 2);
    EXPECT_EQ(pixels.samples, of_voxels.samples);
    EXPECT_GT(expectValues(request), 300 / (pixel * pixel)) << pixel;
  }
  PlaneSliceRequest request = requestOf({1, 2, 3}, -80);
  for (const double pixel : {0.0, -1.0, 1e-7, HUGE_VAL}) {
    request.pixel = pixel;
    EXPECT_THROW(pixelsOfPlane(level(), request), Error) << pixel;
  }
}

TEST_F(PlaneSlice, AlongAnAxis_isTheSliceOfThatAxis) {
  for (const int axis : {1, 2}) {  // rows of x; a slice along x is seen from the other side
    glm::dvec3 normal(0);
    normal[axis] = 1;
    SliceRequest slice;
    slice.axis = axis;
    slice.index = 6;
    slice.window = Window{kWindow / 2, kWindow};
    const double at = axis == 1 ? 5 : 13;
    const Image image = draw(requestOf(normal, -at));
    Progress progress;
    const Image expected = renderSlice(store_, slice, progress);
    ASSERT_EQ(image.width, expected.width) << axis;
    if (axis == 1) {
      // Rows are a pixel high and voxels 1.5: the place between voxels is interpolated.
      EXPECT_GT(expectValues(requestOf(normal, -at)), 800);
      continue;
    }
    ASSERT_EQ(image.height, expected.height);
    EXPECT_EQ(image.rgba, expected.rgba);
  }
}

// Radiology's sides: a tilted axial slice has the front at the top and the right at the left, whichever way the tilt.
TEST_F(PlaneSlice, TiltedAxialSlices_areNotTurnedRound) {
  const PatientAxes axes = patientAxes(level().frame);
  for (const double degrees : {-44.0, -30.0, -5.0, -0.5, 0.0, 0.5, 5.0, 30.0, 44.0}) {
    const double sine = std::sin(glm::radians(degrees)), cosine = std::cos(glm::radians(degrees));
    for (const glm::dvec3& normal : {glm::dvec3(0, sine, cosine), glm::dvec3(sine, 0, cosine)}) {
      const PlanePixels pixels = pixelsOfPlane(level(), requestOf(normal, -glm::dot(normal, glm::dvec3(12, 9, 12))));
      EXPECT_LT(glm::dot(pixels.down, axes.anterior), -0.7) << degrees;
      EXPECT_GT(glm::dot(pixels.right, axes.left), 0.7) << degrees;
    }
    const PlanePixels upright = pixelsOfPlane(level(), requestOf({0, cosine, sine}, -9 * cosine - 12 * sine));
    EXPECT_LT(upright.down.z, -0.7) << degrees;
  }
}

TEST_F(PlaneSlice, OutsideTheVolume_isTransparent) {
  const Image image = draw(requestOf({1, 1, 0}, -30));
  const PlanePixels pixels = pixelsOfPlane(level(), requestOf({1, 1, 0}, -30));
  for (int x = 0; x < image.width; ++x) {
    const glm::dvec3 at = pixels.at(x, 0);
    const bool in_volume = at.x > 1.5 && at.x < 34.5 && at.y > -1.5 && at.y < 25.5 && at.z > 3.25 && at.z < 34.75;
    EXPECT_EQ(image.pixel(x, 0)[3], in_volume ? 1 : 0) << x;
  }
}

// The store lacks all files but those of one layer of bricks: reading another brick fails.
TEST_F(PlaneSlice, BricksBesideThePlane_areNotRead) {
  const std::filesystem::path path = makeStore(sloped(), "plane_slice_of_one_layer", 8);
  for (const auto& file : std::filesystem::directory_iterator(path / "bricks/0")) {
    if (!file.path().filename().string().ends_with("_0.vdb")) std::filesystem::remove(file.path());
  }
  const StoreReader other(path);
  Progress progress;
  EXPECT_EQ(renderPlaneSlice(other, requestOf({0, 0, 1}, -13), progress).rgba, draw(requestOf({0, 0, 1}, -13)).rgba);
  expectError([&] { renderPlaneSlice(other, requestOf({0, 0, 1}, -25), progress); }, ErrorCode::kNotFound, "");
}

TEST_F(PlaneSlice, SizeOfBricks_changesNoPixel) {
  const PlaneSliceRequest request = requestOf({1, -2, 1.5}, 10, 5, "mip");
  const StoreReader other(makeStore(sloped(), "plane_slice_32", 32));
  Progress progress;
  EXPECT_EQ(draw(request).rgba, renderPlaneSlice(other, request, progress).rgba);
}

TEST_F(PlaneSlice, WrongRequests_nameTheOption) {
  const auto expectRefused = [&](const PlaneSliceRequest& request, ErrorCode code, const std::string& part) {
    expectError([&] { draw(request); }, code, part);
  };
  expectRefused(requestOf({0, 0, 0}, 1), ErrorCode::kUsage, "--plane: expected a normal");
  expectRefused(requestOf({0, 0, 2}, -100), ErrorCode::kUsage, "offset between -69.5 and -6.5");
  expectRefused(requestOf({0, 0, 1}, -10, -1), ErrorCode::kUsage, "--thickness: ");
  PlaneSliceRequest small = requestOf({0, 0, 1}, -10);
  small.memory_bytes = 1024;
  expectRefused(small, ErrorCode::kBudget, "--memory");
}

}  // namespace
}  // namespace kiln::test
