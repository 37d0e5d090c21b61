// The phantoms as figures in closed form. Known from anatomy: a man has these parts, two sides, a skin around
// everything and air enclosed by the skin.
#include "phantom/phantom.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "base/hash.h"
#include "phantom/noise.h"

namespace kiln::phantom {
namespace {

const Figure& body() {
  static const Figure figure(findPhantom("body")->parts());
  return figure;
}

// Returns a point inside one of the part's shapes.
glm::vec3 pointIn(const Figure& figure, const Part& part, std::mt19937& random) {
  std::uniform_real_distribution<float> unit(-1, 1);
  for (;;) {
    const Shape& shape = figure.shapes()[part.first + random() % part.count];
    const glm::vec3 p(shape.centre[0] + unit(random) * shape.extent[0],
                      shape.centre[1] + unit(random) * shape.extent[1],
                      shape.centre[2] + unit(random) * shape.extent[2]);
    if (!shape.carves && distanceTo(shape, p.x, p.y, p.z) < 0) return p;
  }
}

std::vector<std::uint16_t> voxelsOf(const Phantom& phantom, const VoxelBox& box) {
  std::vector<std::uint16_t> out(static_cast<std::size_t>(box.count()));
  phantom.read(box, std::as_writable_bytes(std::span(out)));
  return out;
}

TEST(PhantomFigure, EveryPartIsThereAndUnderTheSkin) {
  // Known: a part without points of its own would be hidden by the parts that override it.
  const Figure& figure = body();
  std::mt19937 random(1);
  std::set<std::string> names;
  for (PartId id = 0; id < figure.parts().size(); ++id) {
    const Part& part = figure.parts()[id];
    EXPECT_TRUE(names.insert(part.name).second) << part.name << " is there twice";
    bool found = false;
    for (int attempt = 0; attempt < 400 && !found; ++attempt) {
      const glm::vec3 p = pointIn(figure, part, random);
      if (figure.placeAt(p).part != id) continue;
      found = true;
      EXPECT_LT(figure.depthIn(figure.parts()[0], p).outer, 0) << part.name << " sticks out of the skin";
    }
    EXPECT_TRUE(found) << part.name;
  }
  EXPECT_GE(names.size(), 250u);
  for (const char* name : {"cranium",        "mandible",     "vertebra C7",   "vertebra T12", "vertebra L5",
                           "sacrum",         "sternum",      "left rib 1",    "right rib 12", "left clavicle",
                           "right scapula",  "left humerus", "left ulna",     "left radius",  "phalanges of the thumb",
                           "right hip bone", "left femur",   "right patella", "left tibia",   "left fibula",
                           "left calcaneus", "heart",        "liver",         "left kidney",  "spleen",
                           "left lung",      "trachea",      "stomach",       "colon"}) {
    EXPECT_TRUE(names.contains(name) || names.contains(std::string("left ") + name)) << name;
  }
}

TEST(PhantomFigure, FacesTowardsMinusY) {
  // Known: LPS, so the nose is at -y, the heels at +y, the vertex above and the heart left of the middle.
  EXPECT_EQ(findPhantom("body")->frame, PatientFrame::kLps);
  EXPECT_NE(body().tissueAt({0, -117, 1701}), Tissue::kAir);
  EXPECT_EQ(body().tissueAt({0, 130, 1701}), Tissue::kAir);
  EXPECT_NE(body().tissueAt({90, 95, 50}), Tissue::kAir);
  EXPECT_EQ(body().tissueAt({0, 0, 1865}), Tissue::kAir);
  const Part* heart = body().find("heart");
  ASSERT_TRUE(heart);
  EXPECT_LT(body().depthIn(*heart, {40, -50, 1330}).outer, 0);
  EXPECT_GT(body().depthIn(*heart, {-60, -50, 1330}).outer, 0);
}

TEST(PhantomFigure, LimbsAreMirrorImages) {
  // Known: arms and legs are written once, for the left; only the trunk's and the head's contents have sides.
  std::mt19937 random(2);
  std::uniform_real_distribution<float> x(20, 290), y(-165, 165), z(20, 820);
  int different = 0, solid = 0;
  for (int i = 0; i < 800; ++i) {
    const glm::vec3 p(x(random), y(random), z(random));
    const Tissue left = body().tissueAt(p), right = body().tissueAt({-p.x, p.y, p.z});
    solid += left != Tissue::kAir;
    different += left != right;  // possible by rounding on a surface
  }
  EXPECT_GT(solid, 80);
  EXPECT_LE(different, 2);
}

TEST(PhantomFigure, VoxelsAreTheTissueWithinTheNoise) {
  // Known: a voxel surrounded by a single tissue has the tissue's value; the noise ends at 3.46 standard deviations.
  // Voxels of a quarter of a millimetre also lie deep in thin bone.
  const Phantom phantom(*findPhantom("body"), {2348, 1364, 7512});
  const Lattice& lattice = phantom.lattice();
  std::mt19937 random(3);
  std::map<Tissue, int> seen;
  for (int i = 0; i < 1500; ++i) {
    const Part& part = phantom.figure().parts()[random() % phantom.figure().parts().size()];
    const glm::vec3 p = pointIn(phantom.figure(), part, random) + (i % 5 == 0 ? glm::vec3(60, 0, 0) : glm::vec3(0));
    VoxelCoord v;
    for (int axis = 0; axis < 3; ++axis) {
      v[axis] = static_cast<std::int64_t>((p[axis] - lattice.corner_mm[axis]) / lattice.spacing_mm[axis]);
      v[axis] = std::min(v[axis], lattice.dims[axis] - 1);
    }
    const glm::vec3 centre = lattice.centreOf(v);
    const Tissue tissue = phantom.figure().tissueAt(centre);
    bool deep = true;
    for (int corner = 0; corner < 8 && deep; ++corner) {
      const glm::vec3 offset(corner & 1 ? 0.3f : -0.3f, corner & 2 ? 0.3f : -0.3f, corner & 4 ? 0.3f : -0.3f);
      deep = phantom.figure().tissueAt(centre + offset) == tissue;
    }
    if (!deep) continue;
    ++seen[tissue];
    const double value = voxelsOf(phantom, {v, {v.x + 1, v.y + 1, v.z + 1}})[0];
    EXPECT_NEAR(value, ctValues().of(tissue), 35.5)
        << nameOf(tissue) << " at " << centre.x << " " << centre.y << " " << centre.z;
  }
  for (const Tissue tissue : {Tissue::kAir, Tissue::kFat, Tissue::kMuscle, Tissue::kCorticalBone, Tissue::kMarrow,
                              Tissue::kLung, Tissue::kTooth, Tissue::kGutContent}) {
    EXPECT_GE(seen[tissue], 3) << nameOf(tissue);
  }
}

// The noiseless value of a voxel as defined in sampler.h, from all shapes of all parts.
float compositeOf(const Figure& figure, const glm::vec3& p, float blur_mm, const ValueTable& values) {
  const auto covered = [&](float distance) { return std::clamp(0.5f - distance / blur_mm, 0.f, 1.f); };
  float value = 0, left = 1;
  const auto give = [&](Tissue tissue, float share) {
    value += left * share * values.of(tissue);
    left *= 1 - share;
  };
  for (PartId id = figure.parts().size(); id-- > 0;) {
    const Part& part = figure.parts()[id];
    const Figure::Depth depth = figure.depthIn(part, p);
    const auto rind_mm = static_cast<float>(part.layers.rind_mm);
    if (part.layered()) give(part.layers.inner, covered(depth.inner));
    give(part.layers.outer, covered(depth.outer + rind_mm));
    if (rind_mm > 0) give(part.layers.rind, covered(depth.outer));
  }
  return value + left * values.of(Tissue::kAir);
}

TEST(PhantomFigure, WhatIsFarHasNoSay) {
  // Known: the sampler omits distant shapes, without a visible effect: neither in thin parts of the body nor at
  // junctions, with small voxels or large voxels.
  for (const Extent3& dims : {Extent3{587, 341, 1878}, Extent3{60, 35, 190}}) {
    const Figure& figure = body();
    ValueTable values = ctValues();
    values.noise_sigma = 0;
    const glm::dvec3 extent = findPhantom("body")->extent_mm;
    const Lattice lattice{dims, findPhantom("body")->corner_mm, extent / glm::dvec3(dims.x, dims.y, dims.z)};
    const Sampler sampler(figure, lattice, values, 0);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> unit(-1, 1);
    for (int i = 0; i < 400; ++i) {
      const Part& part = figure.parts()[i % 2 == 0 ? 0 : random() % figure.parts().size()];
      const Shape& shape = figure.shapes()[part.first + random() % part.count];
      VoxelCoord v;
      for (int axis = 0; axis < 3; ++axis) {
        const double at = shape.centre[axis] + 1.2f * unit(random) * shape.extent[axis] - lattice.corner_mm[axis];
        v[axis] = std::clamp<std::int64_t>(static_cast<std::int64_t>(at / lattice.spacing_mm[axis]), 0, dims[axis] - 1);
      }
      std::uint16_t value = 0;
      sampler.sample({v, {v.x + 1, v.y + 1, v.z + 1}}, &value);
      EXPECT_NEAR(value, compositeOf(figure, lattice.centreOf(v), lattice.blurMm(), values), 1.0)
          << v.x << " " << v.y << " " << v.z << " in " << part.name;
    }
  }
}

TEST(PhantomFigure, EdgesBlendOverAboutAVoxel) {
  // Known: coverage is linear in the distance over one voxel. A ball's shares therefore sum to its volume, and the
  // number of partial voxels is its surface.
  const PartList parts = {{"ball", filledWith(Tissue::kMuscle), {ball({0.3, -0.2, 0.1}, 7)}}};
  const Figure figure(parts);
  ValueTable table = ctValues();
  table.values[0] = 0;
  table.values[static_cast<std::size_t>(Tissue::kMuscle)] = 4000;
  table.noise_sigma = 0;
  const Lattice lattice{{20, 20, 20}, {-10, -10, -10}, {1, 1, 1}};
  std::vector<std::uint16_t> voxels(8000);
  Sampler(figure, lattice, table, 1).sample(boxOf(lattice.dims), voxels.data());
  double sum = 0;
  int between = 0;
  for (const std::uint16_t voxel : voxels) {
    sum += voxel / 4000.0;
    between += voxel > 0 && voxel < 4000;
  }
  const double exact = 4.0 / 3 * 3.14159265 * 343;
  EXPECT_NEAR(sum, exact, 0.01 * exact);
  EXPECT_NEAR(between, 4 * 3.14159265 * 49, 90);  // a layer one voxel thick
}

TEST(PhantomNoise, IsNormalIndependentAndOfTheSaidDeviation) {
  // Known: 24³ voxels of liver; the error of the mean is sigma / 118, of a correlation 1 / 118.
  const Phantom phantom(*findPhantom("body"), {587, 341, 1878});
  const VoxelBox box = {{215, 180, 1245}, {239, 204, 1269}};
  const std::vector<std::uint16_t> voxels = voxelsOf(phantom, box);
  const double count = static_cast<double>(voxels.size());
  double mean = 0, square = 0, fourth = 0;
  for (const std::uint16_t v : voxels) mean += v / count;
  for (const std::uint16_t v : voxels) {
    const double d = v - mean;
    square += d * d / count;
    fourth += d * d * d * d / count;
  }
  EXPECT_NEAR(mean, ctValues().of(Tissue::kLiver), 0.35);
  EXPECT_NEAR(std::sqrt(square), ctValues().noise_sigma, 0.25);
  EXPECT_NEAR(fourth / (square * square), 2.7, 0.15);  // four bytes: 3 - 6/5/4
  for (const std::size_t step : {1, 2, 24, 576, 600, 25}) {
    double product = 0;
    for (std::size_t i = 0; i + step < voxels.size(); ++i) product += (voxels[i] - mean) * (voxels[i + step] - mean);
    EXPECT_LT(std::abs(product / count / square), 0.035) << "step " << step;
  }
  const std::vector<std::uint16_t> air = voxelsOf(phantom, {{0, 0, 0}, {40, 40, 20}});
  double air_mean = 0;
  for (const std::uint16_t v : air) air_mean += v / 32000.0;
  EXPECT_NEAR(air_mean, 24, 0.4);  // slightly higher where the noise is clipped at zero
}

TEST(PhantomVolume, InterestingVoxelsAreAsManyAsInThePaper) {
  // Known: [LI] Table 2 counts 84.2 million of 587 x 341 x 1878 for the skin; shares do not depend on the resolution.
  const Phantom phantom(*findPhantom("body"), {73, 43, 235});
  const std::vector<std::uint16_t> voxels = voxelsOf(phantom, boxOf(phantom.lattice().dims));
  double above = 0;
  for (const std::uint16_t v : voxels) above += v > 600;
  const double millions = above / static_cast<double>(voxels.size()) * 587 * 341 * 1878 / 1e6;
  EXPECT_GE(millions, 75);
  EXPECT_LE(millions, 95);
}

// Returns the voxels connected to the outside through air and lung.
std::vector<bool> reachedFromOutside(const std::vector<std::uint16_t>& voxels, const Extent3& dims) {
  std::vector<bool> reached(voxels.size());
  std::vector<std::int64_t> open = {0};
  reached[0] = true;
  while (!open.empty()) {
    const std::int64_t at = open.back();
    open.pop_back();
    const VoxelCoord v{at % dims.x, at / dims.x % dims.y, at / dims.x / dims.y};
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        VoxelCoord to = v;
        to[axis] += step;
        if (!boxOf(dims).contains(to)) continue;
        const std::int64_t index = (to.z * dims.y + to.y) * dims.x + to.x;
        if (reached[static_cast<std::size_t>(index)] || voxels[static_cast<std::size_t>(index)] > 600) continue;
        reached[static_cast<std::size_t>(index)] = true;
        open.push_back(index);
      }
    }
  }
  return reached;
}

