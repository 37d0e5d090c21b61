#include "scene/camera/camera_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <string>

#include "base/error.h"
#include "scene/camera/framing.h"

namespace kiln {
namespace {

CameraSpec overlaid(CameraSpec spec, const CameraSpec& key) {
  const auto take = [](auto& into, const auto& from) {
    if (from) into = from;
  };
  // Turns and zoom of a framing are not those of an eye in its place.
  if (key.eye && !spec.eye) spec.azimuth_deg.reset(), spec.elevation_deg.reset(), spec.zoom.reset();
  take(spec.projection, key.projection);
  take(spec.eye, key.eye);
  take(spec.target, key.target);
  take(spec.up, key.up);
  take(spec.fov_deg, key.fov_deg);
  take(spec.height, key.height);
  take(spec.side, key.side);
  take(spec.azimuth_deg, key.azimuth_deg);
  take(spec.elevation_deg, key.elevation_deg);
  take(spec.zoom, key.zoom);
  take(spec.pan, key.pan);
  take(spec.roll_deg, key.roll_deg);
  return spec;
}

double angleAt(const Turntable& turntable, double frame) {
  return glm::radians(turntable.degrees) * (frame - 1) / turntable.frames;
}

// Returns the turns of the volume that the still camera sees as a turning camera sees the volume. A box between two
// turns of 1° reaches 0.004 % further.
Turns turnsOf(const Turntable& turntable, const glm::dvec3& axis) {
  constexpr int kMostTurns = 360;
  const int turns = std::min(turntable.frames, kMostTurns);
  Turns out;
  out.axis = glm::normalize(axis);
  for (int i = 1; i < turns; ++i) {
    const double angle = -glm::radians(turntable.degrees) * i / turns;
    out.rotations.push_back(glm::mat3_cast(glm::angleAxis(angle, out.axis)));
  }
  return out;
}

Camera turnedAt(const Turntable& turntable, const CameraSpec& still, double frame, const FramedBox& box,
                const ImageSize& size) {
  // The picture is moved after the turn: the axis goes through the volume's centre. A rolled picture shows the same
  // turn.
  CameraSpec upright = still;
  upright.roll_deg.reset();
  UnpannedCamera first = still.unpanned(box, size);
  const glm::dvec3 axis = turntable.axis ? *turntable.axis : upright.unpanned(box, size).camera.up;
  if (box.fit != Fit::kBox && still.framed()) {
    Turns turns = turnsOf(turntable, axis);
    turns.moves_target = !still.target;
    first = still.unpanned(box, size, turns);
  }
  return panned(turned(first.camera, axis, angleAt(turntable, frame)), first.pan, size);
}

// Returns the rotation with the camera's axes in the world as columns: right, down, along the view.
glm::dquat orientationOf(const Camera& camera, const ImageSize& size) {
  return glm::normalize(glm::quat_cast(glm::transpose(glm::dmat3(resolve(camera, size).view_from_world))));
}

bool samePlace(const glm::dvec3& a, const glm::dvec3& b, double scale) { return glm::distance(a, b) <= 1e-9 * scale; }

Pivot pivotOf(const CameraKeyframes& path, const CameraSpec& still, const std::vector<Camera>& cameras) {
  if (path.pivot) return *path.pivot;
  bool target_stays = true, eye_named = still.eye.has_value();
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const double scale = glm::distance(cameras[0].eye, cameras[0].target);
    target_stays = target_stays && samePlace(cameras[i].target, cameras[0].target, scale);
    eye_named = eye_named || path.keys[i].value.eye.has_value();
  }
  return target_stays || !eye_named ? Pivot::kTarget : Pivot::kEye;
}

// Interpolates positive numbers by their logarithms, because their ratios are perceived. A constant number keeps its
// bits.
double ratioSplineAt(const KeyTimes& times, const std::vector<double>& values, double frame) {
  if (std::equal(values.begin() + 1, values.end(), values.begin())) return values.front();
  std::vector<double> logs;
  for (const double value : values) logs.push_back(std::log(value));
  return std::exp(splineAt(times, logs, frame));
}

void requireTogether(const CameraKeyframes& path, const std::vector<CameraSpec>& specs,
                     const std::vector<Camera>& cameras, const std::vector<glm::dquat>& orientations) {
  // Cosine of half the angle between opposite orientations, up to rounding errors.
  constexpr double kOpposite = 1e-7;
  for (std::size_t i = 1; i < cameras.size(); ++i) {
    const auto refuse = [&](const std::string& what) {
      throw Error(ErrorCode::kUsage, fmt::format("camera: from the key at frame {} to that at {} {}",
                                                 path.keys[i - 1].frame, path.keys[i].frame, what));
    };
    const auto refuse_turn = [&](const char* what) {
      refuse(fmt::format("{} turns by 180 degrees or more; keys turn the shorter way: give one between, or a turntable",
                         what));
    };
    const CameraSpec &before = specs[i - 1], &key = specs[i];
    if (cameras[i].projection != cameras[0].projection) refuse("the projection changes, which nothing lies between");
    if (before.azimuth_deg && key.azimuth_deg && std::abs(*key.azimuth_deg - *before.azimuth_deg) >= 180)
      refuse_turn("the azimuth");
    if (std::abs(key.roll_deg.value_or(0) - before.roll_deg.value_or(0)) >= 180) refuse_turn("the roll");
    if (std::abs(glm::dot(orientations[i - 1], orientations[i])) < kOpposite) refuse_turn("the camera");
  }
}

Camera betweenKeys(const CameraKeyframes& path, const CameraSpec& still, double frame, const FramedBox& box,
                   const ImageSize& size) {
  std::vector<CameraSpec> specs;
  std::vector<Camera> cameras;
  std::vector<glm::dquat> orientations;
  for (const Key<CameraSpec>& key : path.keys) {
    specs.push_back(overlaid(still, key.value));
    cameras.push_back(specs.back().resolve(box, size));
    orientations.push_back(orientationOf(cameras.back(), size));
  }
  requireTogether(path, specs, cameras, orientations);
  const KeyTimes times(path.keys);
  const KeySpan span = spanAt(times, frame);
  if (span.t == 0) return cameras[span.from];
  if (span.t == 1) return cameras[span.from + 1];

  std::vector<glm::dvec3> eyes, targets;
  std::vector<double> distances, tangents, heights;
  for (const Camera& camera : cameras) {
    eyes.push_back(camera.eye);
    targets.push_back(camera.target);
    distances.push_back(glm::distance(camera.eye, camera.target));
    tangents.push_back(std::tan(0.5 * glm::radians(camera.fov_deg)));
    heights.push_back(camera.height);
  }
  Camera out = cameras.front();
  const glm::dquat orientation = splineAt(times, orientations, frame);
  const glm::dvec3 ahead = ratioSplineAt(times, distances, frame) * (orientation * glm::dvec3(0, 0, 1));
  if (pivotOf(path, still, cameras) == Pivot::kTarget) {
    out.target = splineAt(times, targets, frame);
    out.eye = out.target - ahead;
  } else {
    out.eye = splineAt(times, eyes, frame);
    out.target = out.eye + ahead;
  }
  out.up = orientation * glm::dvec3(0, -1, 0);
  out.height = ratioSplineAt(times, heights, frame);
  out.fov_deg = glm::degrees(2 * std::atan(ratioSplineAt(times, tangents, frame)));
  return out;
}

Camera ofMatrix(const CameraMatrices& matrices, const CameraSpec& still, double frame, const FramedBox& box,
                const ImageSize& size) {
  const double place = frame - 1;
  if (!(place >= 0 && place < static_cast<double>(matrices.size())))
    throw Error(ErrorCode::kUsage,
                fmt::format("camera: there is no matrix for frame {}: the job has {}, from frame 1 on", frame,
                            matrices.size()));
  if (still.azimuth_deg || still.elevation_deg)
    throw Error(ErrorCode::kUsage,
                "camera: matrices state where each frame is seen from; leave azimuth and elevation out");
  const glm::dmat4& matrix = matrices[static_cast<std::size_t>(place)];
  CameraSpec spec = still;
  spec.eye = glm::dvec3(matrix[3]);
  // Puts the target as far ahead as the volume's centre: here a target only gives a direction.
  const double distance = glm::distance(*spec.eye, centreOf(box.volume));
  spec.target = *spec.eye - (distance > 0 ? distance : 1.0) * glm::normalize(glm::dvec3(matrix[2]));
  spec.up = glm::dvec3(matrix[1]);
  return spec.resolve(box, size);
}

}  // namespace

