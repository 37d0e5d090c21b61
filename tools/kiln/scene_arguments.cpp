#include "scene_arguments.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "base/path_status.h"
#include "job/job_names.h"
#include "scene/scene_limits.h"
#include "scene/transfer/presets.h"
#include "source_arguments.h"

namespace kiln::tool {
namespace {

std::vector<double> exactly(std::size_t count, const std::string& text, const char* option, const char* expected) {
  const std::vector<double> out = parseNumbers(text, ',', option, expected);
  if (out.size() != count)
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}, found '{}'", option, expected, text));
  return out;
}

glm::dvec3 colorFrom(const std::string& text, double most, const char* option, const char* expected) {
  const std::vector<double> c = exactly(3, text, option, expected);
  for (const double channel : c) {
    if (!(channel >= 0 && channel <= most))
      throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}, found '{}'", option, expected, text));
  }
  return {c[0], c[1], c[2]};
}

// "kind", "kind:place", "kind:place:color".
Light lightFrom(const std::string& text) {
  constexpr const char* kOption = "--light";
  constexpr const char* kExpected =
      "headlight[:r,g,b], dir:x,y,z[:r,g,b] or point:x,y,z[:r,g,b], colours from 0 to 1000000";
  std::vector<std::string> parts = CLI::detail::split(text, ':');
  const auto refuse = [&] {
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}, found '{}'", kOption, kExpected, text));
  };
  Light light;
  if (parts[0] == "dir")
    light.kind = LightKind::kDirectional;
  else if (parts[0] == "point")
    light.kind = LightKind::kPoint;
  else if (parts[0] != "headlight")
    refuse();
  const std::size_t color = light.kind == LightKind::kHeadlight ? 1 : 2;
  if (parts.size() < color || parts.size() > color + 1) refuse();
  if (color == 2) light.place = parseTriple(parts[1], kOption);
  if (light.kind == LightKind::kDirectional && !(glm::length(light.place) > 0)) refuse();
  if (parts.size() > color) light.color = colorFrom(parts[color], 1e6, kOption, kExpected);
  return light;
}

std::array<double, 4> opaque(const glm::dvec3& c) { return {c.r, c.g, c.b, 1}; }

// "transparent", "R,G,B" or "R,G,B:R,G,B", top and bottom.
Background backgroundFrom(const std::string& text) {
  constexpr const char* kOption = "--background";
  constexpr const char* kExpected = "transparent, R,G,B or R,G,B:R,G,B (top:bottom) from 0 to 1";
  if (text == "transparent") return {};
  const std::size_t colon = text.find(':');
  const glm::dvec3 top = colorFrom(text.substr(0, colon), 1, kOption, kExpected);
  if (colon == std::string::npos) return {opaque(top), opaque(top)};
  return {opaque(top), opaque(colorFrom(text.substr(colon + 1), 1, kOption, kExpected))};
}

std::vector<ClipPlane> worldRegionFrom(const std::string& text) {
  constexpr const char* kOption = "--world-region";
  constexpr const char* kExpected = "six numbers X0,Y0,Z0,X1,Y1,Z1 in world units, each X0 below its X1";
  const std::vector<double> n = exactly(6, text, kOption, kExpected);
  const glm::dvec3 lo(n[0], n[1], n[2]), hi(n[3], n[4], n[5]);
  if (!(lo.x < hi.x && lo.y < hi.y && lo.z < hi.z))
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}, found '{}'", kOption, kExpected, text));
  return facesOf(lo, hi);
}

ClipPlane planeFrom(const std::string& text) {
  constexpr const char* kExpected = "four numbers NX,NY,NZ,D, the normal not zero";
  const std::vector<double> n = exactly(4, text, "--clip", kExpected);
  const ClipPlane plane{{n[0], n[1], n[2]}, n[3]};
  if (!(glm::length(plane.normal) > 0))
    throw Error(ErrorCode::kUsage, fmt::format("--clip: expected {}, found '{}'", kExpected, text));
  return plane;
}

void applyWeight(const std::optional<double>& given, double most, const char* option, double& weight) {
  if (!given) return;
  if (!(*given >= 0 && *given <= most))
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected a number from 0 to {}, found {}", option, most, *given));
  weight = *given;
}

// A job's box of the world and its planes are replaced each by its own option.
void applyPlanes(const SceneArguments& a, Clipping& clipping) {
  std::vector<ClipPlane>& all = clipping.planes;
  const auto faces_end = all.begin() + static_cast<std::ptrdiff_t>(clipping.box_faces);
  std::vector<ClipPlane> faces(all.begin(), faces_end), others(faces_end, all.end());
  if (a.world_region) faces = worldRegionFrom(*a.world_region);
  if (!a.planes.empty()) others.clear();
  for (const std::string& plane : a.planes) others.push_back(planeFrom(plane));
  clipping.box_faces = faces.size();
  all = std::move(faces);
  all.insert(all.end(), others.begin(), others.end());
}

}  // namespace

