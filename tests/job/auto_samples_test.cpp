// Default number of samples a pixel, for cameras with voxels of a known size in pixels.
#include "job/frame/auto_samples.h"

#include <gtest/gtest.h>

#include "job/frame/frame_scene.h"
#include "scene/camera/framing.h"

namespace kiln::test {
namespace {

// A volume of n³ voxels of edge 2, with levels of half as many along each axis.
Manifest cubesOf(std::int64_t n) {
  Manifest out;
  for (double edge = 2; n >= 1; n /= 2, edge *= 2) {
    LevelInfo level;
    level.geometry.dims = {n, n, n};
    level.geometry.world_from_index = glm::dmat4(edge);
    level.geometry.world_from_index[3][3] = 1;
    out.levels.push_back(level);
  }
  return out;
}

// A camera for a picture of 512² in which a voxel at the middle covers `px_per_voxel` pixels.
Camera cameraOf(const Manifest& volume, Projection projection, double px_per_voxel) {
  Camera out;
  out.projection = projection;
  out.target = centreOf(volume.geometry());
  out.height = 512 / px_per_voxel * 2;
  out.fov_deg = 90;
  out.eye = out.target + glm::dvec3(0, 0, out.height / 2);
  return out;
}

RenderJob jobOf(const ImageSize& size) {
  RenderJob out;
  out.picture.size = size;
  return out;
}

int samplesFor(const Manifest& volume, double px_per_voxel, const RenderJob& job = jobOf({512, 512}),
               Projection projection = Projection::kPerspective) {
  return automaticSamples(job, cameraOf(volume, projection, px_per_voxel), centreOf(volume.geometry()), {&volume});
}

TEST(AutoSamples, AreMoreWhereVoxelsAreSmall) {
  const Manifest volume = cubesOf(256);
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    const std::pair<double, int> expected[] = {{8, 1},     {1, 1},     {0.76, 1},  {0.74, 4}, {0.5, 4},
                                               {0.376, 4}, {0.37, 16}, {0.25, 16}, {0.01, 16}};
    for (const auto& [px, samples] : expected)
      EXPECT_EQ(samplesFor(volume, px, jobOf({512, 512}), projection), samples) << px;
  }
}

TEST(AutoSamples, AreThoseOfTheSmallestEdge) {
  Manifest volume = cubesOf(128);
  volume.levels.resize(1);
  volume.levels[0].geometry.world_from_index[2] *= 4;
  EXPECT_EQ(samplesFor(volume, 0.5), 4);
  volume.levels[0].geometry.world_from_index[0] *= 0.5;
  EXPECT_EQ(samplesFor(volume, 0.5), 16);
}

// Known because the levels have 2^30, 2^27, 2^24 voxels, and the next level is shown below 7/16 of a pixel.
TEST(AutoSamples, ShowNoLevelOfMoreVoxelsThanAreSaid) {
  const Manifest large = cubesOf(1024);
  EXPECT_EQ(samplesFor(large, 0.5), 1);   // 4 show level 0
  EXPECT_EQ(samplesFor(large, 0.22), 1);  // 4 show level 0
  EXPECT_EQ(samplesFor(large, 0.21), 4);  // 4 show level 1, 16 level 0
  EXPECT_EQ(samplesFor(large, 0.1), 16);  // 16 show level 1
  RenderJob job = jobOf({512, 512});
  job.picture.level = 0;
  EXPECT_EQ(samplesFor(large, 0.1, job), 1);
  job.picture.level = 1;
  EXPECT_EQ(samplesFor(large, 0.25, job), 4);
  EXPECT_EQ(samplesFor(large, 0.4, job), 1);
}

// A moving camera shows details that a single ray meets or misses, until voxels are large.
TEST(AutoSamples, AreFourWhereTheCameraMoves) {
  const Manifest volume = cubesOf(256), large = cubesOf(1024);
  RenderJob job = jobOf({512, 512});
  Turntable turn;
  turn.frames = 12;
  job.animation.camera = turn;
  EXPECT_EQ(samplesFor(volume, 1, job), 4);
  EXPECT_EQ(samplesFor(volume, 3.9, job), 4);
  EXPECT_EQ(samplesFor(volume, 4.1, job), 1);
  EXPECT_EQ(samplesFor(volume, 0.25, job), 16);
  // A large volume: 4 samples read no finer level at a pixel a voxel.
  EXPECT_EQ(samplesFor(large, 1, job), 4);
  EXPECT_EQ(samplesFor(large, 0.22, job), 1);
  EXPECT_EQ(samplesFor(volume, 1), 1);
  job.animation.camera = CameraMatrices(2, glm::dmat4(1));
  EXPECT_EQ(samplesFor(volume, 1, job), 4);
  job.animation.camera = CameraMatrices(1, glm::dmat4(1));
  EXPECT_EQ(samplesFor(volume, 1, job), 1) << "a path of one camera is a still picture";
}

// Edges of labels are steps that a single ray meets or misses.
TEST(AutoSamples, AreFourOfLabelsNearAPixelAVoxel) {
  Manifest labels = cubesOf(256), large = cubesOf(1024);
  const Manifest amounts = cubesOf(256);
  labels.volume_class = large.volume_class = VolumeClass::kLabels;
  EXPECT_EQ(samplesFor(labels, 1), 4);
  EXPECT_EQ(samplesFor(labels, 1.24), 4);
  EXPECT_EQ(samplesFor(labels, 1.26), 1);
  EXPECT_EQ(samplesFor(labels, 0.25), 16);
  EXPECT_EQ(samplesFor(large, 1), 4);  // reads no finer level
  EXPECT_EQ(samplesFor(large, 0.4), 1);
  // With other volumes, rays cost more than with labels alone.
  const Camera camera = cameraOf(labels, Projection::kOrthographic, 1);
  EXPECT_EQ(automaticSamples(jobOf({512, 512}), camera, camera.target, {&labels, &labels}), 4);
  EXPECT_EQ(automaticSamples(jobOf({512, 512}), camera, camera.target, {&labels, &amounts}), 1);
}

TEST(AutoSamples, MakeNoPictureOfMoreSubPixelsThanAreSaid) {
  const Manifest volume = cubesOf(256);
  // A voxel's pixels grow with the picture.
  const auto samples = [&](int edge) { return samplesFor(volume, 0.1 * 512 / edge, jobOf({edge, edge})); };
  EXPECT_EQ(samples(512), 16);
  EXPECT_EQ(samples(1024), 16);
  EXPECT_EQ(samples(1025), 4);
  EXPECT_EQ(samples(2048), 4);
  EXPECT_EQ(samples(2049), 1);
}

TEST(AutoSamples, AreOneOfWhatHasOne) {
  const Manifest volume = cubesOf(256);
  EXPECT_EQ(samplesFor(volume, 0.25), 16);
  RenderJob voxels = jobOf({512, 512}), deep = voxels, mip = voxels;
  voxels.picture.lattice = Lattice::kVoxel;
  deep.output.path = "a.exr";
  deep.output.deep = true;
  mip.picture.mode = Mode::kMip;
  for (const RenderJob& job : {voxels, deep, mip}) EXPECT_EQ(samplesFor(volume, 0.25, job), 1);
  EXPECT_EQ(samplesFor(volume, 0.25, jobOf({512, 256}), Projection::kEquirectangular), 1);
}

TEST(AutoSamples, AreOneWhereTheMiddleIsBehindTheEye) {
  const Manifest volume = cubesOf(256);
  Camera camera = cameraOf(volume, Projection::kPerspective, 0.25);
  std::swap(camera.eye, camera.target);
  EXPECT_EQ(automaticSamples(jobOf({512, 512}), camera, camera.eye + glm::dvec3(0, 0, 1), {&volume}), 1);
}

TEST(AutoSamples, OfSeveralVolumesAreThoseOfTheFinest) {
  const Manifest coarse = cubesOf(64);
  Manifest fine = cubesOf(256);
  for (LevelInfo& level : fine.levels) level.geometry.world_from_index *= 0.25;
  const RenderJob job = jobOf({512, 512});
  const Camera camera = cameraOf(coarse, Projection::kOrthographic, 1.5);
  EXPECT_EQ(automaticSamples(job, camera, camera.target, {&coarse}), 1);
  EXPECT_EQ(automaticSamples(job, camera, camera.target, {&coarse, &fine}), 4);
  // More samples for the fine volume would show the finest level of the large volume.
  const Manifest large = cubesOf(1024);
  const Camera at_large = cameraOf(large, Projection::kOrthographic, 0.8);
  EXPECT_EQ(automaticSamples(job, at_large, at_large.target, {&fine}), 16);
  EXPECT_EQ(automaticSamples(job, at_large, at_large.target, {&large, &fine}), 1);
}

// The number of samples follows the frame that takes the most.
TEST(AutoSamples, OfAJobAreTheMostOfItsFrames) {
  Manifest volume = cubesOf(256);
  RenderJob job = jobOf({512, 512});
  job.picture.transfer_function = TransferFunction{0, {{0, {1, 1, 1}, 0}, {1, {1, 1, 1}, 1}}};
  CameraSpec far, near;
  for (CameraSpec* const spec : {&far, &near}) {
    spec->projection = Projection::kOrthographic;
    spec->eye = centreOf(volume.geometry()) + glm::dvec3(0, 0, 1000);
    spec->up = glm::dvec3(0, 1, 0);
  }
  far.height = 4096, near.height = 100;
  job.animation.camera = CameraKeyframes{{{1, Ease::kLinear, near}, {10, Ease::kLinear, far}}, std::nullopt};
  const SceneOfJob scenes(job, volume);
  EXPECT_EQ(scenes.at(1).picture.samples, 1);
  EXPECT_EQ(scenes.at(10).picture.samples, 16);
  EXPECT_EQ(scenes.mostSamples(), 16);
  job.picture.samples = 4;
  EXPECT_EQ(scenes.at(1).picture.samples, 4);
  EXPECT_EQ(scenes.mostSamples(), 4);
}

}  // namespace
}  // namespace kiln::test
