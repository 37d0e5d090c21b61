// Interpolation between voxels. The reference's is known on polynomials; the kernel of every instruction set is known
// by the reference's: as near as floats come (3e-7 of the range, of gradients as much), and all of them the same bits.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <numeric>
#include <tuple>
#include <vector>

#include "splat/refine_unit.h"
#include "support/reference_field.h"

namespace kiln::test {
namespace {

constexpr Interpolation kInterpolations[] = {Interpolation::kLinear, Interpolation::kCubic, Interpolation::kCatmullRom};
constexpr double kLeastValue = 1, kMostValue = 255;

// Linear functions are kept by all three; of squares the B-spline adds a third, its variance, and Catmull-Rom nothing.
TEST(ReferenceField, IsKnownOnPolynomials) {
  const DenseVolume slope =
      fill({{9, 9, 9}, VoxelType::f64}, [](auto i, auto j, auto k) { return 3.0 * i - 2.0 * j + 0.5 * k; });
  const DenseVolume square = fill({{9, 9, 9}, VoxelType::f64}, [](auto i, auto j, auto) { return 1.0 * i * i + j; });
  for (const glm::dvec3 at : {glm::dvec3(4, 4, 4), glm::dvec3(3.3, 4.9, 3.5), glm::dvec3(4.75, 3.01, 4.2)}) {
    for (const Interpolation interpolation : kInterpolations) {
      const ReferenceField field(slope, interpolation);
      EXPECT_NEAR(field.at(at), glm::dot(at, glm::dvec3(3, -2, 0.5)), 1e-12);
      EXPECT_LT(glm::length(field.gradient(at) - glm::dvec3(3, -2, 0.5)), 1e-12);
      EXPECT_LT(glm::length(ReferenceField(square, interpolation).gradient(at) - glm::dvec3(2 * at.x, 1, 0)), 1e-12);
    }
    const double exact = at.x * at.x + at.y;
    EXPECT_NEAR(ReferenceField(square, Interpolation::kCubic).at(at), exact + 1.0 / 3, 1e-12);
    EXPECT_NEAR(ReferenceField(square, Interpolation::kCatmullRom).at(at), exact, 1e-12);
  }
}

TEST(ReferenceField, CatmullRomStaysWithinItsVoxels) {
  const DenseVolume step = fill({{9, 9, 9}, VoxelType::f64}, [](auto i, auto, auto) { return i < 4 ? 0.0 : 1.0; });
  const ReferenceField field(step, Interpolation::kCatmullRom);
  EXPECT_EQ(field.at({2.5, 4, 4}), 0);
  EXPECT_EQ(field.at({4.5, 4, 4}), 1);
  EXPECT_EQ(field.at({3.5, 4, 4}), 0.5);
}

struct Refined {
  std::vector<SlabSample> samples;
  std::vector<std::int32_t> slabs;
  std::vector<SampleDetails> details;
};

// A lattice whose every sample with a value has extinction `value`, far from all ends.
class Kernel {
 public:
  // Samples of eight voxels along each axis.
  Kernel(Interpolation interpolation, const std::array<int, 3>& samples) {
    for (std::size_t i = 0; i < kMostValue + 2; ++i) {
      extinctions_.push_back(std::min<float>(i, kMostValue));
      table_.push_back({1, 1, 1, extinctions_.back()});
    }
    lattice_.interpolation = interpolation;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto most = static_cast<unsigned>(kRefinedVoxels * kUnitSamples / samples[a]);
      lattice_.voxels[a] = std::min(kUnitVoxels, static_cast<int>(std::bit_floor(most)));
      for (int first = 0; first < kRefinedVoxels; first += lattice_.voxels[a])
        lattice_.axes[a].emplace_back(Refinement{samples[a]}, first, lattice_.voxels[a], interpolation);
    }
    lattice_.step_x = {1, 0, 0}, lattice_.step_y = {0, 1, 0}, lattice_.step_z = {0, 0, 1};
    lattice_.near = -100, lattice_.slabs = 1000;
    lattice_.table = table_.front().data();
    lattice_.extinctions = extinctions_.data();
    lattice_.table_last = kMostValue;
  }

  const UnitLattice& lattice() const { return lattice_; }
  UnitLattice& lattice() { return lattice_; }

