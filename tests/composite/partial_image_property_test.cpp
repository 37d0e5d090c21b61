// Partial images of boxes that fill the volume composite to the whole picture. On the pixel lattice each sample is in
// exactly one part. Errors are rounding, and the light behind the opacity threshold if a single part reaches the
// threshold. Footprints of voxels reach across borders of parts; their samples there lie in front of or behind the
// neighbouring part. Files store their order; files of different pictures are refused in one line with the file's name.
#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.h"
#include "composite/composite_parts.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "scene/volume_part.h"
#include "sequence/render_job_run.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/system/sanitized.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

class PartialImages : public ::testing::TestWithParam<Lattice> {
 protected:
  void SetUp() override {
    volume_ = head({{40, 51, 37}, VoxelType::u8, obliqueAffine()}, usualRange(VoxelType::u8));
    store_ = makeStore(volume_, "parts", 16);
    directory_ = store_.parent_path();
    job_.volume = store_;
    job_.picture.size = {70, 60};
    job_.picture.lattice = GetParam();
    job_.picture.samples = 1;
    job_.output.exr_float = true;
  }

  Image drawn(const std::string& name, const std::optional<VoxelBox>& part) {
    job_.picture.clipping.part = part;
    job_.output.path = directory_ / name;
    return runRenderJob(job_, 1, silent_).image;
  }
  fs::path drawnPart(const VoxelBox& part) {
    const std::string name = std::to_string(drawn_++) + ".exr";
    drawn(name, part);
    return directory_ / name;
  }
  void expectRefused(const std::vector<fs::path>& parts, const std::string& mentions) {
    try {
      compositeParts(parts, silent_);
      ADD_FAILURE() << mentions;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(mentions), std::string::npos) << error.what();
    }
  }

  // Measured over 200 scenes: on rays 64 dB or better and 0.0016 of a channel at most. Voxels have 22.5 dB at least, 40
  // in three of four scenes, and single pixels are whole channels off.
  double largestError() const { return GetParam() == Lattice::kPixel ? 1 / 255.0 : 1; }
  double leastDb() const { return GetParam() == Lattice::kPixel ? 60 : 22; }

  // Depths and normals equal the whole picture's.
  void expectPlanesOf(const Image& whole, const Image& made) {
    ASSERT_EQ(made.planes.size(), whole.planes.size());
    const double diagonal = glm::length(glm::dvec3(40, 51, 37)) * volume_.geometry.meanSpacing();
    const auto at = [](const Image& image, std::size_t plane, std::size_t i) {
      return static_cast<double>(image.planes[plane].values[i]);
    };
    std::size_t turned = 0;
    for (std::size_t i = 0; i < whole.rgba.size() / 4; ++i) {
      ASSERT_EQ(std::isfinite(at(made, 1, i)), std::isfinite(at(whole, 1, i))) << i;
      if (!std::isfinite(at(whole, 1, i))) continue;
      EXPECT_NEAR(at(made, 1, i), at(whole, 1, i), 0.01 * diagonal) << i;
      double dot = 0, length = 0;
      for (std::size_t axis = 2; axis < 5; ++axis)
        dot += at(made, axis, i) * at(whole, axis, i), length += at(whole, axis, i) * at(whole, axis, i);
      turned += length > 0 && dot < 0.95 ? 1 : 0;
    }
    // A mean of normals that nearly cancel turns with the last bits.
    EXPECT_LT(turned, whole.rgba.size() / 4 / 100);
  }

  void checkOctants(std::uint64_t seed, bool inside) {
    Random random(seed ^ 0x70617274);
    RandomScene scene = randomScene(seed, volume_, job_.picture.size);
    if (inside) {
      scene.camera.projection = Projection::kPerspective;
      scene.camera.eye =
          volume_.geometry.worldOf({random.uniform(5, 35), random.uniform(5, 45), random.uniform(5, 30)});
      scene.camera.up = glm::dvec3(0.1, 1, 0.2);
    }
    PictureOptions& picture = job_.picture;
    picture.camera = specOf(scene.camera);
    picture.transfer_function = scene.transfer_function;
    picture.shading = scene.shading;
    picture.background = scene.background;
    picture.clipping.planes = scene.clipping.planes;
    const bool rays = GetParam() == Lattice::kPixel;
    if (rays) picture.interpolation = scene.interpolation;
    picture.samples = std::array{1, rays ? 2 : 1, 4, 16}[seed % 4];
    picture.aovs.depth = picture.aovs.normal = rays && seed % 2 == 0;
    if (seed % 3 == 0) picture.crop = PixelRect{5, 7, 66, 51};
    const Image whole = drawn("whole.exr", std::nullopt);
    const Extent3& n = volume_.geometry.dims;
    // Half of the scenes divide the volume at a border of bricks, half anywhere.
    const VoxelCoord mid = seed % 2 == 0
                               ? VoxelCoord{16, 32, 16}
                               : VoxelCoord{random.between(1, 39), random.between(1, 50), random.between(1, 36)};
    std::vector<fs::path> parts;
    for (int octant = 0; octant < 8; ++octant) {
      VoxelBox box;
      for (int axis = 0; axis < 3; ++axis) {
        const bool upper = (octant >> axis & 1) != 0;
        box.lo[axis] = upper ? mid[axis] : 0;
        box.hi[axis] = upper ? n[axis] : mid[axis];
      }
      parts.insert(parts.begin() + random.between(0, octant), drawnPart(box));
    }
    const CompositedParts made = compositeParts(parts, silent_);
    EXPECT_EQ(made.volume_share, 1) << seed;
    const ImageDifference difference = compareImages(made.image, whole);
    EXPECT_LE(difference.largest, largestError()) << "seed " << seed << (inside ? ", from inside" : "");
    EXPECT_GT(difference.psnr_db, leastDb()) << "seed " << seed;
    if (picture.aovs.any()) expectPlanesOf(whole, made.image);
    writeImage(made.image, made.metadata, {true}, directory_ / "made.exr");
    EXPECT_EQ(readImageText(directory_ / "made.exr").at("kiln:job"),
              readImageText(directory_ / "whole.exr").at("kiln:job"));
    with_something_ += difference.foreground > 0 ? 1 : 0;
    picture.crop.reset();
  }

  DenseVolume volume_;
  fs::path store_, directory_;
  RenderJob job_;
  Progress silent_;
  int drawn_ = 0, with_something_ = 0;
};

