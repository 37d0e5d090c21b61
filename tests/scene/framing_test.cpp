// Known answers: each side of the patient shows the anatomy of its name. A fitted box is inside the image and touches
// the margin for every affine, by the definition of fitting.
#include "scene/camera/framing.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "base/error.h"
#include "job/render_job.h"
#include "scene/camera/camera_path.h"

namespace kiln {
namespace {

constexpr std::array<Side, 6> kSides = {Side::kFront, Side::kBack, Side::kLeft,
                                        Side::kRight, Side::kTop,  Side::kBottom};

VolumeGeometry boxOfSize(std::int64_t x, std::int64_t y, std::int64_t z, PatientFrame frame = PatientFrame::kUnknown) {
  VolumeGeometry volume;
  volume.dims = {x, y, z};
  volume.frame = frame;
  return volume;
}

glm::dvec2 pixelOf(const Camera& camera, const ImageSize& size, const glm::dvec3& world) {
  const View view = resolve(camera, size);
  return view.pixelOf(glm::dvec3(view.view_from_world * glm::dvec4(world, 1)));
}

// Returns the greatest distance of a corner from the image's centre, 1 at an edge; infinity if a corner is behind the
// eye.
double reach(const VolumeGeometry& volume, const Camera& camera, const ImageSize& size) {
  const View view = resolve(camera, size);
  double out = 0;
  for (int corner = 0; corner < 8; ++corner) {
    glm::dvec3 index;
    for (int axis = 0; axis < 3; ++axis) {
      index[axis] = corner >> axis & 1 ? static_cast<double>(volume.dims[axis]) - 0.5 : -0.5;
    }
    const glm::dvec3 p(view.view_from_world * glm::dvec4(volume.worldOf(index), 1));
    if (p.z <= 0) return INFINITY;
    const glm::dvec2 from_centre = (view.pixelOf(p) - view.centre_px) / view.centre_px;
    out = std::max({out, std::abs(from_centre.x), std::abs(from_centre.y)});
  }
  return out;
}

TEST(Framing, FitsTightlyFromEverySideForAnyAffine) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> entry(-1, 1), turn(-90, 90), fov(5, 120);
  std::uniform_int_distribution<int> side(0, 5), voxels(1, 300), pixels(16, 2000), coin(0, 1);
  for (int n = 0; n < 500; ++n) {
    VolumeGeometry volume = boxOfSize(voxels(random), voxels(random), voxels(random),
                                      n % 3 == 0   ? PatientFrame::kLps
                                      : n % 3 == 1 ? PatientFrame::kRas
                                                   : PatientFrame::kUnknown);
    do {
      for (int i = 0; i < 12; ++i) volume.world_from_index[i % 4][i / 4] = entry(random) * (i % 4 == 3 ? 500 : 2);
    } while (volume.voxelVolume() < 1e-2);
    Framing framing;
    framing.side = kSides[static_cast<std::size_t>(side(random))];
    framing.azimuth_deg = 2 * turn(random);
    framing.elevation_deg = n % 10 == 0 ? 90 : turn(random);
    framing.fov_deg = fov(random);
    framing.projection = coin(random) ? Projection::kPerspective : Projection::kOrthographic;
    const ImageSize size{pixels(random), pixels(random)};
    const double fitted = reach(volume, frameVolume(volume, framing, size), size);
    EXPECT_LE(fitted, 1) << "case " << n;
    EXPECT_GE(fitted, 0.95) << "case " << n;
    framing.zoom = 2;
    EXPECT_NEAR(reach(volume, frameVolume(volume, framing, size), size), 2 * fitted, 1e-6) << "case " << n;
  }
}

// Known because an origin only moves a box: map coordinates, or nanometres a tenth of a metre away, change no extent.
TEST(Framing, VisibleBoxes_haveMoreMargin) {
  const VolumeGeometry volume = boxOfSize(30, 40, 50);
  const ImageSize size{200, 100};
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    Framing framing;
    framing.projection = projection;
    EXPECT_NEAR(reach(volume, frameVolume(volume, framing, size), size), 1 / 1.02, 1e-9);
    EXPECT_NEAR(reach(volume, frameVolume({volume, Fit::kVisible}, framing, size), size), 1 / 1.06, 1e-9);
  }
}