  Refined operator()(const DenseVolume& volume, const VoxelCoord& lo) const {
    const auto& n = lattice_.voxels;
    alignas(64) static float values[(kUnitVoxels + 2 * kUnitMargin) * (kUnitVoxels + 2 * kUnitMargin) * kUnitSamples];
    float* to = values;
    for (int z = -kUnitMargin; z < n[2] + kUnitMargin; ++z) {
      for (int y = -kUnitMargin; y < n[1] + kUnitMargin; ++y, to += kUnitSamples) {
        for (int x = -kUnitMargin; x < n[0] + kUnitMargin; ++x)
          to[x + kUnitMargin] = volume.at<float>(lo.x + x, lo.y + y, lo.z + z);
      }
    }
    UnitInput in;
    in.values = values;
    in.least = kLeastValue, in.most = kMostValue;
    in.origin = {lo.x, lo.y, lo.z};
    in.axis = lattice_.axesAt(lo);
    for (std::size_t a = 0; a < 3; ++a) in.end[a] = in.core_end[a] = in.axis[a]->samples;
    in.part_x.fill(1), in.part_y.fill(1), in.part_z.fill(1);
    in.tile = {-1000, -1000, 1000, 1000};
    const std::size_t most = mostRefined(lattice_, in);
    Refined out{std::vector<SlabSample>(most), std::vector<std::int32_t>(most), std::vector<SampleDetails>(most)};
    const auto count = static_cast<std::size_t>(
        refineUnit(lattice_, in, {nullptr, 0, out.samples.data(), out.slabs.data(), out.details.data()}).samples);
    out.samples.resize(count);
    out.slabs.resize(count);
    out.details.resize(count);
    return out;
  }

