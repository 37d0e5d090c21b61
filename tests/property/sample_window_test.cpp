// What is left out of a unit because it is elsewhere must be nothing of the tile's: a unit refined as a whole gives the
// tile the same samples as what is left of it, and each of them lies where its voxels are said to be seen. Eyes beside
// and within the unit's voxels, where most of a unit is elsewhere.
#include "splat/sample_window.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "frame/frame_levels.h"
#include "splat/slab_frame.h"
#include "support/random_scene.h"
#include "support/sanitized.h"
#include "support/test_store.h"

namespace kiln::test {
namespace {

// Every sample shows something.
struct Unit {
  alignas(
      64) std::array<float, (kUnitVoxels + 2 * kUnitMargin) * (kUnitVoxels + 2 * kUnitMargin) * kUnitSamples> values;
  UnitInput in;

  Unit(const SlabFrame& frame, const UnitLattice& lattice, const VoxelCoord& lo, const PixelRect& tile) {
    values.fill(200);
    in.values = values.data();
    in.least = 0, in.most = 255;
    in.origin = glm::vec3(frame.projector().viewOf(lo));
    in.axis = lattice.axesAt(lo);
    for (std::size_t a = 0; a < 3; ++a) in.end[a] = in.core_end[a] = in.axis[a]->samples;
    in.tile = tile;
  }
  std::uint64_t samples() const {
    std::uint64_t product = 1;
    for (std::size_t a = 0; a < 3; ++a) product *= static_cast<std::uint64_t>(std::max(0, in.end[a] - in.first[a]));
    return product;
  }
};

struct Refined {
  std::vector<SlabSample> samples;
  std::vector<std::int32_t> slabs;
  std::vector<SampleDetails> details;
  std::size_t count = 0;

  Refined(const UnitLattice& lattice, const UnitInput& in)
      : samples(mostRefined(lattice, in)), slabs(samples.size()), details(samples.size()) {
    count = static_cast<std::size_t>(
        refineUnit(lattice, in, {nullptr, 0, samples.data(), slabs.data(), details.data()}).samples);
  }
  bool operator==(const Refined& other) const {
    return count == other.count && std::memcmp(samples.data(), other.samples.data(), count * sizeof(samples[0])) == 0 &&
           std::memcmp(slabs.data(), other.slabs.data(), count * sizeof(slabs[0])) == 0;
  }
};

struct Seen {
  std::uint64_t samples = 0, left = 0, reach = 0;
  int soft = 0;  // zones
};

// A unit about `lo` in each zone where it is seen, and a tile of those that it may touch.
void check(const Manifest& volume, const FrameRequest& request, const VoxelCoord& at, Random& random, Seen& seen) {
  const FrameLevels levels(volume, 0, request.view, ProjectedArea::kBox);
  const SampleTable table(request.transfer_function, 1, volume.type, volume.range);
  const Projector& projector = levels.projector(0);
  const SampleLook look{request.shading,
                        Shader(request.shading, request.view, 0.0f, projector),
                        GradientOpacity(),
                        &levels.clipRegion(0),
                        0.0f,
                        Interpolation::kLinear};
  const ZonedVolume zoned{&volume, projector.nearDepth(), INFINITY, SoftSamples::kAnyway};
  for (const SlabZone& zone : slabZones(zoned, request.view, 0)) {
    const SlabFrame frame(zone, projector, levels.dims(0), levels.endVoxels(0), table, look);
    const bool soft = frame.softLattice() != nullptr && random.chance(0.5);
    seen.soft += soft ? 1 : 0;
    const UnitLattice& l = soft ? *frame.softLattice() : frame.lattice();
    const VoxelCoord lo = {at.x & ~(l.voxels[0] - 1), at.y & ~(l.voxels[1] - 1), at.z & ~(l.voxels[2] - 1)};
    const SlabFrame::Bounds bounds = frame.boundsOf({lo, {lo.x + l.voxels[0], lo.y + l.voxels[1], lo.z + l.voxels[2]}});
    const ImageSize& size = request.view.size;
    const PixelRect all{0, 0, size.width, size.height}, touched_by = intersection(bounds.rect, all);
    const PixelRect& from = touched_by.empty() ? all : touched_by;
    const int x = random.between(from.x0, from.x1 - 1) & ~63, y = random.between(from.y0, from.y1 - 1) & ~63;
    const PixelRect tile = intersection({x, y, x + 64, y + 64}, all);
    Unit unit(frame, l, lo, tile);
    const Refined whole(l, unit.in);
    seen.samples += unit.samples();
    if (!SampleWindow(l, frame.sampleReach(), tile).narrow(unit.in)) unit.in.end = unit.in.first;
    seen.left += unit.samples();
    seen.reach += whole.count;
    ASSERT_EQ(whole, Refined(l, unit.in));
    for (std::size_t i = 0; i < whole.count; ++i) {
      const glm::dvec2 px = projector.pixelOf(glm::dvec3(whole.details[i].view));
      const double r = frame.footprint().radius();
      const PixelRect touched = intersection({static_cast<int>(px.x - r), static_cast<int>(px.y - r),
                                              static_cast<int>(px.x + r) + 1, static_cast<int>(px.y + r) + 1},
                                             tile);
      ASSERT_TRUE(touched.empty() || bounds.rect.contains(touched));
      ASSERT_LE(bounds.first, whole.slabs[i]);
      ASSERT_GE(bounds.last, whole.slabs[i]);
    }
  }
}

TEST(SampleWindow, LeavesAllThatReachTheTile) {
  std::vector<StoreReader> stores;
  for (const glm::dmat4& affine : {glm::dmat4(1), anisotropicAffine(), obliqueAffine()}) {
    const VolumeShape shape{{48, 48, 48}, VoxelType::u8, affine};
    stores.emplace_back(makeStore(noise(shape, 1, {0, 255}), "window_" + std::to_string(stores.size()), 64));
  }
  Seen seen;
  for (std::uint64_t seed = 0; seed < casesOf(150u, 20u); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const Manifest& volume = stores[seed % stores.size()].manifest();
    FrameRequest request;
    Camera camera = randomCamera(random, volume.geometry());
    const VoxelCoord at = {random.between(0, 47), random.between(0, 47), random.between(0, 47)};
    // Beside the unit, or within it.
    if (random.chance(0.8)) {
      camera.projection = Projection::kPerspective;
      const glm::dvec3 beside(random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(-4, 4));
      camera.eye = volume.geometry().worldOf(glm::dvec3(at.x, at.y, at.z) + beside);
    }
    request.view = resolve(camera, {random.between(60, 400), random.between(60, 300)});
    request.transfer_function = {1, {{0, {1, 1, 1}, 0.5}, {255, {1, 1, 1}, 0.5}}};
    check(volume, request, at, random, seen);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(seen.reach, casesOf(50000u, 5000u));
  EXPECT_GT(seen.soft, casesOf(50, 5));
  EXPECT_LT(seen.left, seen.samples / 10);
}

}  // namespace
}  // namespace kiln::test