// Corners of the box in which nothing is are outside: an octahedron in a cube is seen 1.6 times as large from its
// edges.
TEST(Framing, Outlines_areFittedInsteadOfCorners) {
  const VolumeGeometry volume = boxOfSize(100, 100, 100);
  std::vector<glm::dvec3> outline;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-50.0, 50.0}) {
      outline.push_back(centreOf(volume));
      outline.back()[axis] += sign;
    }
  }
  const ImageSize size{200, 200};
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    Framing framing = defaultFraming();
    framing.projection = projection;
    const Camera camera = frameVolume({volume, outline, Fit::kVisible}, framing, size);
    double most = 0;
    for (const glm::dvec3& point : outline) {
      const glm::dvec2 from_centre = (pixelOf(camera, size, point) - glm::dvec2(99.5)) / 100.0;
      most = std::max({most, std::abs(from_centre.x), std::abs(from_centre.y)});
    }
    EXPECT_NEAR(most, 1 / 1.06, 0.006);
    const double of_box = reach(volume, frameVolume({volume, Fit::kVisible}, framing, size), size);
    EXPECT_GT(reach(volume, camera, size), 1.4 * of_box);
  }
}

// Six points in a volume of 100 x 80 x 60 voxels.
std::vector<glm::dvec3> randomOutline(std::mt19937& random) {
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<glm::dvec3> out;
  for (int i = 0; i < 6; ++i) out.push_back(glm::dvec3(100 * share(random), 80 * share(random), 60 * share(random)));
  return out;
}

// Opposite margins are equal, and two of them are the margin of the fit: a picture cannot be larger.
TEST(Framing, Outlines_areInTheMiddleOfThePicture) {
  const VolumeGeometry volume = boxOfSize(100, 80, 60);
  const ImageSize size{300, 200};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> turn(-90, 90);
  for (int n = 0; n < 100; ++n) {
    const std::vector<glm::dvec3> outline = randomOutline(random);
    Framing framing;
    framing.azimuth_deg = turn(random), framing.elevation_deg = turn(random), framing.roll_deg = turn(random);
    framing.projection = n % 2 == 0 ? Projection::kPerspective : Projection::kOrthographic;
    const Camera camera = frameVolume({volume, outline, Fit::kVisible}, framing, size);
    const glm::dvec2 middle(149.5, 99.5);
    glm::dvec2 lo(INFINITY), hi(-INFINITY);
    for (const glm::dvec3& point : outline) {
      const glm::dvec2 from_middle = (pixelOf(camera, size, point) - middle) / glm::dvec2(150, 100);
      lo = glm::min(lo, from_middle), hi = glm::max(hi, from_middle);
    }
    const glm::dvec2 half = 0.5 * (hi - lo);
    EXPECT_NEAR(std::max(hi.x, hi.y), 1 / 1.06, 0.006) << n;
    // The middle of two points at different depths is the middle of their margins only where the margins are the fit's.
    if (framing.projection == Projection::kOrthographic) {
      EXPECT_NEAR(lo.x, -hi.x, 0.012) << n;
      EXPECT_NEAR(lo.y, -hi.y, 0.012) << n;
    } else if (half.x > half.y) {
      EXPECT_NEAR(lo.x, -hi.x, 0.012) << n;
    } else {
      EXPECT_NEAR(lo.y, -hi.y, 0.012) << n;
    }
  }
}

// The least and the greatest pixel of points, from the middle of the rectangle between edges; 1 at the edges.
struct Extent {
  glm::dvec2 lo{INFINITY}, hi{-INFINITY};
  double most() const { return std::max({-lo.x, -lo.y, hi.x, hi.y}); }
};