// Returns the volume of dark voxels without connection to the outside. unit: litres.
double enclosedLitres(const Phantom& phantom) {
  const Extent3 dims = phantom.lattice().dims;
  const std::vector<std::uint16_t> voxels = voxelsOf(phantom, boxOf(dims));
  const std::vector<bool> reached = reachedFromOutside(voxels, dims);
  double count = 0;
  for (std::size_t i = 0; i < voxels.size(); ++i) count += voxels[i] <= 600 && !reached[i];
  const glm::dvec3 s = phantom.lattice().spacing_mm;
  return count * s.x * s.y * s.z / 1e6;
}

TEST(PhantomVolume, LungsBowelAndSinusesAreClosed) {
  // Known: a man's lungs hold about four litres, the air of his head less than a tenth of a litre. With an open mouth
  // or nose no air would be enclosed.
  const double of_body = enclosedLitres(Phantom(*findPhantom("body"), {84, 49, 268}));
  EXPECT_GT(of_body, 3.5);
  EXPECT_LT(of_body, 8);
  const double of_head = enclosedLitres(Phantom(*findPhantom("head"), {112, 112, 98}));
  EXPECT_GT(of_head, 0.03);
  EXPECT_LT(of_head, 0.2);
}

TEST(PhantomVolume, DoesNotChangeSilently) {
  // Frozen checksums: a phantom's name determines its volume forever, and published figures rely on this. A change of
  // anatomy, values, noise or sampling changes the checksums, and every picture of a phantom. Document such a change at
  // its place, and update the checksums here.
  const struct {
    const char* name;
    Extent3 dims;
    const char* checksum;
  } kFrozen[] = {
      {"body", {73, 43, 235}, "a7c1e44be010d110bb8de5d50f58722a"},
      {"head", {48, 48, 42}, "a102b10c28f7e5a7e5bd23d33a43cf24"},
      {"brain", {48, 48, 32}, "a500a966489246b360d8bdba4e0b4f80"},
      {"engine", {64, 64, 28}, "e0bdf7e77cf9b9a3c4c92e088954f899"},
  };
  for (const auto& frozen : kFrozen) {
    const PhantomKind& kind = *findPhantom(frozen.name);
    std::vector<std::byte> voxels(static_cast<std::size_t>(frozen.dims.count()) * sizeOf(kind.type));
    Phantom(kind, frozen.dims).read(boxOf(frozen.dims), voxels);
    EXPECT_EQ(toHex(hashOf(voxels)), frozen.checksum) << frozen.name;
  }
}

}  // namespace
}  // namespace kiln::phantom
