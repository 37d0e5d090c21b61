// A voxel far outside the range of all others, as files use for missing data, changes no picture except at its
// position. Known from the volume without this voxel, drawn with a function that hides the value.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "image/compare.h"
#include "job/transfer_function_choice.h"
#include "scene/transfer/presets.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/reference/lattices.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

constexpr ImageSize kStraySize{70, 66};
constexpr float kInfinite = std::numeric_limits<float>::infinity();

// 30 in the middle, falling with the distance from the middle; a corner voxel has the value `corner`.
DenseVolume ballBeside(float corner) {
  DenseVolume out = fill({{41, 40, 39}, VoxelType::f32}, [](auto i, auto j, auto k) {
    const glm::dvec3 at(i - 20.0, j - 19.5, k - 19.0);
    return std::max(0.0, 30.0 - 1.6 * glm::length(at));
  });
  out.set(0, 0, 0, corner);
  return out;
}

class StrayValues : public ::testing::TestWithParam<Lattice> {
 protected:
  static Image drawn(const DenseVolume& volume, const TransferFunction& function) {
    FrameRequest request;
    setLattice(request, GetParam());
    request.level = 0;
    request.transfer_function = function;
    request.shading.specular = 0.3;
    request.view = resolve(cameraFrom(volume.geometry, {0.6, -1, 0.3}, Projection::kPerspective), kStraySize);
    return draw(makeStore(volume, "stray", 32), request);
  }
};

TEST_P(StrayValues, LeaveTheOthersAsTheyAre) {
  const TransferFunction shell{1, {{9, {0.9, 0.7, 0.5}, 0}, {11, {0.9, 0.7, 0.5}, 0.9}, {40, {1, 1, 1}, 0}}};
  const Image clean = drawn(ballBeside(0), shell);
  ASSERT_TRUE(showsSomething(clean));
  for (const float stray : {1e5f, -1e6f, 1e8f, 1e30f, 9.97e36f, -3.4e38f, kInfinite, -kInfinite})
    EXPECT_GE(compareImages(clean, drawn(ballBeside(stray), shell)).foreground_psnr_db, 50) << stray;
}

TEST_P(StrayValues, ArePassedOverByPresets) {
  const auto functionFor = [](const DenseVolume& volume, const char* preset) {
    return presetFor(preset, StoreReader(makeStore(volume, "preset", 32)).manifest());
  };
  for (const char* preset : {"auto", "solid:10", "iso:10"}) {
    if (preset == std::string_view("iso:10") && GetParam() == Lattice::kVoxel) continue;  // draws no surfaces
    const Image clean = drawn(ballBeside(0), functionFor(ballBeside(0), preset));
    for (const float stray : {-9999.f, -3.4e38f, -kInfinite}) {
      const Image found = drawn(ballBeside(stray), functionFor(ballBeside(stray), preset));
      EXPECT_GE(compareImages(clean, found).foreground_psnr_db, 40) << preset << " " << stray;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lattices, StrayValues, ::testing::ValuesIn(kLattices));

}  // namespace
}  // namespace kiln::test