Extent between(const FreeEdges& edges, const Camera& camera, const ImageSize& size,
               const std::vector<glm::dvec3>& points) {
  const glm::dvec2 half = 0.5 * edges.rectangle(size), middle = glm::dvec2(edges.left, edges.top) + half;
  Extent out;
  for (const glm::dvec3& point : points) {
    const glm::dvec2 at = (pixelOf(camera, size, point) - middle) / half;
    out.lo = glm::min(out.lo, at), out.hi = glm::max(out.hi, at);
  }
  return out;
}

// Known: points are in a rectangle, and two of opposite sides touch its margin; with a zoom of 2 they are twice as far
// from its middle.
TEST(FreeEdges, HoldNothingOfTheOutline) {
  const VolumeGeometry volume = boxOfSize(100, 80, 60);
  const ImageSize size{300, 200};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(0, 1), turn(-90, 90);
  for (int n = 0; n < 200; ++n) {
    FramedBox box(volume, n % 4 < 2 ? Fit::kVisible : Fit::kBox);
    if (box.fit == Fit::kVisible) box.outline = randomOutline(random);
    const FreeEdges edges{100 * share(random), 40 * share(random), 30 * share(random), 80 * share(random)};
    box.free_edges = {edges};
    CameraSpec spec;
    spec.projection = n % 2 == 0 ? Projection::kPerspective : Projection::kOrthographic;
    spec.azimuth_deg = turn(random), spec.elevation_deg = turn(random), spec.roll_deg = turn(random);
    const Extent fitted = between(edges, spec.resolve(box, size), size, box.outline);
    EXPECT_NEAR(fitted.most(), 1 / box.margin(), 1e-9) << n;
    const glm::dvec2 half = 0.5 * (fitted.hi - fitted.lo);
    const int across = half.x > half.y ? 0 : 1;
    if (box.fit == Fit::kVisible) {
      EXPECT_NEAR(fitted.lo[across], -fitted.hi[across], 1e-9) << n;
      // The other direction is in the middle exactly where depth changes no size.
      if (spec.projection == Projection::kOrthographic) {
        EXPECT_NEAR(fitted.lo[1 - across], -fitted.hi[1 - across], 1e-9) << n;
      }
    }
    spec.zoom = 2;
    EXPECT_NEAR(between(edges, spec.resolve(box, size), size, box.outline).most(), 2 / box.margin(), 1e-9) << n;
    spec.zoom.reset();
    spec.pan = glm::dvec2(0.1, -0.05);
    const Camera still = spec.resolve(box, size);
    spec.pan.reset();
    const glm::dvec2 shift = pixelOf(still, size, spec.resolve(box, size).target) -
                             pixelOf(spec.resolve(box, size), size, spec.resolve(box, size).target);
    EXPECT_LT(glm::distance(shift, glm::dvec2(30, 10)), 1e-9) << n;
  }
}

// Known: the axis goes through the middle of the box, and one point of the axis is in the middle of the rectangle in
// each frame.
TEST(FreeEdges, OfTurntables_areFreeInAllFrames) {
  const VolumeGeometry volume = boxOfSize(10, 100, 20);
  const ImageSize size{120, 90};
  const FreeEdges edges{.right = 35};
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    FramedBox box(volume, Fit::kVisible);
    box.free_edges = {edges};
    CameraSpec still;
    still.projection = projection;
    still.elevation_deg = 20;
    const Turntable turn{36, 360, std::nullopt};
    const glm::dvec3 middle = panned(cameraAt(turn, still, 1, box, size), -edges.shift(size), size).target;
    EXPECT_LT(glm::distance(glm::dvec2(middle), glm::dvec2(centreOf(volume))), 1e-9);
    double most = 0;
    for (int frame = 1; frame <= turn.frames; ++frame) {
      const Camera camera = cameraAt(turn, still, frame, box, size);
      most = std::max(most, between(edges, camera, size, box.outline).most());
      EXPECT_LT(between(edges, camera, size, {middle}).most(), 1e-9) << frame;
    }
    EXPECT_NEAR(most, 1 / 1.06, 1e-9);
  }
}

