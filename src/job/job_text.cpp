// A job written out with every choice made. What does not change the picture (how fast, where to) is left out, so that
// equal pictures have equal EXR headers.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "job/job_names.h"
#include "job/render_job.h"

namespace kiln {
namespace {

using nlohmann::ordered_json;

ordered_json listOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

ordered_json jsonOf(const Camera& camera) {
  ordered_json out;
  out["projection"] = nameIn(kProjectionNames, camera.projection);
  if (camera.projection == Projection::kPerspective)
    out["fov"] = camera.fov_deg;
  else if (camera.projection == Projection::kOrthographic)
    out["height"] = camera.height;
  out["eye"] = listOf(camera.eye);
  out["target"] = listOf(camera.target);
  out["up"] = listOf(camera.up);
  return out;
}

ordered_json jsonOf(const TransferFunction& function) {
  if (!function.labels.empty()) {
    ordered_json labels = ordered_json::array();
    for (const LabelStyle& look : function.labels) {
      labels.push_back(
          {{"label", static_cast<std::int64_t>(look.label)}, {"color", listOf(look.color)}, {"opacity", look.opacity}});
      if (!look.name.empty()) labels.back()["name"] = look.name;
    }
    return {{"unit", function.unit}, {"colorSpace", "linear"}, {"labels", labels}};
  }
  ordered_json points = ordered_json::array();
  for (const TransferPoint& point : function.points) {
    points.push_back({{"value", point.value}, {"color", listOf(point.color)}, {"opacity", point.opacity}});
  }
  ordered_json out = {{"unit", function.unit}, {"colorSpace", "linear"}, {"points", points}};
  for (const GradientPoint& point : function.gradient_opacity)
    out["gradientOpacity"].push_back({{"gradient", point.gradient}, {"factor", point.factor}});
  return out;
}

ordered_json jsonOf(const Background& background) {
  if (background.top == background.bottom) return background.top;
  return {{"top", background.top}, {"bottom", background.bottom}};
}

ordered_json jsonOf(const Light& light) {
  ordered_json out;
  out["type"] = nameIn(kLightNames, light.kind);
  if (light.kind == LightKind::kDirectional) out["direction"] = listOf(light.place);
  if (light.kind == LightKind::kPoint) out["position"] = listOf(light.place);
  out["color"] = listOf(light.color);
  out["intensity"] = light.intensity;
  return out;
}

ordered_json jsonOf(const Shading& shading) {
  return {{"model", shading.phong ? "phong" : "none"},
          {"ambient", shading.ambient},
          {"diffuse", shading.diffuse},
          {"specular", shading.specular},
          {"power", shading.power}};
}

void addClipping(const Clipping& clipping, ordered_json& out) {
  const auto list = [](const VoxelBox& box) {
    return ordered_json({box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z});
  };
  if (clipping.region) out["region"] = list(*clipping.region);
  if (clipping.part) out["part"] = list(*clipping.part);
  if (clipping.planes.empty()) return;
  out["clip"] = ordered_json::array();
  for (const ClipPlane& plane : clipping.planes)
    out["clip"].push_back({{"normal", listOf(plane.normal)}, {"offset", plane.offset}});
}

ordered_json jsonOf(const VolumeOptions& volume) {
  ordered_json out = {{"volume", volume.volume.generic_string()},
                      {"transferFunction", jsonOf(std::get<TransferFunction>(volume.transfer_function))}};
  if (volume.shading) out["shading"] = jsonOf(*volume.shading);
  addClipping(volume.clipping, out);
  return out;
}

// Collects the differences between two values at the same place of two jobs.
void addDifferences(const ordered_json& there, const ordered_json& here, const std::string& place,
                    std::vector<std::string>& out) {
  if (there == here || there.is_discarded() || here.is_discarded()) return;
  // A moved store is the same volume.
  const auto is_name = [](const std::string& key, const ordered_json& value) {
    return key == "volume" && value.is_string();
  };
  const auto at = [&](const std::string& key) { return place.empty() ? key : place + "." + key; };
  if (there.is_object() && here.is_object()) {
    for (const auto& [key, value] : there.items()) {
      if (is_name(key, value)) continue;
      if (here.contains(key))
        addDifferences(value, here[key], at(key), out);
      else
        out.push_back(at(key) + " is there and not here");
    }
    for (const auto& [key, value] : here.items())
      if (!there.contains(key) && !is_name(key, value)) out.push_back(at(key) + " is here and not there");
  } else if (there.is_array() && here.is_array() && there.size() == here.size()) {
    for (std::size_t i = 0; i < there.size(); ++i)
      addDifferences(there[i], here[i], fmt::format("{}[{}]", place, i), out);
  } else if (there.is_structured() || here.is_structured()) {
    out.push_back(place + " is another");
  } else {
    out.push_back(fmt::format("{} is {} there and {} here", place, there.dump(), here.dump()));
  }
}

}  // namespace

std::string resolvedJobText(const RenderJob& job, const Camera& camera, const TransferFunction& transfer_function) {
  const PictureOptions& picture = job.picture;
  ordered_json out;
  out["kiln"] = 1;
  for (const VolumeOptions& volume : job.volumes) out["volumes"].push_back(jsonOf(volume));
  if (job.volumes.empty()) out["volume"] = job.volume.generic_string();
  out["image"] = {
      {"width", picture.size.width}, {"height", picture.size.height}, {"background", jsonOf(picture.background)}};
  if (const auto& crop = picture.crop) out["image"]["crop"] = {crop->x0, crop->y0, crop->width(), crop->height()};
  if (picture.aovs.depth) out["image"]["aov"].push_back(kAovNames[0]);
  if (picture.aovs.normal) out["image"]["aov"].push_back(kAovNames[1]);
  if (picture.aovs.value) out["image"]["aov"].push_back(kAovNames[2]);
  if (picture.mode != Mode::kComposite) out["mode"] = nameIn(kModeNames, picture.mode);
  out["camera"] = jsonOf(camera);
  if (const auto& stereo = picture.stereo) {
    out["stereo"] = {{"eye", nameIn(kStereoEyeNames, stereo->eye)}, {"interocular", stereo->interocular}};
    if (stereo->convergence) out["stereo"]["convergence"] = *stereo->convergence;
  }
  if (job.volumes.empty()) out["transferFunction"] = jsonOf(transfer_function);
  out["shading"] = jsonOf(picture.shading);
  out["lights"] = ordered_json::array();
  for (const Light& light : picture.shading.lights) out["lights"].push_back(jsonOf(light));
  addClipping(picture.clipping, out);
  if (picture.part) out["part"] = std::to_string(picture.part->index) + "/" + std::to_string(picture.part->count);
  out["visibility"] = {{"threshold", picture.opacity_threshold}};
  // The one method that changes the picture.
  const VisibilityOptions& visibility = job.speed.visibility;
  if (visibility.method == VisibilityMethod::kQuadtree) {
    out["visibility"]["method"] = "quadtree";
    out["visibility"]["area"] = nameIn(kProjectedAreaNames, visibility.area);
    out["visibility"]["epsilon"] = visibility.epsilon_px;
    out["tile"] = job.speed.tile_px;
  }
  out["lattice"] = nameIn(kLatticeNames, picture.lattice);
  if (picture.lattice == Lattice::kPixel) out["interpolation"] = nameIn(kInterpolationNames, picture.interpolation);
  if (picture.lattice != Lattice::kVoxel) out["sampleDistance"] = picture.sample_distance;
  out["level"] = picture.level ? ordered_json(*picture.level) : ordered_json("auto");
  out["samples"] = picture.samples ? ordered_json(*picture.samples) : ordered_json("auto");
  if (picture.skip_damaged) out["skipDamaged"] = true;
  // A file name need not be UTF-8; JSON must be.
  return out.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::string jobDifference(const std::string& there, const std::string& here) {
  constexpr std::size_t kMostSaid = 3;
  const auto parsed = [](const std::string& text) { return ordered_json::parse(text, nullptr, false); };
  std::vector<std::string> differences;
  addDifferences(parsed(there), parsed(here), "", differences);
  std::string out;
  for (std::size_t i = 0; i < std::min(differences.size(), kMostSaid); ++i) out += (i > 0 ? ", " : "") + differences[i];
  if (differences.size() > kMostSaid) out += fmt::format(", and {} more", differences.size() - kMostSaid);
  return out;
}

}  // namespace kiln
