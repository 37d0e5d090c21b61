// Known answers: a quarter turn follows from trigonometry; a spline passes through its keys; between two keys on a
// circle about the target, the eye stays on the circle. Between two transfer functions lies their mean, weighted by
// opacity.
#include "job/animation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <string>

#include "base/error.h"
#include "job/frame/frame_scene.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "job/render_job.h"
#include "scene/camera/camera_path.h"
#include "scene/transfer/transfer_function_fade.h"
#include "support/volumes/test_store.h"

namespace kiln {
namespace {

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance, int line) {
  EXPECT_LE(glm::distance(a, b), tolerance) << "line " << line << ": " << a.x << " " << a.y << " " << a.z;
}

VolumeGeometry box() {
  VolumeGeometry out;
  out.dims = {11, 11, 11};
  return out;
}

RenderJob jobOf(const std::string& body) {
  return parseJob(R"({"kiln": 2, "volume": "a.kiln", )" + body + "}", "job.json");
}

Camera cameraOf(const RenderJob& job, double frame) {
  return cameraAt(job.animation.camera, job.picture.camera, frame, box(), {64, 64});
}

TEST(FrameList, RangesStepsAndSingleFrames) {
  EXPECT_EQ(parseFrames("7"), (std::vector<int>{7}));
  EXPECT_EQ(parseFrames("1-4"), (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(parseFrames("1-10x4,3, 5-6,1"), (std::vector<int>{1, 5, 9, 3, 6}));
  EXPECT_EQ(framesText({1, 2, 3, 7, 9, 10}), "1-3,7,9-10");
  for (const char* wrong : {"", "a", "5-1", "1-", "1-5x0", "1,,2", "1-5x", "-3", "1 2", "1-99999999", "0-9999999"})
    EXPECT_THROW(parseFrames(wrong), Error) << wrong;
}

TEST(FrameList, NumbersFillTheirPlace) {
  EXPECT_EQ(pathOfFrame("d_##/a_####.exr", 12), "d_12/a_0012.exr");
  EXPECT_EQ(pathOfFrame("a_##.exr", 1234), "a_1234.exr");
  EXPECT_EQ(pathOfFrame("a.exr", 3), "a.exr");
  // An existing folder, such as the job's own, is no pattern.
  const std::filesystem::path shot = test::freshDirectory("frames_of") / "shot#3";
  std::filesystem::create_directory(shot);
  EXPECT_EQ(pathOfFrame(shot / "a_##.exr", 7), shot / "a_07.exr");
  EXPECT_EQ(pathOfFrame(shot / "d#/a_##.exr", 7), shot / "d7/a_07.exr");
  EXPECT_TRUE(hasFramePlace(shot / "a_##.exr"));
  EXPECT_FALSE(hasFramePlace(shot / "a.exr"));
  EXPECT_FALSE(hasFramePlace("a.exr"));
}

TEST(Animation, FramesAreThoseThatAreSaidOrOfTheAnimation) {
  EXPECT_EQ(framesOf(jobOf(R"("threads": 1)")), (std::vector<int>{1}));
  EXPECT_EQ(framesOf(jobOf(R"("camera": {"turntable": {"frames": 3}})")), (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(framesOf(jobOf(R"("camera": {"keyframes": [{"frame": 4}, {"frame": 6.5}]},
                              "lights": {"keyframes": [{"frame": 3, "lights": []}]})")),
            (std::vector<int>{3, 4, 5, 6}));
  EXPECT_EQ(framesOf(jobOf(R"("frames": "8,2", "camera": {"turntable": {"frames": 3}})")), (std::vector<int>{8, 2}));
}

TEST(CameraPath, ATurntableTurnsAboutItsAxis) {
  const RenderJob job = jobOf(
      R"("camera": {"eye": [15, 5, 7], "target": [5, 5, 5], "up": [0, 0, 1], "turntable": {"frames": 4, "axis": [0, 0, 3]}})");
  expectNear(cameraOf(job, 1).eye, {15, 5, 7}, 0, __LINE__);
  expectNear(cameraOf(job, 2).eye, {5, 15, 7}, 1e-12, __LINE__);
  expectNear(cameraOf(job, 3).eye, {-5, 5, 7}, 1e-12, __LINE__);
  expectNear(cameraOf(job, 5).eye, {15, 5, 7}, 1e-12, __LINE__);
  expectNear(cameraOf(job, 2).up, {0, 0, 1}, 1e-12, __LINE__);
}

// Two framings a quarter turn apart: the target stays, so the eye moves around the target at constant distance and
// speed.
TEST(CameraPath, KeysAboutOneTargetGoRoundIt) {
  const RenderJob job = jobOf(R"("camera": {"view": "front", "keyframes": [{"frame": 10, "azimuth": 0},
                                                                          {"frame": 19, "azimuth": 90}]})");
  const Camera first = cameraOf(job, 10), last = cameraOf(job, 19);
  const double distance = glm::distance(first.eye, first.target);
  for (double frame = 10; frame <= 19; frame += 1) {
    const Camera camera = cameraOf(job, frame);
    expectNear(camera.target, first.target, 1e-9, __LINE__);
    EXPECT_NEAR(glm::distance(camera.eye, camera.target), distance, 1e-9);
    const double turned =
        glm::degrees(std::acos(glm::dot(camera.eye - camera.target, first.eye - first.target) / (distance * distance)));
    EXPECT_NEAR(turned, 10 * (frame - 10), 1e-5);
    expectNear(camera.up, first.up, 1e-9, __LINE__);
  }
  expectNear(cameraOf(job, 3).eye, first.eye, 0, __LINE__);
  expectNear(cameraOf(job, 30).eye, last.eye, 0, __LINE__);
}

// The eye passes its keys without a corner, on a straight line at constant speed, and looks in the keys' directions.
TEST(CameraPath, KeysOfAnEyeAreASpline) {
  const RenderJob job = jobOf(R"("camera": {"up": [0, 0, 1], "keyframes": [
      {"frame": 0, "eye": [0, -90, 0], "target": [0, 0, 0], "fov": 30},
      {"frame": 10, "eye": [10, -90, 0], "target": [10, 0, 0]},
      {"frame": 20, "eye": [20, -90, 0], "target": [20, 0, 0], "fov": 30, "ease": "stop"},
      {"frame": 30, "eye": [20, -90, 5], "target": [20, 0, 5], "ease": "stop"}]})");
  expectNear(cameraOf(job, 5).eye, {5, -90, 0}, 1e-9, __LINE__);
  expectNear(cameraOf(job, 10).eye, {10, -90, 0}, 0, __LINE__);
  expectNear(cameraOf(job, 5).target, {5, 0, 0}, 1e-9, __LINE__);
  expectNear(cameraOf(job, 25).eye, {20, -90, 2.5}, 1e-9, __LINE__);
  // Ease from rest to rest: 3t² − 2t³ of the way.
  EXPECT_NEAR(cameraOf(job, 22).eye.z, 5 * (3 * 0.04 - 2 * 0.008), 1e-9);
  // The tangent of half the angle is interpolated geometrically.
  EXPECT_NEAR(std::tan(glm::radians(cameraOf(job, 25).fov_deg / 2)),
              std::sqrt(std::tan(glm::radians(15.0)) * std::tan(glm::radians(30.0))), 1e-9);
  // The path has no corner at the middle key.
  const auto velocity = [&](double frame) {
    return (cameraOf(job, frame + 1e-4).eye - cameraOf(job, frame).eye) / 1e-4;
  };
  expectNear(velocity(10 - 1e-4), velocity(10), 1e-3, __LINE__);
  // The turn and the zoom of the still framing are not those of an eye.
  const RenderJob framed = jobOf(R"("camera": {"azimuth": 30, "elevation": 10, "zoom": 2, "keyframes": [
      {"frame": 1, "eye": [0, -90, 0], "target": [0, 0, 0]}]})");
  expectNear(cameraOf(framed, 1).eye, {0, -90, 0}, 0, __LINE__);
  EXPECT_EQ(cameraOf(framed, 1).fov_deg, 60);
}