// A given eye or target keeps its camera.
TEST(FreeEdges, LeaveGivenCameras) {
  FramedBox plain(boxOfSize(30, 40, 50), Fit::kVisible), edged = plain;
  edged.free_edges = {{.left = 30}};
  const ImageSize size{100, 50};
  std::vector<CameraSpec> specs(3);
  specs[0].eye = glm::dvec3(0, -100, 20);
  specs[1].target = glm::dvec3(10, 10, 10);
  specs[2].projection = Projection::kEquirectangular;
  for (const CameraSpec& spec : specs) {
    const Camera expected = spec.resolve(plain, size), found = spec.resolve(edged, size);
    EXPECT_EQ(found.eye, expected.eye);
    EXPECT_EQ(found.target, expected.target);
    EXPECT_EQ(found.fov_deg, expected.fov_deg);
  }
  EXPECT_NE(CameraSpec().resolve(plain, size).eye, CameraSpec().resolve(edged, size).eye);
}

// A wide box loses less to a row than to a column, a high box less to a column.
TEST(FreeEdges, OfSeveralChoices_areThoseOfTheLargestPicture) {
  const ImageSize size{100, 100};
  const FreeEdges column{.right = 40}, row{.top = 40};
  for (const bool wide : {true, false}) {
    FramedBox box(wide ? boxOfSize(100, 10, 10) : boxOfSize(10, 10, 100), Fit::kVisible);
    box.free_edges = {column, row};
    for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
      CameraSpec spec;
      spec.projection = projection;
      spec.side = Side::kFront;
      EXPECT_NEAR(between(wide ? row : column, spec.resolve(box, size), size, box.outline).most(), 1 / 1.06, 1e-9);
    }
  }
}

// Turntables keep their axis: the target moves along the axis alone.
TEST(Framing, Turns_keepTheTargetOnTheAxis) {
  const VolumeGeometry volume = boxOfSize(100, 100, 100);
  FramedBox box(volume, {glm::dvec3(0, 0, 0), glm::dvec3(50, 10, 0), glm::dvec3(10, 20, 30)}, Fit::kVisible);
  Turns half_turn{{glm::dmat3(-1, 0, 0, 0, -1, 0, 0, 0, 1)}, {0, 0, 1}};
  const glm::dvec3 centre = centreOf(volume), target = frameVolume(box, Framing(), {100, 100}, half_turn).target;
  EXPECT_EQ(target.x, centre.x);
  EXPECT_EQ(target.y, centre.y);
  EXPECT_NEAR(target.z, 15, 5);
  EXPECT_NE(frameVolume(box, Framing(), {100, 100}).target, centre);
  half_turn.moves_target = false;
  EXPECT_EQ(frameVolume(box, Framing(), {100, 100}, half_turn).target, centre);
  half_turn.moves_target = true;
  box.fit = Fit::kRegion;
  EXPECT_EQ(frameVolume(box, Framing(), {100, 100}, half_turn).target, centre);
}

