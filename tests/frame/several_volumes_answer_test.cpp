// Several volumes in a picture against two truths. Two overlapping uniform media have a closed form. Two heads of
// different spacing and rotation are compared with the reference renderer, which adds extinctions along a ray and has
// no slabs.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>
#include <tuple>

#include "image/compare.h"
#include "image/file/image_file.h"
#include "support/files/foreign_files.h"
#include "support/reference/contact_sheet.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/reference/quality_scenes.h"
#include "support/reference/reference_renderer.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

TransferFunction uniformFunction(const glm::dvec3& color, double opacity) { return {1, {{0, color, opacity}}}; }

// A box of 40³ voxels around a box of 20³ voxels of edge 0.8, rotated about the line of sight. Rays through the middle
// cross 12 of the outer box, 16 of both, and 12 of the outer box. Each medium contributes light in proportion to its
// absorption.
TEST(MultiVolume, MediaThroughEachOtherHaveTheirClosedForm) {
  const DenseVolume outer = fill({{40, 40, 40}, VoxelType::u8}, [](auto...) { return 9; });
  glm::dmat4 turned = glm::translate(glm::dmat4(1), glm::dvec3(19.5));
  turned = glm::rotate(turned, 0.7, glm::dvec3(0, 0, 1));
  turned = glm::scale(turned, glm::dvec3(0.8));
  turned = glm::translate(turned, glm::dvec3(-9.5));
  const DenseVolume inner = fill({{20, 20, 20}, VoxelType::u8, turned}, [](auto...) { return 5; });
  const std::vector<std::filesystem::path> stores = {makeStore(outer, "outer", 16), makeStore(inner, "inner", 8)};
  const glm::dvec3 red(1, 0, 0), blue(0, 0, 1);
  for (const double opacity : {0.01, 0.05, 0.4}) {
    FrameRequest request;
    Camera camera;
    camera.projection = Projection::kOrthographic;
    camera.eye = {19.5, 19.5, -100}, camera.target = {19.5, 19.5, 19.5}, camera.up = {0, 1, 0};
    camera.height = 10;
    request.view = resolve(camera, {32, 32});
    request.opacity_threshold = 1;
    request.volumes = {{uniformFunction(red, opacity), {}, {}}, {uniformFunction(blue, 2 * opacity), {}, {}}};
    for (VolumeRequest& volume : request.volumes) volume.shading.phong = false;
    const Image image = draw(stores, request);
    const double a = extinctionOf(opacity, 1), b = extinctionOf(2 * opacity, 1);
    const double alone = std::exp(-12 * a), both = std::exp(-16 * (a + b));
    const double expected[4] = {(1 - alone) + alone * (1 - both) * a / (a + b) + alone * both * (1 - alone), 0,
                                alone * (1 - both) * b / (a + b), 1 - alone * both * alone};
    double mean[4] = {};
    for (std::size_t i = 0; i < image.rgba.size(); ++i) mean[i % 4] += image.rgba[i] / (32.0 * 32.0);
    for (int c = 0; c < 4; ++c)
      EXPECT_NEAR(mean[c], expected[c], 0.005 * expected[3]) << "channel " << c << " opacity " << opacity;
  }
}

struct MixMagnification {
  double px_per_voxel, least_db;
  int rays_per_axis = 4;  // rays of the reference along each axis of a pixel
};
constexpr int kMixPixels = 96;

// The first volume's smallest voxel is so many pixels.
Camera mixCameraAt(const VolumeGeometry& volume, Projection projection, double px_per_voxel) {
  Camera camera = cameraFrom(volume, {-0.55, -1, 0.25}, projection);
  const double height = kMixPixels / px_per_voxel * volume.meanSpacing();
  camera.fov_deg = 2 * std::atan(std::tan(camera.fov_deg / 2 * 3.14159265358979 / 180) * height / camera.height) * 180 /
                   3.14159265358979;
  camera.height = height;
  return camera;
}

// Returns the affine of a rotated volume with this middle and these voxel edges.
glm::dmat4 turnedAround(const glm::dvec3& middle, const glm::dvec3& spacing, const Extent3& dims) {
  glm::dmat4 turned = glm::translate(glm::dmat4(1), middle);
  turned = glm::rotate(turned, 0.8, glm::normalize(glm::dvec3(1, 0.4, 0.2)));
  turned = glm::scale(turned, spacing);
  return glm::translate(turned, -glm::dvec3(dims.x - 1, dims.y - 1, dims.z - 1) / 2.0);
}

// Draws the scene, prints its distance from the reference's picture, and adds both and the difference to the sheet.
void expectThatOfTheReference(const std::vector<ReferenceVolume>& scene,
                              const std::vector<std::filesystem::path>& stores, const View& view,
                              const MixMagnification& must, const std::string& name,
                              std::vector<std::vector<Image>>& sheet) {
  FrameRequest request;
  request.view = view;
  request.opacity_threshold = 0.9999;
  for (const ReferenceVolume& volume : scene)
    request.volumes.push_back({volume.transfer_function, volume.shading, volume.clipping});
  const Image truth = referenceImage(scene, view, {must.rays_per_axis, 0.25, 0.9999}), image = draw(stores, request);
  const ImageDifference ours = compareImages(truth, image);
  std::printf("%s, %.0f px/voxel: %.1f dB, brightness %+.2f %%\n", name.c_str(), must.px_per_voxel,
              ours.foreground_psnr_db, 100 * (ours.mean_brightness_ratio - 1));
  std::fflush(stdout);
  EXPECT_GE(ours.foreground_psnr_db, must.least_db);
  EXPECT_NEAR(ours.mean_brightness_ratio, 1, 0.01);
  sheet[0].push_back(image);
  sheet[1].push_back(truth);
  sheet[2].push_back(differenceImage(image, truth));
}