VoxelBox parseVoxelBox(const std::string& text, const char* option, const char* expected) {
  const std::vector<double> n = exactly(6, text, option, expected);
  VoxelBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const double lo = n[static_cast<std::size_t>(axis)], hi = n[static_cast<std::size_t>(axis) + 3];
    if (lo != std::floor(lo) || hi != std::floor(hi) || !(lo < hi) || !(lo >= -1e15 && hi <= 1e15))
      throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}, found '{}'", option, expected, text));
    box.lo[axis] = static_cast<std::int64_t>(lo);
    box.hi[axis] = static_cast<std::int64_t>(hi);
  }
  return box;
}

void SceneArguments::apply(PictureOptions& picture) const {
  Shading& s = picture.shading;
  if (shading) {
    if (*shading != "phong" && *shading != "none")
      throw Error(ErrorCode::kUsage, fmt::format("--shading: expected phong or none, found '{}'", *shading));
    s.phong = *shading == "phong";
  }
  applyWeight(ambient, 1000, "--ambient", s.ambient);
  applyWeight(diffuse, 1000, "--diffuse", s.diffuse);
  applyWeight(specular, 1000, "--specular", s.specular);
  applyWeight(power, 1e4, "--power", s.power);
  if (lights.size() > kMostLights)
    throw Error(ErrorCode::kUsage,
                fmt::format("--light: expected at most {} lights, found {}", kMostLights, lights.size()));
  if (planes.size() > kMostClipPlanes)
    throw Error(ErrorCode::kUsage,
                fmt::format("--clip: expected at most {} planes, found {}", kMostClipPlanes, planes.size()));
  if (!lights.empty()) {
    s.lights.clear();
    for (const std::string& light : lights) s.lights.push_back(lightFrom(light));
  }
  if (region)
    picture.clipping.region =
        parseVoxelBox(*region, "--region", "six whole numbers X0,Y0,Z0,X1,Y1,Z1, each X0 below its X1 (half-open)");
  applyPlanes(*this, picture.clipping);
  if (background) picture.background = backgroundFrom(*background);
}

void addSceneArguments(CLI::App& command, SceneArguments& a) {
  command.add_option("--shading", a.shading, "phong (default), or none: colours as the transfer function has them");
  addNumber(command, "--ambient", a.ambient, "light from everywhere; 0.2 if not given");
  addNumber(command, "--diffuse", a.diffuse, "of the lights, in the colour of the material; 0.8 if not given");
  addNumber(command, "--specular", a.specular, "of the lights, in their own colour; 0.2 if not given");
  addNumber(command, "--power", a.power, "how narrow highlights are; 16 if not given");
  command
      .add_option(
          "--light", a.lights,
          "headlight (default), dir:x,y,z towards a far light, or point:x,y,z, each with :r,g,b for its colour; "
          "may be given several times")
      ->type_name("LIGHT")
      ->allow_extra_args(false);
  command.add_option("--region", a.region, "show these voxels only, half-open")->type_name("X0,Y0,Z0,X1,Y1,Z1");
  command.add_option("--world-region", a.world_region, "show this box of the world only")
      ->type_name("X0,Y0,Z0,X1,Y1,Z1");
  command
      .add_option("--clip", a.planes, "show where nx·x + ny·y + nz·z + d >= 0 in the world; may be given several times")
      ->type_name("NX,NY,NZ,D")
      ->allow_extra_args(false);
  command
      .add_option("--background", a.background,
                  "transparent (default), a colour, or two from top to bottom; linear light")
      ->type_name("R,G,B[:R,G,B]");
}

TransferFunctionChoice transferFunctionNamed(const std::string& text, const char* option) {
  if (isPreset(text)) return text;
  if (isThere(fileOf(text))) {
    refuseVolumeFile(fileOf(text), "a transfer function");
    return std::filesystem::path(text);
  }
  throw Error(ErrorCode::kUsage, fmt::format("{}: '{}' is neither a file nor one of {}", option, text, presetList()));
}

PixelRect parseCrop(const std::string& text, const char* option) {
  constexpr const char* kExpected = "four whole numbers of pixels X,Y,W,H from 0 to 65536";
  const std::vector<double> n = exactly(4, text, option, kExpected);
  for (const double v : n) {
    if (v != std::floor(v) || !(v >= 0 && v <= 65536))
      throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}, found '{}'", option, kExpected, text));
  }
  const auto at = [&](std::size_t i) { return static_cast<int>(n[i]); };
  return {at(0), at(1), at(0) + at(2), at(1) + at(3)};
}

Window parseWindow(const std::string& text, const char* option) {
  constexpr const char* kExpected = "CENTRE,WIDTH, the width above 0";
  const std::vector<double> values = parseNumbers(text, ',', option, kExpected);
  if (values.size() != 2 || !(values[1] > 0))
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}, found '{}'", option, kExpected, text));
  return {values[0], values[1]};
}

}  // namespace kiln::tool