// The base of a cone reaches further down than its tip reaches up, seen from above. Over all frames the margins at both
// ends of the axis are those of the fit: no picture with this axis in its middle is larger.
TEST(Framing, Turntables_haveEqualMarginsAtBothEndsOfTheAxis) {
  const VolumeGeometry volume = boxOfSize(60, 60, 100);
  FramedBox cone(volume, Fit::kVisible);
  cone.outline = {{29.5, 29.5, 99.5}};
  for (int i = 0; i < 36; ++i)
    cone.outline.emplace_back(29.5 + 30 * std::cos(i * M_PI / 18), 29.5 + 30 * std::sin(i * M_PI / 18), -0.5);
  const ImageSize size{220, 200};
  const Turntable turn{36, 360, std::nullopt};
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    for (const double roll : {0.0, 90.0}) {
      for (const double elevation : {-30.0, 0.0, 20.0, 50.0}) {
        for (const FreeEdges& edges : {FreeEdges(), FreeEdges{.left = 10, .top = 20}}) {
          CameraSpec still;
          still.projection = projection;
          still.roll_deg = roll, still.elevation_deg = elevation;
          cone.free_edges = {edges};
          Extent all;
          for (int frame = 1; frame <= turn.frames; ++frame) {
            const Extent one = between(edges, cameraAt(turn, still, frame, cone, size), size, cone.outline);
            all.lo = glm::min(all.lo, one.lo), all.hi = glm::max(all.hi, one.hi);
          }
          const int along = roll == 0 ? 1 : 0;
          EXPECT_NEAR(all.hi[along], 1 / 1.06, 1e-6) << roll << " " << elevation;
          EXPECT_NEAR(all.lo[along], -1 / 1.06, 1e-6) << roll << " " << elevation;
          EXPECT_NEAR(all.most(), 1 / 1.06, 1e-6) << roll << " " << elevation;
        }
      }
    }
  }
}

// The middle of the picture moves with the target, by the shift in pixels.
TEST(Framing, Pan_movesThePicture) {
  const VolumeGeometry volume = boxOfSize(30, 40, 50);
  const ImageSize size{200, 100};
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    CameraSpec spec;
    spec.projection = projection;
    const Camera still = spec.resolve(volume, size);
    spec.pan = glm::dvec2(0.25, 0.1);
    const Camera moved = spec.resolve(volume, size);
    const glm::dvec2 shift = pixelOf(moved, size, still.target) - pixelOf(still, size, still.target);
    EXPECT_NEAR(shift.x, 50, 1e-9);
    EXPECT_NEAR(shift.y, -10, 1e-9);  // rows count downwards
    EXPECT_NEAR(glm::distance(moved.eye - still.eye, moved.target - still.target), 0, 1e-9);
  }
}

// VTK's sense: the camera turns clockwise, so what was above the middle is then to its left.
TEST(Framing, Roll_turnsThePictureTheOtherWay) {
  const VolumeGeometry volume = boxOfSize(30, 40, 50);
  const ImageSize size{200, 100};
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    CameraSpec spec;
    spec.projection = projection;
    spec.side = Side::kFront;
    spec.roll_deg = 90;
    const Camera camera = spec.resolve(volume, size);
    const glm::dvec2 above = pixelOf(camera, size, centreOf(volume) + glm::dvec3(0, 0, 5));
    EXPECT_LT(above.x, 90);
    EXPECT_NEAR(above.y, 50, 1e-9);
    EXPECT_LE(reach(volume, camera, size), 1) << "the fit is that of the rolled picture";
    EXPECT_GE(reach(volume, camera, size), 0.95);
    spec.eye = camera.eye, spec.side.reset();
    EXPECT_LT(glm::distance(spec.resolve(volume, size).up, camera.up), 1e-12);
  }
}

// A rolled turntable shows the same turn: the axis is the volume's, not the picture's.
TEST(Framing, Roll_leavesTheAxisOfATurntable) {
  const VolumeGeometry volume = boxOfSize(30, 40, 50);
  CameraSpec still;
  still.side = Side::kFront;
  CameraSpec rolled_still = still;
  rolled_still.roll_deg = 90;
  const Turntable turn{4, 360, std::nullopt};
  const auto towardsEye = [&](const CameraSpec& spec) {
    const Camera camera = cameraAt(turn, spec, 2, volume, {100, 100});
    return glm::normalize(camera.eye - camera.target);
  };
  EXPECT_LT(glm::distance(towardsEye(still), towardsEye(rolled_still)), 1e-12);
}