 private:
  std::vector<std::array<float, 4>> table_;
  std::vector<float> extinctions_;
  UnitLattice lattice_;
};

// Noise with some NaN, of which a voxel without weight may be one.
DenseVolume noiseWithGaps() {
  return fill({{20, 18, 17}, VoxelType::f32}, [](auto i, auto j, auto k) {
    const auto n = static_cast<std::uint64_t>((k * 18 + j) * 20 + i);
    return hashUnit(1, n) < 0.004 ? NAN : kLeastValue + (kMostValue - kLeastValue) * hashUnit(2, n);
  });
}

// Where the samples of voxels [lo, lo + voxels) lie, of so many in each eight.
std::vector<double> placesIn(std::int64_t lo, int voxels, int samples) {
  std::vector<double> out;
  for (int i = 0; i < 8 * samples; ++i) {
    const double place = (i + 0.5) * 8 / samples;  // from the first voxel's face
    if (place >= static_cast<double>(lo) && place < static_cast<double>(lo + voxels)) out.push_back(place - 0.5);
  }
  return out;
}

// Each sample of the unit, in the kernel's order, against the field.
void expectField(const Refined& refined, const UnitLattice& lattice, const std::array<int, 3>& samples,
                 const ReferenceField& field, const VoxelCoord& lo) {
  std::size_t next = 0;
  double worst = 0, worst_slope = 0;
  int missing = 0;
  std::vector<double> along[3];
  for (int a = 0; a < 3; ++a)
    along[a] = placesIn(lo[a], lattice.voxels[static_cast<std::size_t>(a)], samples[static_cast<std::size_t>(a)]);
  for (const double z : along[2]) {
    for (const double y : along[1]) {
      for (const double x : along[0]) {
        const glm::dvec3 index(x, y, z);
        const double value = field.at(index);
        if (std::isnan(value)) {
          ++missing;
          continue;
        }
        ASSERT_LT(next, refined.details.size());
        const SampleDetails& found = refined.details[next++];
        ASSERT_LT(glm::length(glm::dvec3(found.view) - index), 1e-5);
        worst = std::max(worst, std::abs(found.tau - value));
        const glm::dvec3 slope = field.gradient(index);
        const bool finite = !std::isnan(slope.x + slope.y + slope.z);
        worst_slope = std::max(worst_slope, glm::length(glm::dvec3(found.gradient) - (finite ? slope : glm::dvec3(0))));
      }
    }
  }
  EXPECT_EQ(next, refined.details.size());
  EXPECT_LT(worst, 3e-7 * (kMostValue - kLeastValue));
  EXPECT_LT(worst_slope, 3e-7 * (kMostValue - kLeastValue));
  EXPECT_GT(next, 0u);
}

template <class T>
bool equalBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

// By place and slab: of a vector's samples those in a third slab come last.
Refined sorted(const Refined& refined) {
  std::vector<std::size_t> order(refined.samples.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::size_t i) {
    const glm::vec3& at = refined.details[i].offset;
    return std::tuple(at.z, at.y, at.x, refined.slabs[i]);
  };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  Refined out;
  for (const std::size_t i : order) {
    out.samples.push_back(refined.samples[i]);
    out.slabs.push_back(refined.slabs[i]);
    out.details.push_back(refined.details[i]);
  }
  return out;
}

void expectSameOnEveryInstructionSet(const Kernel& kernel, const DenseVolume& volume, const VoxelCoord& lo,
                                     const Refined& best) {
  for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
    hwy::SetSupportedTargetsForTest(rest & -rest);
    const Refined other = kernel.lattice().three_slabs ? sorted(kernel(volume, lo)) : kernel(volume, lo);
    EXPECT_TRUE(equalBits(best.samples, other.samples)) << instructionSet();
    EXPECT_TRUE(equalBits(best.slabs, other.slabs)) << instructionSet();
    EXPECT_TRUE(equalBits(best.details, other.details)) << instructionSet();
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(RefineUnit, IsTheReferencesInterpolationOnEveryInstructionSet) {
  const DenseVolume volume = noiseWithGaps();
  const std::array<int, 3> refinements[] = {{8, 8, 8},   {16, 16, 16}, {24, 32, 40},
                                            {8, 24, 16}, {128, 56, 8}, {13, 9, 21}};
  for (const Interpolation interpolation : kInterpolations) {
    const ReferenceField field(volume, interpolation);
    for (const auto& refinement : refinements) {
      const Kernel kernel(interpolation, refinement);
      const std::array<int, 3>& n = kernel.lattice().voxels;
      for (const VoxelCoord lo : {VoxelCoord{0, 0, 0}, VoxelCoord{8, 8, 8}, VoxelCoord{8 - n[0], 8 - n[1], n[2] % 8}}) {
        SCOPED_TRACE(testing::Message() << static_cast<int>(interpolation) << " samples of 8 voxels: " << refinement[0]
                                        << ", " << refinement[1] << ", " << refinement[2] << " from " << lo.x);
        const Refined best = kernel(volume, lo);
        expectField(best, kernel.lattice(), refinement, field, lo);
        expectSameOnEveryInstructionSet(kernel, volume, lo, best);
      }
    }
  }
}

// What of two boxes folded lies between two places from their middle, summed in steps. unit: slabs.
double partIn(const DepthSpread& spread, double from, double to) {
  constexpr int kSteps = 400;
  const double a = static_cast<double>(spread.a), b = static_cast<double>(spread.b);
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = from + (to - from) * (i + 0.5) / kSteps;
    sum += std::clamp(((a + b) / 2 - std::abs(t)) / b, 0.0, 1.0) / a;
  }
  return sum * (to - from) / kSteps;
}

// Vectors of several lengths hold other samples beside those that the zone cuts.
TEST(RefineUnit, IsTheSameOnEveryInstructionSetWhereAZoneEnds) {
  const DenseVolume volume = noiseWithGaps();
  for (const bool gaps : {false, true}) {
    Kernel kernel(Interpolation::kLinear, {16, 16, 16});
    UnitLattice& lattice = kernel.lattice();
    lattice.step_x = {0.8f, 0, 0.6f}, lattice.step_z = {-0.6f, 0, 0.8f};
    lattice.near = 9.3f, lattice.slabs = 5;
    lattice.spread = {1.1f, 0.7f, 0.9f};
    lattice.gaps = gaps;
    lattice.light.phong = true, lattice.light.ambient = 0.2f, lattice.light.diffuse = 0.8f,
    lattice.light.specular = 0.2f;
    lattice.light.power = 16;
    const Refined best = kernel(volume, {8, 8, 8});
    const auto cut = std::count_if(best.samples.begin(), best.samples.end(),
                                   [](const SlabSample& s) { return s.front + s.back < 0.9f; });
    EXPECT_GT(cut, 100);
    EXPECT_LT(cut, static_cast<std::ptrdiff_t>(best.samples.size()) / 2);
    expectSameOnEveryInstructionSet(kernel, volume, {8, 8, 8}, best);

    // As much of each sample, in the slabs where it is.
    lattice.three_slabs = true;
    const Refined in_three = sorted(kernel(volume, {8, 8, 8}));
    EXPECT_GT(in_three.samples.size(), best.samples.size() * 6 / 5);
    std::size_t next = 0;
    double worst = 0;
    for (std::size_t i = 0; i < best.samples.size(); ++i) {
      const SlabSample& first = in_three.samples.at(next);
      ASSERT_EQ(in_three.slabs[next], best.slabs[i]);
      const double depth = (static_cast<double>(best.details[i].view.z) - static_cast<double>(lattice.near));
      const auto expect = [&](int slab, float part) {
        const double own = slab < lattice.slabs ? partIn(lattice.spread, slab - depth, slab + 1 - depth) : 0;
        worst = std::max(worst, std::abs(static_cast<double>(part) - own));
      };
      expect(best.slabs[i], first.front);
      expect(best.slabs[i] + 1, first.back);
      if (++next < in_three.samples.size() && in_three.details[next].offset == best.details[i].offset) {
        EXPECT_EQ(in_three.slabs[next], best.slabs[i] + 2);
        EXPECT_LT(in_three.slabs[next], lattice.slabs);
        EXPECT_FALSE(in_three.samples[next].place.counted());
        EXPECT_EQ(in_three.samples[next].back, 0);
        expect(best.slabs[i] + 2, in_three.samples[next++].front);
      } else {
        expect(best.slabs[i] + 2, 0);
      }
    }
    EXPECT_EQ(next, in_three.samples.size());
    EXPECT_LT(worst, 2e-5);
    expectSameOnEveryInstructionSet(kernel, volume, {8, 8, 8}, in_three);
  }
}

}  // namespace
}  // namespace kiln::test