class VolumeMixPicture : public ::testing::TestWithParam<Projection> {};

TEST_P(VolumeMixPicture, IsThatOfTheReference) {
  const Projection projection = GetParam();
  const DenseVolume first = readVolume("phantom:head:144x144x144");
  DenseVolume second = readVolume("phantom:engine:100x120x90");
  const glm::dvec3 middle = first.geometry.worldOf({71.5, 71.5, 71.5});
  const double edge = first.geometry.meanSpacing();
  second.geometry.world_from_index =
      turnedAround(middle + edge * glm::dvec3(10, -25, 15), edge * glm::dvec3(0.8, 0.9, 1.3), second.geometry.dims);
  const std::vector<std::filesystem::path> stores = {makeStore(first, "mixed_head", 64),
                                                     makeStore(second, "mixed_engine", 32)};
  const ValueRange values = second.range();
  const double solid = values.lo + 0.5 * (values.hi - values.lo);
  std::vector<ReferenceVolume> scene(2);
  scene[0] = {&first,
              {0,
               {{-200, {0.9, 0.55, 0.4}, 0},
                {0, {0.9, 0.55, 0.4}, 0.06},
                {200, {0.9, 0.55, 0.4}, 0.06},
                {350, {0.88, 0.8, 0.64}, 0.9}}},
              {},
              {}};
  scene[1] = {&second, {0, {{solid - 12, {0.4, 0.6, 0.9}, 0}, {solid + 12, {0.4, 0.6, 0.9}, 0.95}}}, {}, {}};
  scene[0].clipping.planes = {{{0, 1, 0}, -middle.y + 30 * edge}};
  std::vector<std::vector<Image>> sheet(3);
  for (const MixMagnification& must : {MixMagnification{1, 30}, {2, 34}}) {
    const View view = resolve(mixCameraAt(first.geometry, projection, must.px_per_voxel), {kMixPixels, kMixPixels});
    expectThatOfTheReference(scene, stores, view, must, nameOf(projection), sheet);
  }
  writeContactSheet(sheet, kMixPixels, fmt::format("volume_mix_{}.png", nameOf(projection)));
}

INSTANTIATE_TEST_SUITE_P(Projections, VolumeMixPicture,
                         ::testing::Values(Projection::kOrthographic, Projection::kPerspective));

// Scans at 512 x 512 pixels: a head, bone through translucent skin, intersected by another head or an engine. The
// second volume is rotated and has different voxel edges.
class NightlyMixOfScans : public ::testing::TestWithParam<std::tuple<const char*, Projection, MixMagnification>> {};

TEST_P(NightlyMixOfScans, IsThatOfTheReference) {
  constexpr int kPixels = 512;
  const auto [name, projection, must] = GetParam();
  const auto subject = [](const std::string& wanted) {
    const std::vector<QualityVolume>& all = qualityVolumes();
    return *std::find_if(all.begin(), all.end(), [&](const QualityVolume& v) { return v.name == wanted; });
  };
  const QualityVolume head = subject("vhm_head"), other = subject(name);
  if (realData(head.file).empty() || realData(other.file).empty()) GTEST_SKIP() << "../shared/data is not here";
  const DenseVolume first = readVolume(realData(head.file));
  DenseVolume second = readVolume(realData(other.file));
  const glm::dvec3 face = first.geometry.worldOf(head.close_up);
  const double edge = first.geometry.meanSpacing();
  second.geometry.world_from_index =
      turnedAround(face + edge * glm::dvec3(30, 55, 45), edge * glm::dvec3(0.8, 0.9, 1.3), second.geometry.dims);
  const std::vector<std::filesystem::path> stores = {makeStore(first, "head", 128), makeStore(second, "other", 64)};
  std::vector<ReferenceVolume> scene(2);
  scene[0] = {&first, transferFunctionOf(head, Material::kBoneInSkin), {}, {}};
  scene[1] = {&second, transferFunctionOf(other, Material::kBone), {}, {}};
  scene[1].transfer_function.points[0].color = scene[1].transfer_function.points[1].color = {0.4, 0.6, 0.9};
  std::vector<std::vector<Image>> sheet(3);
  const Camera camera = cameraOf(head, first.geometry, projection, must.px_per_voxel, kPixels);
  expectThatOfTheReference(scene, stores, resolve(camera, {kPixels, kPixels}), must,
                           fmt::format("vhm_head and {}, {}", name, nameOf(projection)), sheet);
  writeContactSheet(sheet, kPixels,
                    fmt::format("volume_mix_{}_{}_{}px.png", name, nameOf(projection), must.px_per_voxel));
}

// The reference takes at least as many rays a voxel.
INSTANTIATE_TEST_SUITE_P(Scans, NightlyMixOfScans,
                         ::testing::Combine(::testing::Values("engine", "cthead"),
                                            ::testing::Values(Projection::kOrthographic, Projection::kPerspective),
                                            ::testing::Values(MixMagnification{1, 28}, MixMagnification{2, 34, 2},
                                                              MixMagnification{4, 34, 2})));

}  // namespace
}  // namespace kiln::test