// An up direction of the user's own turns the picture that is fitted.
TEST(Framing, UpOfTheUser_isFitted) {
  const VolumeGeometry volume = boxOfSize(10, 10, 100);
  CameraSpec spec;
  spec.side = Side::kFront;
  spec.up = glm::dvec3(1, 0, 0);
  const ImageSize size{200, 100};
  EXPECT_LE(reach(volume, spec.resolve(volume, size), size), 1);
  EXPECT_GE(reach(volume, spec.resolve(volume, size), size), 0.95);
}

// The first frame of a turn of a flat box is narrow; the widest frame decides.
TEST(Framing, Turntable_fitsAllFramesOfAVisibleBox) {
  const VolumeGeometry volume = boxOfSize(10, 100, 20);
  const ImageSize size{100, 100};
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    CameraSpec still;
    still.projection = projection;
    still.side = Side::kFront;
    const Turntable turn{36, 360, std::nullopt};
    double most = 0;
    for (int frame = 1; frame <= turn.frames; ++frame)
      most = std::max(most, reach(volume, cameraAt(turn, still, frame, {volume, Fit::kVisible}, size), size));
    EXPECT_NEAR(most, 1 / 1.06, 1e-9);
    // Earlier versions fitted the first frame: such jobs stay as they are.
    EXPECT_NEAR(reach(volume, cameraAt(turn, still, 1, {volume, Fit::kBox}, size), size), 1 / 1.02, 1e-9);
  }
}

TEST(Framing, LargeOrigins_haveTheBoxesOfSmallOnes) {
  for (const auto& [spacing, origin] : {std::pair{0.1, 4.6e6}, {1e-9, 0.1}, {1.0, -1e12}}) {
    const auto volumeAt = [&](double first_voxel) {
      VolumeGeometry volume = boxOfSize(32, 32, 32);
      for (int axis = 0; axis < 3; ++axis) volume.world_from_index[axis][axis] = spacing;
      volume.world_from_index[3] = glm::dvec4(glm::dvec3(origin + first_voxel * spacing), 1);
      return volume;
    };
    const VolumeGeometry alone = boxAround({volumeAt(0)});
    EXPECT_EQ(alone.dims, (Extent3{32, 32, 32}));
    EXPECT_EQ(alone.world_from_index, volumeAt(0).world_from_index);
    EXPECT_EQ(boxAround({volumeAt(0), volumeAt(16)}).dims, (Extent3{48, 48, 48}));
    EXPECT_EQ(boxAround({volumeAt(0), volumeAt(-16)}).dims, (Extent3{48, 48, 48}));
    const Camera camera = frameVolume(alone, defaultFraming(), {64, 64});
    EXPECT_NEAR((camera.target.x - origin) / spacing, 15.5, std::abs(origin) / spacing * 1e-15);
  }
}

TEST(Framing, ZoomKeepsThePerspective) {
  const VolumeGeometry volume = boxOfSize(10, 20, 30);
  Framing framing;
  const Camera fitted = frameVolume(volume, framing, {100, 100});
  framing.zoom = 3;
  const Camera zoomed = frameVolume(volume, framing, {100, 100});
  EXPECT_EQ(fitted.eye, zoomed.eye);
  EXPECT_LT(zoomed.fov_deg, fitted.fov_deg);
}