TEST_P(PartialImages, OfOctantsMakeTheWhole) {
  for (std::uint64_t seed = 900; seed < casesOf(906u, 903u); ++seed) checkOctants(seed, seed % 3 == 1);
  EXPECT_GT(with_something_, casesOf(3, 1));
}

// Rims of several parts meet in a pixel.
TEST_P(PartialImages, OfABodyMeetAtItsEdges) {
  volume_ = cheese({{64, 64, 64}, VoxelType::u8}, 3, {0, 200});
  job_.volume = makeStore(volume_, "parts_edges", 32);
  PictureOptions& picture = job_.picture;
  picture.size = {160, 160};
  picture.transfer_function = TransferFunction{0, {{90, {0.9, 0.5, 0.3}, 0}, {110, {0.9, 0.5, 0.3}, 0.9}}};
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    picture.camera = specOf(cameraFrom(volume_.geometry, {1, 0.4, 0.7}, projection));
    const Image whole = drawn("whole.exr", std::nullopt);
    std::vector<fs::path> parts;
    for (const VoxelBox& box : {VoxelBox{{0, 0, 0}, {27, 64, 64}}, VoxelBox{{27, 0, 0}, {64, 41, 64}},
                                VoxelBox{{27, 41, 0}, {64, 64, 30}}, VoxelBox{{27, 41, 30}, {64, 64, 64}}})
      parts.push_back(drawnPart(box));
    const ImageDifference difference = compareImages(compositeParts(parts, silent_).image, whole);
    EXPECT_LE(difference.largest, largestError());
    EXPECT_GT(difference.foreground, 3000u);
  }
}

// A pixel that closes before its alpha reaches one half has a depth, in the whole and in its parts.
using PartialImagesOfRays = PartialImages;
TEST_P(PartialImagesOfRays, ThatCloseEarly_HaveDepthsWhereTheWholeHas) {
  PictureOptions& picture = job_.picture;
  picture.camera = specOf(cameraFrom(volume_.geometry, {1, 0.4, 0.7}, Projection::kOrthographic));
  picture.transfer_function = TransferFunction{0, {{60, {0.9, 0.5, 0.3}, 0}, {200, {0.9, 0.5, 0.3}, 0.05}}};
  picture.opacity_threshold = 0.3;
  picture.aovs.depth = picture.aovs.normal = true;
  const Image whole = drawn("whole.exr", std::nullopt);
  const fs::path below = drawnPart({{0, 0, 0}, {40, 51, 17}}), above = drawnPart({{0, 0, 17}, {40, 51, 37}});
  const Image made = compositeParts({below, above}, silent_).image;
  std::size_t hits = 0;
  for (std::size_t i = 0; i < whole.rgba.size() / 4; ++i) {
    const bool hit = std::isfinite(whole.planes[1].values[i]);
    EXPECT_EQ(std::isfinite(made.planes[1].values[i]), hit) << i;
    hits += hit ? 1 : 0;
  }
  EXPECT_GT(hits, 400u);
}
INSTANTIATE_TEST_SUITE_P(Rays, PartialImagesOfRays, ::testing::Values(Lattice::kPixel));

TEST_P(PartialImages, NightlyOfOctantsMakeTheWholeForManyScenes) {
  for (std::uint64_t seed = 9000; seed < 9200; ++seed) checkOctants(seed, seed % 3 == 1);
  EXPECT_GT(with_something_, 100);
}

INSTANTIATE_TEST_SUITE_P(Lattices, PartialImages, ::testing::Values(Lattice::kPixel, Lattice::kVoxel));

