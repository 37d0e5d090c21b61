// Sides of slices. Known: the volume is written in LPS by a formula with a mark in the upper right front corner of the
// patient; the 48 orders and directions of its axes of voxels are the same volume, so pictures are equal to the bit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "frame/plane_slice.h"
#include "frame/slice.h"
#include "image/srgb.h"
#include "store/codec/brick_block.h"
#include "store/store_reader.h"
#include "support/system/expect_error.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// Voxels to the patient's left, back and head, and their edges. Rows of pixels of coronal slices are no whole number of
// pixels for each voxel.
constexpr std::array<std::int64_t, 3> kPatientVoxels = {14, 11, 18};
constexpr std::array<double, 3> kVoxelEdges = {1, 1, 1.3};
constexpr double kMark = 250;

double markedValue(const std::array<std::int64_t, 3>& lps) {
  if (lps[0] < 2 && lps[1] < 2 && lps[2] >= kPatientVoxels[2] - 2) return kMark;
  return static_cast<double>(3 * lps[0] + 5 * lps[1] + 7 * lps[2]);
}

// An order and directions of the axes of voxels: axis i runs along patient axis `order[i]`, towards LPS or away.
struct VoxelTurn {
  std::array<int, 3> order = {0, 1, 2};
  std::array<bool, 3> mirrored{};
  PatientFrame frame = PatientFrame::kLps;
};

std::vector<VoxelTurn> allTurns() {
  constexpr std::array<int, 3> kOrders[] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  std::vector<VoxelTurn> out;
  for (const auto& order : kOrders) {
    for (int bits = 0; bits < 8; ++bits) {
      const std::array<bool, 3> mirrored = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
      out.push_back({order, mirrored, out.size() % 3 == 0 ? PatientFrame::kLps : PatientFrame::kRas});
    }
  }
  return out;
}

std::string lettersOf(const VoxelTurn& turn) {
  std::string out;
  for (std::size_t axis = 0; axis < 3; ++axis)
    out += std::string("LPSRAI").substr(static_cast<std::size_t>(turn.order[axis] + (turn.mirrored[axis] ? 3 : 0)), 1);
  return out;
}

// The volume; `tilt` adds parts of other axes to each axis, below the half that would change the nearest axis.
DenseVolume turnedVolume(const VoxelTurn& turn, double tilt = 0) {
  std::array<std::int64_t, 3> counts{};
  glm::dmat4 affine(1);
  for (int axis = 0; axis < 3; ++axis) {
    const auto along = static_cast<std::size_t>(turn.order[static_cast<std::size_t>(axis)]);
    const bool mirrored = turn.mirrored[static_cast<std::size_t>(axis)];
    counts[static_cast<std::size_t>(axis)] = kPatientVoxels[along];
    glm::dvec4 column(0);
    column[static_cast<int>(along)] = mirrored ? -kVoxelEdges[along] : kVoxelEdges[along];
    column[static_cast<int>((along + 1) % 3)] = tilt * kVoxelEdges[along];
    affine[axis] = column;
  }
  affine[3] = {5, -7, 11, 1};
  if (turn.frame == PatientFrame::kRas)
    affine = glm::dmat4({-1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}) * affine;
  DenseVolume out = fill({{counts[0], counts[1], counts[2]}, VoxelType::u8, affine},
                         [&](std::int64_t i, std::int64_t j, std::int64_t k) {
                           std::array<std::int64_t, 3> lps{};
                           const std::array<std::int64_t, 3> voxel = {i, j, k};
                           for (std::size_t axis = 0; axis < 3; ++axis) {
                             const auto along = static_cast<std::size_t>(turn.order[axis]);
                             lps[along] = turn.mirrored[axis] ? kPatientVoxels[along] - 1 - voxel[axis] : voxel[axis];
                           }
                           return markedValue(lps);
                         });
  out.geometry.frame = turn.frame;
  return out;
}

// The voxel of `turn` along patient axis `along` that is voxel `lps` of the volume in LPS.
std::int64_t voxelInTurn(const VoxelTurn& turn, int along, std::int64_t lps) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (turn.order[axis] == along)
      return turn.mirrored[axis] ? kPatientVoxels[static_cast<std::size_t>(along)] - 1 - lps : lps;
  }
  return -1;
}