struct Patient {
  PatientFrame frame;
  glm::dvec3 left, anterior, superior;  // axes by the words of the frame
};
const Patient kPatients[] = {{PatientFrame::kLps, {1, 0, 0}, {0, -1, 0}, {0, 0, 1}},
                             {PatientFrame::kRas, {-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                             {PatientFrame::kUnknown, {1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};

// In front of a patient who faces the viewer, the head is at the top and the patient's left hand at the right.
TEST(Framing, SidesShowWhatTheirNamesSay) {
  struct Seen {
    Side side;
    int towards_eye, up, right;  // ±1 left, ±2 anterior, ±3 superior
  };
  const Seen kSeen[] = {{Side::kFront, 2, 3, 1},  {Side::kBack, -2, 3, -1}, {Side::kLeft, 1, 3, -2},
                        {Side::kRight, -1, 3, 2}, {Side::kTop, 3, 2, -1},   {Side::kBottom, -3, 2, 1}};
  const ImageSize size{100, 100};
  for (const Patient& patient : kPatients) {
    const VolumeGeometry volume = boxOfSize(20, 20, 20, patient.frame);
    const auto direction = [&](int d) {
      const glm::dvec3 axis = std::abs(d) == 1 ? patient.left : std::abs(d) == 2 ? patient.anterior : patient.superior;
      return d < 0 ? -axis : axis;
    };
    for (const Seen& seen : kSeen) {
      Framing framing;
      framing.side = seen.side;
      const Camera camera = frameVolume(volume, framing, size);
      const glm::dvec3 centre = centreOf(volume);
      EXPECT_LT(glm::distance(glm::normalize(camera.eye - centre), direction(seen.towards_eye)), 1e-12);
      const glm::dvec2 middle = pixelOf(camera, size, centre);
      EXPECT_NEAR(middle.x, 50, 1e-9);
      EXPECT_LT(pixelOf(camera, size, centre + 5.0 * direction(seen.up)).y, middle.y - 1);
      EXPECT_GT(pixelOf(camera, size, centre + 5.0 * direction(seen.right)).x, middle.x + 1);
    }
  }
}

TEST(Framing, AzimuthTurnsToThePatientsLeftAndElevationRaises) {
  for (const Patient& patient : kPatients) {
    const VolumeGeometry volume = boxOfSize(20, 20, 20, patient.frame);
    const auto eyeAt = [&](double azimuth, double elevation) {
      Framing framing;
      framing.azimuth_deg = azimuth;
      framing.elevation_deg = elevation;
      const Camera camera = frameVolume(volume, framing, {100, 100});
      return glm::normalize(camera.eye - camera.target);
    };
    EXPECT_LT(glm::distance(eyeAt(90, 0), patient.left), 1e-12);
    EXPECT_LT(glm::distance(eyeAt(0, 90), patient.superior), 1e-12);
    EXPECT_GT(glm::dot(eyeAt(30, 15), patient.superior), 0.2);
  }
}

void expectRefused(const CameraSpec& spec, const std::string& first, const std::string& second) {
  try {
    spec.resolve(boxOfSize(10, 10, 10), {64, 64});
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_NE(std::string(error.what()).find(first), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(second), std::string::npos) << error.what();
  }
}

TEST(CameraSpec, NothingSaidIsTheDefaultFraming) {
  const VolumeGeometry volume = boxOfSize(10, 20, 30);
  const Camera said = CameraSpec{}.resolve(volume, {64, 64});
  const Camera expected = frameVolume(volume, defaultFraming(), {64, 64});
  EXPECT_EQ(said.eye, expected.eye);
  EXPECT_EQ(said.fov_deg, expected.fov_deg);
}

TEST(CameraSpec, ASideAloneIsSeenStraight) {
  const VolumeGeometry volume = boxOfSize(10, 20, 30);
  CameraSpec spec;
  spec.side = Side::kLeft;
  spec.fov_deg = 50;
  const Camera camera = spec.resolve(volume, {64, 64});
  EXPECT_LT(glm::distance(glm::normalize(camera.eye - camera.target), {1, 0, 0}), 1e-12);
  EXPECT_NEAR(camera.fov_deg, 50, 1e-12);
}

TEST(CameraSpec, AnEyeLooksAtTheMiddleWithAUsableUp) {
  const VolumeGeometry volume = boxOfSize(11, 11, 11);
  CameraSpec spec;
  spec.eye = glm::dvec3(5, -30, 5);
  Camera camera = spec.resolve(volume, {64, 64});
  EXPECT_EQ(camera.target, glm::dvec3(5, 5, 5));
  EXPECT_EQ(camera.up, glm::dvec3(0, 0, 1));
  EXPECT_EQ(camera.fov_deg, 60);
  spec.eye = glm::dvec3(5, 5, 90);  // straight above: superior is the line of sight
  EXPECT_EQ(spec.resolve(volume, {64, 64}).up, glm::dvec3(0, -1, 0));
  spec.projection = Projection::kOrthographic;
  camera = spec.resolve(volume, {64, 64});
  EXPECT_NEAR(camera.height, 11 * 1.02, 1e-12);
  spec.height = 4;
  EXPECT_EQ(spec.resolve(volume, {64, 64}).height, 4);
}

// Known because a framed camera of the front, given as an eye and turned by 40 and 20 degrees, is the framed camera
// that is turned so, at its distance.
TEST(CameraSpec, AnEye_turnsAsTheFramingAndZoomsByItsAngle) {
  for (const Patient& patient : kPatients) {
    const VolumeGeometry volume = boxOfSize(20, 20, 20, patient.frame);
    CameraSpec framed;
    framed.side = Side::kFront;
    const Camera front = framed.resolve(volume, {100, 100});
    framed.azimuth_deg = 40, framed.elevation_deg = 20;
    const Camera expected = framed.resolve(volume, {100, 100});
    CameraSpec spec;
    spec.eye = front.eye, spec.target = front.target, spec.up = front.up;
    spec.azimuth_deg = 40, spec.elevation_deg = 20, spec.zoom = 2;
    const Camera camera = spec.resolve(volume, {100, 100});
    const glm::dvec3 away = camera.eye - camera.target;
    EXPECT_LT(glm::distance(glm::normalize(away), glm::normalize(expected.eye - expected.target)), 1e-12);
    EXPECT_NEAR(glm::length(away), glm::distance(front.eye, front.target), 1e-9);
    EXPECT_LT(glm::length(glm::cross(glm::cross(camera.up, away), glm::cross(expected.up, away))), 1e-9);
    EXPECT_NEAR(std::tan(glm::radians(camera.fov_deg / 2)), std::tan(glm::radians(30.0)) / 2, 1e-12);
    spec.projection = Projection::kOrthographic;
    spec.height = 4;
    EXPECT_EQ(spec.resolve(volume, {100, 100}).height, 2);
  }
}

TEST(CameraSpec, ATargetMovesTheFraming) {
  const VolumeGeometry volume = boxOfSize(11, 11, 11);
  CameraSpec spec;
  spec.side = Side::kFront;
  const Camera plain = spec.resolve(volume, {64, 64});
  spec.target = glm::dvec3(7, 5, 5);
  const Camera moved = spec.resolve(volume, {64, 64});
  EXPECT_LT(glm::distance(moved.eye - plain.eye, {2, 0, 0}), 1e-12);
}

TEST(CameraSpec, RefusesContradictions) {
  CameraSpec eye;
  eye.eye = glm::dvec3(0, -50, 0);
  CameraSpec spec = eye;
  spec.side = Side::kFront;
  expectRefused(spec, "eye", "view");
  spec = eye;
  spec.projection = Projection::kEquirectangular;
  spec.azimuth_deg = 0;
  expectRefused(spec, "azimuth", "equirectangular");
  spec = eye;
  spec.zoom = 0;
  expectRefused(spec, "zoom", "above 0");
  spec = eye;
  spec.height = 1;
  expectRefused(spec, "height", "orthographic");
  spec = eye;
  spec.up = glm::dvec3(4.5, 54.5, 4.5);
  expectRefused(spec, "up", "line of sight");
  spec = CameraSpec{};
  spec.zoom = 0;
  expectRefused(spec, "zoom", "above 0");
  spec.zoom = 1;
  spec.elevation_deg = 91;
  expectRefused(spec, "elevation", "90");
}

}  // namespace
}  // namespace kiln