// Parts I/N are boxes that fill the volume.
TEST(VolumeParts, FillTheVolumeWithoutOverlap) {
  const Extent3 dims{70, 33, 128};
  for (const int count : {1, 2, 3, 7, 8, 13, 64}) {
    std::vector<VoxelBox> boxes;
    std::int64_t voxels = 0;
    for (int i = 1; i <= count; ++i) {
      boxes.push_back(boxOfPart({i, count}, dims, 32));
      EXPECT_FALSE(boxes.back().empty()) << i << "/" << count;
      voxels += boxes.back().count();
      for (std::size_t j = 0; j + 1 < boxes.size(); ++j)
        EXPECT_TRUE(intersection(boxes[j], boxes.back()).empty()) << i << "/" << count;
    }
    EXPECT_EQ(voxels, dims.count()) << count;
  }
  EXPECT_EQ(boxOfPart({1, 2}, dims, 32).hi.z, 64);
  EXPECT_THROW(boxOfPart({9, 9}, {2, 2, 2}, 32), Error);
  EXPECT_EQ(partNumbered("3/8"), (PartNumber{3, 8}));
  for (const char* wrong : {"0/8", "9/8", "3", "3/", "/8", "3/8x", "-1/8", "1/65537", ""})
    EXPECT_EQ(partNumbered(wrong), std::nullopt) << wrong;
}

TEST_P(PartialImages, ThatDoNotBelongTogetherAreRefused) {
  job_.picture.size = {8, 8};
  Camera camera;
  camera.projection = Projection::kOrthographic;
  camera.height = 60;
  // Along the diagonal of the index space.
  camera.target = volume_.geometry.worldOf({20, 25, 18});
  camera.eye = volume_.geometry.worldOf({10, 15, 8});
  camera.up = {0.3, 1, 0.1};
  job_.picture.camera = specOf(camera);
  const fs::path lower = drawnPart({{0, 0, 0}, {40, 51, 20}}), upper = drawnPart({{0, 0, 20}, {40, 51, 37}});
  EXPECT_EQ(compositeParts({lower, upper}, silent_).volume_share, 1);
  EXPECT_LT(compositeParts({lower}, silent_).volume_share, 0.6);
  expectRefused({}, "no partial images");
  expectRefused({lower, upper, lower}, "has voxels that");
  expectRefused({lower, drawnPart({{0, 0, 19}, {40, 51, 37}})}, "has voxels that");
  // A ring of three bars, each before the next.
  expectRefused({drawnPart({{0, 0, 16}, {16, 32, 32}}), drawnPart({{16, 0, 0}, {32, 16, 32}}),
                 drawnPart({{0, 16, 0}, {32, 32, 16}})},
                "no order of visibility");
  job_.picture.opacity_threshold = 0.9;
  expectRefused({lower, drawnPart({{0, 0, 20}, {40, 51, 37}})}, "visibility: is another than in");
  job_.picture.opacity_threshold = 0.998;
  job_.picture.camera.height = 61;
  expectRefused({lower, drawnPart({{0, 0, 20}, {40, 51, 37}})}, "camera: is another than in");
  job_.picture.camera.height = 60;
  volume_.set(3, 3, 3, 77);
  job_.volume = makeStore(volume_, "other", 16);
  expectRefused({lower, drawnPart({{0, 0, 20}, {40, 51, 37}})}, "volume: is another than in");
  job_.picture.clipping.part.reset();
  drawn("whole.exr", std::nullopt);
  expectRefused({directory_ / "whole.exr"}, "whole.exr: kiln:volume: is not in the header");
}

// Other programs keep the header of a picture that they move or whose alpha they leave out.
TEST_P(PartialImages, ThatOtherProgramsChanged_areRefused) {
  job_.picture.size = {8, 6};
  const fs::path part = drawnPart({{0, 0, 0}, {40, 51, 20}}), changed = directory_ / "changed.exr";
  Image image = readImage(part);
  ImageMetadata metadata;
  metadata.text = readImageText(part);
  for (const char* const own : {"name", "type"}) metadata.text.erase(own);
  metadata.whole = {0, 0, 8, 6};
  writeImage(image, metadata, {true}, changed);
  EXPECT_EQ(compositeParts({changed}, silent_).image.rgba, compositeParts({part}, silent_).image.rgba);
  metadata.whole = {2, 1, 16, 16};
  writeImage(image, metadata, {true}, changed);
  expectRefused({changed}, "dataWindow: 8 x 6 samples from (2, 1) on, expected 8 x 6 from (0, 0) on");
  metadata.whole = {0, 0, 8, 6};
  image.rgba = {};
  for (const char* const name : {"R", "G", "B"}) image.planes.push_back({name, ZeroPages<float>(48)});
  writeImage(image, metadata, {true}, changed);
  expectRefused({changed}, "changed.exr: channel A: is missing");
}

}  // namespace
}  // namespace kiln::test