Camera cameraAt(const CameraPath& path, const CameraSpec& still, double frame, const FramedBox& box,
                const ImageSize& size) {
  if (const auto* turntable = std::get_if<Turntable>(&path)) return turnedAt(*turntable, still, frame, box, size);
  if (const auto* keyframes = std::get_if<CameraKeyframes>(&path))
    return betweenKeys(*keyframes, still, frame, box, size);
  if (const auto* matrices = std::get_if<CameraMatrices>(&path)) return ofMatrix(*matrices, still, frame, box, size);
  return still.resolve(box, size);
}

bool isFramed(const CameraPath& path, const CameraSpec& still) {
  if (std::holds_alternative<CameraMatrices>(path) || !still.framed()) return false;
  const auto* const keyframes = std::get_if<CameraKeyframes>(&path);
  return keyframes == nullptr || std::all_of(keyframes->keys.begin(), keyframes->keys.end(),
                                             [](const Key<CameraSpec>& key) { return key.value.framed(); });
}

bool isRigid(const glm::dmat4& m) {
  constexpr double kTolerance = 1e-4;  // for numbers that were stored as floats
  const glm::dmat3 turn(m);
  const glm::dmat3 unit = glm::transpose(turn) * turn;
  double off = std::abs(glm::determinant(turn) - 1);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) off = std::max(off, std::abs(unit[i][j] - (i == j ? 1.0 : 0.0)));
  }
  for (int column = 0; column < 4; ++column) off = std::max(off, std::abs(m[column][3] - (column == 3 ? 1.0 : 0.0)));
  return off <= kTolerance;
}

}  // namespace kiln