// Orientations: a turn in three keys keeps its speed through the middle key, for either sign of a quaternion.
TEST(CameraPath, OrientationsGoTheShorterWayWithoutACorner) {
  KeyTimes times(std::vector<Key<int>>{{0, Ease::kSmooth, 0}, {10, Ease::kSmooth, 0}, {20, Ease::kSmooth, 0}});
  const auto turn = [](double degrees) { return glm::angleAxis(glm::radians(degrees), glm::dvec3(0, 0, 1)); };
  const std::vector<glm::dquat> keys = {turn(0), -turn(100), turn(200)};
  for (double frame = 0; frame <= 20; frame += 2.5) {
    const glm::dvec3 x = splineAt(times, keys, frame) * glm::dvec3(1, 0, 0);
    expectNear(x, {std::cos(glm::radians(10 * frame)), std::sin(glm::radians(10 * frame)), 0}, 1e-9, __LINE__);
  }
}

// A matrix with these rows: the camera's x is -y of the world, the view direction is -x from (50, 5, 5), z is up.
TEST(CameraPath, MatricesAreCameraToWorld) {
  const RenderJob job = jobOf(R"("camera": {"fov": 40, "matrices": [
      [[0, 0, 1, 50], [1, 0, 0, 5], [0, 1, 0, 5], [0, 0, 0, 1]],
      [[1, 0, 0, 5], [0, 0, -1, -50], [0, 1, 0, 5], [0, 0, 0, 1]]]})");
  const Camera camera = cameraOf(job, 1);
  expectNear(camera.eye, {50, 5, 5}, 0, __LINE__);
  expectNear(glm::normalize(camera.target - camera.eye), {-1, 0, 0}, 1e-12, __LINE__);
  expectNear(camera.up, {0, 0, 1}, 0, __LINE__);
  EXPECT_EQ(camera.fov_deg, 40);
  expectNear(glm::normalize(cameraOf(job, 2).target - cameraOf(job, 2).eye), {0, 1, 0}, 1e-12, __LINE__);
  EXPECT_THROW(cameraOf(job, 3), Error);
  EXPECT_THROW(cameraOf(jobOf(R"("camera": {"azimuth": 3, "matrices": [
      [[0, 0, 1, 50], [1, 0, 0, 5], [0, 1, 0, 5], [0, 0, 0, 1]]]})"),
                        1),
               Error);
  EXPECT_THROW(jobOf(R"("camera": {"matrices": [[[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]]})"), Error);
}