struct Named {
  const char* name;
  int along;            // patient axis across the slices
  std::int64_t at;      // a slice through the mark, which is the picture's upper left corner
  const char* letters;  // left, right, top, bottom
};
constexpr Named kPlanes[] = {{"axial", 2, 17, "RLAP"}, {"coronal", 1, 0, "RLSI"}, {"sagittal", 0, 1, "APSI"}};

Image drawSlice(const BrickedVolume& store, const char* axis, std::optional<std::int64_t> index = {}) {
  SliceRequest request;
  request.axis = sliceAxis(store.level(0).geometry, axis);
  request.index = index;
  request.window = Window{127.5, 255};
  Progress progress;
  return renderSlice(store, request, progress);
}

std::string textOf(const EdgeLetters& letters) { return {letters.left, letters.right, letters.top, letters.bottom}; }

bool isMark(const float* pixel) { return std::abs(srgbFromLinear(pixel[0]) - kMark / 255) < 1e-3; }

TEST(SliceSides, MarkOfThePatient_liesInTheCornerOfTheConvention) {
  const StoreReader store(makeStore(turnedVolume({}), "slice_sides_lps", 8));
  for (const Named& plane : kPlanes) {
    const Image image = drawSlice(store, plane.name, plane.at);
    const int right = image.width - 1, bottom = image.height - 1;
    EXPECT_TRUE(isMark(image.pixel(0, 0))) << plane.name;
    EXPECT_TRUE(isMark(image.pixel(1, 1))) << plane.name;
    for (const auto& [x, y] : {std::pair{right, 0}, {0, bottom}, {right, bottom}, {4, 4}})
      EXPECT_FALSE(isMark(image.pixel(x, y))) << plane.name << " " << x << " " << y;
  }
}

TEST(SliceSides, AllOrdersAndDirectionsOfVoxels_haveOnePicture) {
  const StoreReader plain(makeStore(turnedVolume({}), "slice_sides_plain", 8));
  for (const VoxelTurn& turn : allTurns()) {
    const StoreReader store(makeStore(turnedVolume(turn), "slice_sides_" + lettersOf(turn), 8));
    const VolumeGeometry& volume = store.level(0).geometry;
    for (const Named& plane : kPlanes) {
      SCOPED_TRACE(fmt::format("{} {}", lettersOf(turn), plane.name));
      const Image expected = drawSlice(plain, plane.name, plane.at);
      const Image image = drawSlice(store, plane.name, voxelInTurn(turn, plane.along, plane.at));
      ASSERT_EQ(image.width, expected.width);
      ASSERT_EQ(image.height, expected.height);
      EXPECT_EQ(image.rgba, expected.rgba);
      // Slices of an even number have no middle one.
      EXPECT_EQ(drawSlice(store, plane.name).rgba, drawSlice(plain, plane.name).rgba);
      const SliceView view = sliceViewAcross(volume, sliceAxis(volume, plane.name));
      EXPECT_STREQ(view.plane, plane.name);
      EXPECT_EQ(textOf(view.letters), plane.letters);
      // The names of axes are the patient's slices, too.
      const std::string axis(1, "xyz"[view.across.index]);
      EXPECT_EQ(drawSlice(store, axis.c_str(), voxelInTurn(turn, plane.along, plane.at)).rgba, expected.rgba);
    }
    const VoxelCoord middle = middleVoxel(volume);
    for (int along = 0; along < 3; ++along) {
      for (int axis = 0; axis < 3; ++axis) {
        if (turn.order[static_cast<std::size_t>(axis)] != along) continue;
        EXPECT_EQ(middle[axis], voxelInTurn(turn, along, kPatientVoxels[static_cast<std::size_t>(along)] / 2));
      }
    }
  }
}

