// Exact methods on real volumes change no bit of the picture. For every threshold, view, projection and transfer
// function, `mask`, `range-tree` and `overlay` draw the picture of `none`, and visit no more.
#include <gtest/gtest.h>

#include "convert/convert.h"
#include "ingest/open_source.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/volumes/random_scene.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

class RealExactness : public ::testing::Test {
 protected:
  // Converts a file of the data folder, or skips.
  void open(const char* file) {
    const fs::path input = fs::path(KILN_TEST_DATA_DIR) / file;
    if (!fs::exists(input)) GTEST_SKIP() << input << " is not here";
    store_ = freshDirectory("store") / "volume.kiln";
    Progress silent;
    convert(*openSource(input), store_, {}, silent);
  }

  void check(std::uint64_t first_seed, int scenes) {
    if (store_.empty()) return;
    const StoreReader reader(store_);
    const VolumeGeometry& volume = reader.level(0).geometry;
    int culled = 0;
    for (int i = 0; i < scenes; ++i) {
      const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
      Random random(seed);
      FrameRequest request;
      request.lattice = Lattice::kVoxel;
      request.view = resolve(randomCamera(random, volume), {210, 170});
      request.transfer_function = randomTransferFunction(random, reader.manifest().range, volume.meanSpacing());
      request.shading = randomShading(random);
      request.opacity_threshold = random.uniform(0.2, 1);
      request.visibility.method = VisibilityMethod::kNone;
      FrameStatistics all;
      const Image truth = draw(store_, request, 1ull << 30, &all);
      for (const VisibilityMethod method :
           {VisibilityMethod::kMask, VisibilityMethod::kRangeTree, VisibilityMethod::kOverlay}) {
        request.visibility = {method, random.chance(0.5) ? ProjectedArea::kBox : ProjectedArea::kSphere};
        request.visibility.test_samples = random.chance(0.5);
        request.tile_px = random.chance(0.5) ? 64 : 0;
        FrameStatistics some;
        EXPECT_EQ(truth.rgba, draw(store_, request, 1ull << 30, &some).rgba)
            << "method " << static_cast<int>(method) << ", seed " << seed;
        EXPECT_LE(some.voxels_visited, all.voxels_visited);
        culled += some.voxels_visited < all.voxels_visited ? 1 : 0;
      }
    }
    EXPECT_GT(culled, scenes / 2);
  }

  fs::path store_;
};

TEST_F(RealExactness, OfABrain) {
  open("raw/brainsmall_128x128x84_u8.nhdr");
  check(1, 3);
}
TEST_F(RealExactness, NightlyOfManyScenesOfAHead) {
  open("cthead_256x256x113_u16le.nrrd");
  check(1000, 100);
}
TEST_F(RealExactness, NightlyOfManyScenesOfAnEngine) {
  open("raw/engine.nhdr");
  check(2000, 200);
}

}  // namespace
}  // namespace kiln::test