TEST(Animation, WhatNothingLiesBetweenIsRefused) {
  for (
      const char* wrong :
      {R"("camera": {"turntable": {"frames": 3}, "keyframes": [{"frame": 1}]})", R"("camera": {"pivot": "eye"})",
       R"("camera": {"keyframes": []})", R"("camera": {"keyframes": [{"azimuth": 3}]})",
       R"("camera": {"keyframes": [{"frame": 2}, {"frame": 2}]})", R"("camera": {"turntable": {}})",
       R"("camera": {"turntable": {"frames": 3, "axis": [0, 0, 0]}})", R"("camera": {"matrices": [[1]]})",
       R"("transferFunction": {"keyframes": [{"frame": 1}]})", R"("frames": "3-1")", R"("frames": 3)",
       R"("lights": {"keyframes": [{"frame": 1, "lights": []}, {"frame": 2, "lights": [{"type": "headlight"}]}]})",
       R"("lights": {"keyframes": [{"frame": 1, "lights": [{"type": "camera", "direction": [0, 1, 1], "shadow": true}]},
                                    {"frame": 2, "lights": [{"type": "camera", "direction": [0, 1, 1]}]}]})",
       R"("clip": {"keyframes": [{"frame": 1, "planes": [{"normal": [0, 0, 1], "offset": 0}]},
                                  {"frame": 2, "planes": [{"normal": [0, 0, -2], "offset": 0}]}]})"})
    EXPECT_THROW(jobOf(wrong), Error) << wrong;
  const RenderJob turn =
      jobOf(R"("camera": {"keyframes": [{"frame": 1, "azimuth": 0}, {"frame": 2, "azimuth": 180}]})");
  EXPECT_THROW(cameraOf(turn, 1), Error);
  // Keys turn the shorter way: of half a turn there are two, and of more none that is meant.
  for (
      const char* wrong :
      {R"({"frame": 1, "roll": 0}, {"frame": 2, "roll": 360})", R"({"frame": 1}, {"frame": 2, "roll": 270})",
       R"({"frame": 1, "view": "front"}, {"frame": 2, "view": "back"})",
       R"({"frame": 1, "eye": [0, -90, 5], "target": [0, 0, 5]}, {"frame": 2, "eye": [0, 90, 5], "target": [0, 0, 5]})"})
    EXPECT_THROW(cameraOf(jobOf(R"("camera": {"keyframes": [)" + std::string(wrong) + "]}"), 1), Error) << wrong;
  const RenderJob still =
      jobOf(R"("camera": {"azimuth": -20, "keyframes": [{"frame": 1}, {"frame": 2, "azimuth": 170}]})");
  EXPECT_THROW(cameraOf(still, 1), Error);
  const RenderJob rolls = jobOf(R"("camera": {"view": "front", "keyframes": [{"frame": 1, "roll": 0},
      {"frame": 2, "roll": 120}, {"frame": 3, "roll": 240}, {"frame": 4, "roll": 360}]})");
  expectNear(glm::normalize(cameraOf(rolls, 2.5).up), -glm::normalize(cameraOf(rolls, 1).up), 1e-6, __LINE__);
  const RenderJob mixed = jobOf(R"("camera": {"keyframes": [{"frame": 1, "projection": "perspective"},
                                                            {"frame": 2, "projection": "orthographic"}]})");
  EXPECT_THROW(cameraOf(mixed, 1), Error);
}