// Known: a tilt of 0.4 leaves each axis of voxels nearest to its own axis of the patient.
TEST(SliceSides, ObliqueVolumes_haveTheNearestAxes) {
  for (const VoxelTurn& turn : allTurns()) {
    const VolumeGeometry straight = turnedVolume(turn).geometry, oblique = turnedVolume(turn, 0.4).geometry;
    for (std::size_t i = 0; i < 3; ++i) {
      const SliceView a = sliceViews(straight)[i], b = sliceViews(oblique)[i];
      for (const auto& [one, other] : {std::pair{a.across, b.across}, {a.right, b.right}, {a.down, b.down}}) {
        EXPECT_EQ(one.index, other.index) << lettersOf(turn);
        EXPECT_EQ(one.mirrored, other.mirrored) << lettersOf(turn);
      }
    }
  }
  // Two axes of voxels between two axes of the patient: each axis of the patient has one.
  VolumeGeometry half;
  half.dims = {8, 8, 8};
  half.frame = PatientFrame::kLps;
  half.world_from_index = {{1, 1, 0, 0}, {-1, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  std::array<bool, 3> used{};
  for (const SliceView& view : sliceViews(half)) used[static_cast<std::size_t>(view.across.index)] = true;
  EXPECT_EQ(used, (std::array<bool, 3>{true, true, true}));
}

// Known: the slice as drawn before, with x, y and z as columns and rows, z up.
TEST(SliceSides, WithoutAPatient_voxelsGoRightAndDownOrUp) {
  DenseVolume volume = turnedVolume({{0, 1, 2}, {true, true, true}, PatientFrame::kLps});
  volume.geometry.frame = PatientFrame::kUnknown;
  const StoreReader store(makeStore(volume, "slice_sides_unknown", 8));
  // The mark lies at the greatest x and y and the least z.
  const auto cornerOf = [](const Image& image) {
    const int right = image.width - 1, bottom = image.height - 1;
    std::string out;
    for (const auto& [x, y] : {std::pair{0, 0}, {right, 0}, {0, bottom}, {right, bottom}})
      out += isMark(image.pixel(x, y)) ? 'M' : '.';
    return out;
  };
  EXPECT_EQ(cornerOf(drawSlice(store, "z", 0)), "...M");
  EXPECT_EQ(cornerOf(drawSlice(store, "y", kPatientVoxels[1] - 1)), "...M");
  EXPECT_EQ(cornerOf(drawSlice(store, "x", kPatientVoxels[0] - 1)), "...M");
  const VolumeGeometry& geometry = store.level(0).geometry;
  for (const SliceView& view : sliceViews(geometry)) EXPECT_EQ(view.letters.left, 0);
  expectError([&] { sliceAxis(geometry, "axial"); }, ErrorCode::kUsage, "--orient");
  expectError([&] { sliceAxis(geometry, "w"); }, ErrorCode::kUsage, "x, y, z, axial, coronal or sagittal");
  expectError([&] { sliceAxis(geometry, ""); }, ErrorCode::kUsage, "--axis");
}

// Known: a plane across an axis of the patient, of pixels as large as voxels, is the slice of that axis.
TEST(SliceSides, PlanesAcrossAnAxis_areTheSlicesOfThePatient) {
  for (const PatientFrame frame : {PatientFrame::kLps, PatientFrame::kRas}) {
    const VoxelTurn turn{{0, 1, 2}, {false, true, false}, frame};
    const StoreReader store(makeStore(turnedVolume(turn), "slice_sides_plane", 8));
    const VolumeGeometry& volume = store.level(0).geometry;
    PlaneSliceRequest request;
    request.window = Window{127.5, 255};
    request.offset = -volume.worldOf({0, 0, 17}).z;
    Progress progress;
    EXPECT_EQ(renderPlaneSlice(store, request, progress).rgba, drawSlice(store, "axial", 17).rgba) << wordOf(frame);
    const PlanePixels pixels = pixelsOfPlane(volume, request);
    EXPECT_EQ(textOf(edgeLetters(pixels.right, pixels.down, frame)), "RLAP");
    // From the head, the patient's right is at the right.
    request.normal = -request.normal;
    request.offset = -request.offset;
    const PlanePixels from_above = pixelsOfPlane(volume, request);
    EXPECT_EQ(textOf(edgeLetters(from_above.right, from_above.down, frame)), "LRAP");
    // From the front, and from the patient's left, tilted by less than 45 degrees.
    const double back = frame == PatientFrame::kRas ? -1 : 1;
    request.normal = {0.2, back, 0.3};
    request.offset = -glm::dot(request.normal, volume.worldOf({7, 5, 9}));
    const PlanePixels tilted = pixelsOfPlane(volume, request);
    EXPECT_EQ(textOf(edgeLetters(tilted.right, tilted.down, frame)), "RLSI");
    request.normal = {-back, 0.2, 0.3};
    request.offset = -glm::dot(request.normal, volume.worldOf({7, 5, 9}));
    const PlanePixels from_left = pixelsOfPlane(volume, request);
    EXPECT_EQ(textOf(edgeLetters(from_left.right, from_left.down, frame)), "APSI");
  }
}

}  // namespace
}  // namespace kiln::test
