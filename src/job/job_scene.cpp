// The keys of a job that say what a picture shows of the volume and in what light.
#include <glm/geometric.hpp>

#include "job/job_names.h"
#include "job/job_parts.h"
#include "scene/scene_limits.h"

namespace kiln {
namespace {

constexpr double kBrightest = 1e6;

bool brightness(double v) { return v >= 0 && v <= kBrightest; }

glm::dvec3 requiredVector(const JobObject& object, std::string_view key, const std::string& owner) {
  const auto out = worldVectorFrom(object, key);
  if (!out) object.complain(key, "is missing; a " + owner + " has one");
  return *out;
}

glm::dvec3 requiredDirection(const JobObject& object, std::string_view key, const std::string& owner) {
  const glm::dvec3 out = requiredVector(object, key, owner);
  if (!(glm::length(out) > 0)) object.refuse(key, "a direction, which the zero vector is not");
  return out;
}

Light lightFrom(const JobObject& object) {
  Light light;
  const auto kind = object.choice("type", kLightNames);
  if (!kind) object.complain("type", "is missing; a light is a headlight, directional or point");
  light.kind = static_cast<LightKind>(*kind);
  if (light.kind == LightKind::kDirectional) {
    object.requireKnown(job_keys::kDirectionalLight);
    light.place = requiredDirection(object, "direction", "directional light");
  } else if (light.kind == LightKind::kPoint) {
    object.requireKnown(job_keys::kPointLight);
    light.place = requiredVector(object, "position", "point light");
  } else {
    object.requireKnown(job_keys::kHeadlight);
  }
  if (const auto c = object.numbers<3>("color", "[red, green, blue] in linear light, from 0 to 1000000", brightness))
    light.color = {(*c)[0], (*c)[1], (*c)[2]};
  light.intensity = object.number("intensity", "a number from 0 to 1000000", brightness).value_or(light.intensity);
  return light;
}

ClipPlane planeFrom(const JobObject& object) {
  object.requireKnown(job_keys::kClipPlane);
  ClipPlane plane;
  plane.normal = requiredDirection(object, "normal", "clip plane");
  const auto offset = object.number("offset", "a number", legal::length);
  if (!offset) object.complain("offset", "is missing; a clip plane shows where normal·x + offset >= 0");
  plane.offset = *offset;
  return plane;
}

}  // namespace

std::optional<VoxelBox> voxelBoxFrom(const JobObject& owner, std::string_view key) {
  constexpr std::string_view kExpected =
      "six whole numbers [x0, y0, z0, x1, y1, z1] of voxels, each x0 below its x1 (half-open)";
  const auto voxel = [](double v) { return v == static_cast<double>(static_cast<std::int64_t>(v)); };
  const auto n = owner.numbers<6>(key, kExpected, [](double v) { return v >= -1e15 && v <= 1e15; });
  if (!n) return std::nullopt;
  VoxelBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const double lo = (*n)[static_cast<std::size_t>(axis)], hi = (*n)[static_cast<std::size_t>(axis) + 3];
    if (!voxel(lo) || !voxel(hi) || !(lo < hi)) owner.refuse(key, kExpected);
    box.lo[axis] = static_cast<std::int64_t>(lo);
    box.hi[axis] = static_cast<std::int64_t>(hi);
  }
  return box;
}

std::optional<glm::dvec3> worldVectorFrom(const JobObject& owner, std::string_view key) {
  const auto v = owner.numbers<3>(key, "[x, y, z] in world units", legal::length);
  return v ? std::optional(glm::dvec3((*v)[0], (*v)[1], (*v)[2])) : std::nullopt;
}

Shading shadingFrom(const JobObject& object) {
  object.requireKnown(job_keys::kShading);
  // An older way to say what "lights" says now.
  static constexpr std::array<std::string_view, 1> kLights = {"headlight"};
  Shading shading;
  shading.phong = object.choice("model", kShadingNames).value_or(0) == 0;
  object.choice("light", kLights);
  const auto weight = [&](std::string_view key, double otherwise) {
    return object.number(key, "a number from 0 to 1000", legal::shadingWeight).value_or(otherwise);
  };
  shading.ambient = weight("ambient", shading.ambient);
  shading.diffuse = weight("diffuse", shading.diffuse);
  shading.specular = weight("specular", shading.specular);
  shading.power = object.number("power", "a number from 0 to 10000", legal::shadingPower).value_or(shading.power);
  return shading;
}

std::vector<Light> lightsFrom(const JobObject& owner) {
  const auto lights = owner.objects("lights", "a list of lights [{type, …}, …]", {kMostLights, "lights"});
  std::vector<Light> out;
  for (const JobObject& light : *lights) out.push_back(lightFrom(light));
  return out;
}

std::vector<ClipPlane> planesFrom(const JobObject& owner, std::string_view key) {
  const auto planes = owner.objects(key, "a list of planes [{normal, offset}, …]", {kMostClipPlanes, "planes"});
  std::vector<ClipPlane> out;
  for (const JobObject& plane : *planes) out.push_back(planeFrom(plane));
  return out;
}

Clipping regionsFrom(const JobObject& owner) {
  Clipping out;
  out.region = voxelBoxFrom(owner, "region");
  constexpr std::string_view kBox = "[x0, y0, z0, x1, y1, z1] in world units, each x0 below its x1";
  if (const auto n = owner.numbers<6>("worldRegion", kBox, legal::length)) {
    const glm::dvec3 lo((*n)[0], (*n)[1], (*n)[2]), hi((*n)[3], (*n)[4], (*n)[5]);
    if (!(lo.x < hi.x && lo.y < hi.y && lo.z < hi.z)) owner.refuse("worldRegion", kBox);
    out.planes = facesOf(lo, hi);
    out.box_faces = out.planes.size();
  }
  return out;
}

Clipping clippingFrom(const JobObject& owner) {
  Clipping out = regionsFrom(owner);
  if (!owner.has("clip")) return out;
  const std::vector<ClipPlane> planes = planesFrom(owner, "clip");
  out.planes.insert(out.planes.end(), planes.begin(), planes.end());
  return out;
}

Background backgroundFrom(const JobObject& owner) {
  constexpr std::string_view kExpected = "[red, green, blue, alpha] from 0 to 1, premultiplied";
  if (!owner.has("background")) return {};
  if (!owner.isObject("background")) {
    const auto all = *owner.numbers<4>("background", kExpected, legal::fraction);
    return {all, all};
  }
  const JobObject ends = *owner.object("background");
  ends.requireKnown(job_keys::kGradient);
  for (const char* end : {"top", "bottom"}) {
    if (!ends.has(end)) ends.complain(end, "is missing; a gradient has top and bottom");
  }
  return {*ends.numbers<4>("top", kExpected, legal::fraction), *ends.numbers<4>("bottom", kExpected, legal::fraction)};
}

std::optional<Window> windowFrom(const JobObject& owner) {
  constexpr std::string_view kExpected = "[centre, width] in the volume's values, the width above 0";
  const auto numbers = owner.numbers<2>("window", kExpected, legal::voxelValue);
  if (!numbers) return std::nullopt;
  if (!((*numbers)[1] > 0)) owner.refuse("window", kExpected);
  return Window{(*numbers)[0], (*numbers)[1]};
}

}  // namespace kiln