TEST(Animation, LightsAndPlanesAreMixed) {
  const std::vector<Light> a = {{LightKind::kPoint, {0, 0, 0}, {1, 1, 1}, 1}},
                           b = {{LightKind::kPoint, {4, 0, 8}, {0, 1, 0}, 3}};
  EXPECT_EQ(mixed(a, b, 0.25), (std::vector<Light>{{LightKind::kPoint, {1, 0, 2}, {0.75, 1, 0.75}, 1.5}}));
  const std::vector<ClipPlane> low = {{{0, 0, 1}, 0}}, high = {{{0, 0, 1}, -8}};
  EXPECT_EQ(mixed(low, high, 0.5), (std::vector<ClipPlane>{{{0, 0, 1}, -4}}));
}

TEST(Animation, AtTheLastKey_lightsAndPlanesAreTheKeys) {
  const RenderJob job = jobOf(R"("lights": {"keyframes": [
      {"frame": 1, "lights": [{"type": "directional", "direction": [0, 0, 2]}]},
      {"frame": 3, "lights": [{"type": "directional", "direction": [0, 3, 4]}]}]},
    "clip": {"keyframes": [{"frame": 1, "planes": [{"normal": [0, 0, 1], "offset": 0}]},
                           {"frame": 3, "planes": [{"normal": [0, 3, 4], "offset": 7}]}]})");
  Manifest manifest;
  manifest.levels.resize(1);
  manifest.levels[0].geometry = box();
  const FrameScene scene = SceneOfJob(job, manifest).at(3);
  EXPECT_EQ(scene.picture.shading.lights, job.animation.lights.back().value);
  EXPECT_EQ(scene.picture.clipping.planes, job.animation.clip.back().value);
}

TEST(Animation, LightsOfKeys_areThoseOfTheShadingOfAllFrames) {
  const std::string key = R"({"frame": %, "lights": [{"type": "directional", "direction": [1, 0, 1]}]})";
  const auto at = [&](const char* frame) { return std::string(key).replace(key.find('%'), 1, frame); };
  const RenderJob job =
      jobOf(R"("shading": {"shadows": true}, "lights": {"keyframes": [)" + at("1") + ", " + at("5") + "]}");
  EXPECT_FALSE(castsShadows(job.picture.shading));
  EXPECT_TRUE(castsShadows(shadingOf(job)));
  EXPECT_FALSE(castsShadows(shadingOf(jobOf(R"("shading": {"shadows": true})"))));
}

TEST(Animation, EyesAreMixed) {
  const RenderJob job = jobOf(R"("stereo": {"eye": "right", "keyframes": [
      {"frame": 3, "interocular": 4, "convergence": 100}, {"frame": 7, "interocular": 8, "convergence": 300}]})");
  EXPECT_EQ(framesOf(job), (std::vector<int>{3, 4, 5, 6, 7}));
  EXPECT_EQ(job.picture.stereo, (Stereo{StereoEye::kRight, 4, 100}));
  EXPECT_EQ(mixed(job.animation.stereo[0].value, job.animation.stereo[1].value, 0.25).interocular, 5);
  EXPECT_EQ(mixed(job.animation.stereo[0].value, job.animation.stereo[1].value, 0.25).convergence, 150);
  EXPECT_EQ(mixed(Stereo{StereoEye::kBoth, 4, {}}, Stereo{StereoEye::kBoth, 8, {}}, 0.5),
            (Stereo{StereoEye::kBoth, 6, {}}));
}

// At each value the opacity is the mean, and the colour is the visible function's: at values that only b shows, b's
// colour.
TEST(TransferFunctionFade, LiesBetween) {
  const TransferFunction a{1, {{0, {1, 0, 0}, 0}, {10, {1, 0, 0}, 0.8}}},
      b{1, {{0, {0, 0, 1}, 0.4}, {5, {0, 0, 1}, 0.4}, {5, {0, 1, 0}, 0}}};
  const TransferFunction half = faded(a, b, 0.5);
  EXPECT_NEAR(half.at(0).opacity, 0.2, 1e-12);
  EXPECT_EQ(half.at(0).color, glm::dvec3(0, 0, 1));
  EXPECT_NEAR(half.at(5).opacity, 0.2, 1e-12);
  EXPECT_EQ(half.at(5).color, glm::dvec3(1, 0, 0));
  EXPECT_NEAR(half.at(5 - 1e-9).opacity, 0.4, 1e-6);
  EXPECT_NEAR(half.at(10).opacity, 0.4, 1e-12);
  EXPECT_EQ(faded(a, b, 0).points.size(), a.points.size());
  EXPECT_EQ(faded(a, b, 1).points.size(), b.points.size());
  // Opacity 0.75 per 2 is 0.5 per 1.
  const TransferFunction thin{2, {{0, {1, 1, 1}, 0.75}}}, none{1, {{0, {1, 1, 1}, 0}}};
  EXPECT_NEAR(faded(none, thin, 0.5).at(0).opacity, 0.25, 1e-12);
  // The last step of a fade is small, also between points: 0.65132 per 10 is 0.1 per 1.
  const TransferFunction ramp{1, {{0, {1, 1, 1}, 0}, {1000, {1, 1, 1}, 0.1}}},
      long_ramp{10, {{0, {1, 1, 1}, 0}, {1000, {1, 1, 1}, 0.65132}}};
  const TransferFunction last = faded(ramp, long_ramp, 0.999);
  for (const double value : {100, 500, 900})
    EXPECT_NEAR(last.at(value).opacity, 1 - std::pow(1 - long_ramp.at(value).opacity, 0.1), 3e-4) << value;
  const TransferFunction edges{1, {{0, {1, 1, 1}, 1}}, {{1, 0}, {3, 1}}};
  EXPECT_NEAR(faded(none, edges, 0.5).gradientFactor(0, 1), 0.5, 1e-12);
}

TransferFunction surfacesOf(std::vector<IsoSurface> of) {
  TransferFunction out{1, {}};
  out.surfaces = std::move(of);
  return out;
}

// Names of labels stay in a fade, and all regions of two neighbouring keys are drawn between them.
TEST(TransferFunctionFade, KeepsNames_andTellsWhetherRegionsFade) {
  TransferFunction a{.unit = 1, .points = {}}, b{.unit = 1, .points = {}};
  a.labels = {{1, "liver", glm::dvec3(0.5), 1}};
  b.labels = {{1, "", glm::dvec3(0.5), 1}, {2, "spleen", glm::dvec3(0.5), 1}};
  const TransferFunction between = faded(a, b, 0.5);
  ASSERT_EQ(between.labels.size(), 2u);
  EXPECT_EQ(between.labels[0].name, "liver");
  EXPECT_EQ(between.labels[1].name, "spleen");
  TransferFunction one{.unit = 1, .points = {}}, other{.unit = 1, .points = {}};
  one.regions.resize(3), other.regions.resize(2);
  EXPECT_TRUE(regionsFade(one, other));
  EXPECT_EQ(faded(one, other, 0.5).regions.size(), 5u);
  EXPECT_FALSE(regionsFade(one, one));
  EXPECT_FALSE(regionsFade(one, a));
}

TEST(TransferFunctionFade, EquallyManySurfaces_move) {
  const TransferFunction half =
      faded(surfacesOf({{0, {1, 0, 0}, 1}, {10}}), surfacesOf({{4, {0, 0, 1}, 0.5}, {30}}), 0.5);
  ASSERT_EQ(half.surfaces.size(), 2u);
  EXPECT_EQ(half.surfaces[0].value, 2);
  EXPECT_EQ(half.surfaces[0].opacity, 0.75);
  EXPECT_NEAR(half.surfaces[0].color.r, 2 / 3.0, 1e-12);
  EXPECT_EQ(half.surfaces[1].value, 20);
  EXPECT_EQ(half.surfaces[1].opacity, 1);
}

TEST(TransferFunctionFade, OtherSurfaces_fade) {
  const TransferFunction half = faded(surfacesOf({{0, {1, 0, 0}, 1}, {10}}), surfacesOf({{0, {1, 0, 0}, 0.5}}), 0.5);
  ASSERT_EQ(half.surfaces.size(), 2u);
  EXPECT_EQ(half.surfaces[0].opacity, 0.75);
  EXPECT_EQ(half.surfaces[1].value, 10);
  EXPECT_EQ(half.surfaces[1].opacity, 0.5);
}

}  // namespace
}  // namespace kiln
