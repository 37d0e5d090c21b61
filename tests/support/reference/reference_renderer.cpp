#include "reference_renderer.h"

#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <span>

#include "base/thread/parallel.h"
#include "image/srgb.h"
#include "scene/clip_region.h"
#include "scene/transfer/display_map.h"
#include "support/reference/reference_field.h"
#include "support/reference/reference_labels.h"
#include "support/volumes/empty_blocks.h"

namespace kiln::test {
namespace {

/// At smaller transmittance, the rest of the ray adds less than a picture can represent.
constexpr double kStopTransmittance = 1e-6;

/// A face of the clip region; the half space normal·index + offset >= 0 is shown, in index space.
struct Face {
  glm::dvec3 normal;
  double offset;
  glm::dvec3 world_normal;  // normal in world space, transformed like a gradient; any length

  double at(const glm::dvec3& index) const { return glm::dot(normal, index) + offset; }
  /// Distance from a point to the face towards the eye. requires: the face is not seen edge-on.
  double distance(const glm::dvec3& index, const glm::dvec3& to_eye) const {
    return at(index) / -glm::dot(world_normal, to_eye);
  }
  /// Extent of a voxel's cube along the normal.
  double voxel() const { return std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z); }
};

glm::dvec3 worldNormal(const glm::dvec3& normal, const VolumeGeometry& volume) {
  return glm::transpose(glm::inverse(glm::dmat3(volume.world_from_index))) * normal;
}

std::vector<Face> facesOf(const Clipping& clipping, const VolumeGeometry& volume) {
  std::vector<Face> faces;
  for (int axis = 0; axis < 3 && clipping.region; ++axis) {
    glm::dvec3 along(0);
    along[axis] = 1;
    // A face at the border of the volume clips nothing.
    const auto lo = static_cast<double>(clipping.region->lo[axis]), hi = static_cast<double>(clipping.region->hi[axis]);
    if (lo > 0) faces.push_back({along, 0.5 - lo, {}});
    if (hi < static_cast<double>(volume.dims[axis])) faces.push_back({-along, hi - 0.5, {}});
  }
  for (const ClipPlane& plane : clipping.planes) {
    const glm::dvec4 world(plane.normal, plane.offset);
    const glm::dvec4 index = glm::transpose(volume.world_from_index) * world;
    faces.push_back({glm::dvec3(index), index.w, {}});
  }
  for (Face& face : faces) face.world_normal = worldNormal(face.normal, volume);
  return faces;
}

/// Faces of the volume's border, which light samples as faces of the clip region do.
std::vector<Face> borderOf(const VolumeGeometry& volume) {
  std::vector<Face> faces;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 along(0);
    along[axis] = 1;
    faces.push_back({along, 0.5, worldNormal(along, volume)});
    faces.push_back({-along, static_cast<double>(volume.dims[axis]) - 0.5, worldNormal(-along, volume)});
  }
  return faces;
}

/// All data of a picture that are equal for all rays.
struct Scene {
  Scene(const DenseVolume& volume, const View& the_view, const TransferFunction& function,
        const ReferenceSettings& the_settings)
      : field(volume, the_settings.interpolation),
        view(the_view),
        transfer_function(function),
        settings(the_settings),
        dims(volume.geometry.dims),
        world_from_index(volume.geometry.world_from_index),
        index_from_world(glm::inverse(volume.geometry.world_from_index)),
        gradient_world_from_index(glm::transpose(glm::inverse(glm::dmat3(volume.geometry.world_from_index)))),
        faces(facesOf(the_settings.clipping, volume.geometry)),
        border(borderOf(volume.geometry)) {
    const ValueRange range = volume.range();
    gradient_noise = range.empty() ? 0 : kGradientNoise * (range.hi - range.lo);
    const auto& points = function.points;
    if (!points.empty() && points.back().opacity < points.front().opacity) outward_sign = 1;
    step_world = settings.step_voxels * volume.geometry.shortestEdge();
    unit_world = transfer_function.unit > 0 ? transfer_function.unit : volume.geometry.meanSpacing();
    if (!function.labels.empty()) {
      labels.emplace(volume, function, settings.interpolation, settings.label_smoothing);
      gradient_noise = kGradientNoise;
      opaque =
          unit_world <= volume.geometry.meanSpacing() &&
          std::ranges::all_of(function.labels, [](const LabelStyle& l) { return l.opacity == 0 || l.opacity == 1; });
    }
    if (settings.skip_empty && !labels) {
      empty_blocks.emplace(
          dims, [this](std::int64_t i, std::int64_t j, std::int64_t k) { return field.voxel(i, j, k); },
          settings.interpolation == Interpolation::kLinear ? 1 : 2, function);
    }
  }

  /// Returns the label at a position in index space, and the gradient of its surface.
  ReferenceLabels::There at(const glm::dvec3& index) const {
    if (labels) return labels->at(index);
    const double value = field.at(index);
    if (!transfer_function.usesGradient()) return {transfer_function.at(value), 1};
    const double slope = glm::length(gradient_world_from_index * field.gradient(index));
    return {transfer_function.at(value, std::isfinite(slope) ? slope : 0), 1};
  }
  glm::dvec3 gradient(const glm::dvec3& index) const {
    return labels ? labels->gradient(index) : field.gradient(index);
  }

  ReferenceField field;
  std::optional<ReferenceLabels> labels;  // if the function is a function of labels
  const View& view;
  const TransferFunction& transfer_function;
  const ReferenceSettings& settings;
  Extent3 dims;
  glm::dmat4 world_from_index, index_from_world;
  glm::dmat3 gradient_world_from_index;
  std::vector<Face> faces, border;
  double gradient_noise = 0, outward_sign = -1, step_world = 1, unit_world = 1;
  bool opaque = false;  // only outsides of labels are seen
  std::optional<EmptyBlocks> empty_blocks;
};

/// The interval [begin, end] of the ray inside the volume's box; empty if begin >= end.
struct Segment {
  double begin, end;
  bool through_face = false;  // begins at a face of the clipping
};

Segment clipped(const Scene& scene, const Ray& ray) {
  const glm::dvec3 origin = glm::dvec3(scene.index_from_world * glm::dvec4(ray.origin, 1));
  const glm::dvec3 direction = glm::dvec3(scene.index_from_world * glm::dvec4(ray.direction, 0));
  Segment segment{ray.begin, ray.end};
  for (int axis = 0; axis < 3; ++axis) {
    const double lo = -0.5 - origin[axis];
    const double hi = static_cast<double>(scene.dims[axis]) - 0.5 - origin[axis];
    if (direction[axis] == 0) {
      if (lo > 0 || hi <= 0) return {0, 0};
      continue;
    }
    const double a = lo / direction[axis], b = hi / direction[axis];
    segment.begin = std::max(segment.begin, std::min(a, b));
    segment.end = std::min(segment.end, std::max(a, b));
  }
  for (const Face& face : scene.faces) {
    const double at_origin = face.at(origin), slope = glm::dot(face.normal, direction);
    if (slope == 0 && at_origin < 0) return {0, 0};
    if (slope > 0 && -at_origin / slope > segment.begin) {
      segment.begin = -at_origin / slope;
      segment.through_face = true;
    }
    if (slope < 0) segment.end = std::min(segment.end, -at_origin / slope);
  }
  return segment;
}

/// Calls sample(index position, length of the step) at the middle of each step, front to back, until false is returned.
/// Steps in empty blocks are skipped. Steps begin at the ray's entry; the last step is as long as the rest.
template <class Sample>
void march(const Scene& scene, const Ray& ray, const Sample& sample) {
  const Segment segment = clipped(scene, ray);
  if (!(segment.begin < segment.end)) return;
  // A remainder of a billionth of a step is rounding and belongs to the step before.
  const double steps = std::max(1.0, std::ceil((segment.end - segment.begin) / scene.step_world - 1e-9));
  const glm::dvec3 step_index = glm::dvec3(scene.index_from_world * glm::dvec4(ray.direction, 0)) * scene.step_world;
  for (double step = 0; step < steps;) {
    const double begin = segment.begin + step * scene.step_world;
    const double end = step + 1 < steps ? begin + scene.step_world : segment.end;
    const glm::dvec3 world = ray.origin + 0.5 * (begin + end) * ray.direction;
    const auto index = glm::dvec3(scene.index_from_world * glm::dvec4(world, 1));
    const double skipped = scene.empty_blocks ? scene.empty_blocks->stepsToSkip(index, step_index) : 0;
    if (!(skipped > 0) && !sample(index, end - begin)) return;
    step += std::max(1.0, skipped);
  }
}

struct Normal {
  glm::dvec3 normal;
  bool of_face = false;  // its sign has no meaning
};

/// Returns the normal at a sample: of the nearest face towards the eye, of the volume or of a clipping without a
/// section, if it is less than a voxel away, else of the gradient, out of matter; zero if there is none.
Normal normalAt(const Scene& scene, const glm::dvec3& index, const glm::dvec3& to_eye) {
  const Face* nearest = nullptr;
  for (const std::vector<Face>* faces : {&scene.faces, &scene.border}) {
    if (faces == &scene.faces && scene.settings.clipping.section) continue;
    for (const Face& face : *faces) {
      // A face seen edge-on lights nothing.
      if (glm::dot(face.world_normal, to_eye) > -1e-6 * glm::length(face.world_normal)) continue;
      if (!nearest || face.distance(index, to_eye) < nearest->distance(index, to_eye)) nearest = &face;
    }
  }
  if (nearest && nearest->at(index) < nearest->voxel()) return {glm::normalize(nearest->world_normal), true};
  const glm::dvec3 difference = scene.gradient(index);
  // The negated comparison also leaves a NaN gradient, which has no direction, unshaded.
  if (!(glm::length(difference) >= scene.gradient_noise) || glm::length(difference) == 0) return {glm::dvec3(0)};
  return {scene.outward_sign * glm::normalize(scene.gradient_world_from_index * difference)};
}

/// Returns the normal with which a sample is lit: see seenNormal in engine/shared/shade.h.
glm::dvec3 seenFrom(const Scene& scene, const Normal& at, const glm::dvec3& to_eye) {
  constexpr double kKept = 0.15, kReversed = 0.3;
  const double facing = glm::dot(at.normal, to_eye);
  if (facing >= 0) return at.normal;
  if (at.of_face || (!scene.opaque && facing <= -kReversed)) return -at.normal;
  const glm::dvec3 along = facing * to_eye;
  const double across = scene.opaque ? 1 : std::min(1 + 2 * (facing + kKept) / (kReversed - kKept), 1.0);
  return glm::normalize(across * (at.normal - along) - along);
}

/// Returns the extinction at a sample.
double extinctionAt(const Scene& scene, const ReferenceLabels::There& there) {
  return there.solid * extinctionOf(std::min(there.look.opacity, 0.9999), scene.unit_world);
}

double depthAlong(const Scene& scene, const Ray& ray) {
  double depth = 0;
  march(scene, ray, [&](const glm::dvec3& index, double length) {
    const ReferenceLabels::There sample = scene.at(index);
    if (sample.look.opacity > 0) depth += extinctionAt(scene, sample) * length;
    return true;
  });
  return depth;
}

/// Returns the colour and the opacity of the cut face at the beginning of a segment; an opacity of 0 without a face.
Classified faceAt(const Scene& scene, const Ray& ray, const Segment& segment) {
  const std::optional<Section>& section = scene.settings.clipping.section;
  if (!section || !segment.through_face || !(segment.begin < segment.end)) return {glm::dvec3(0), 0};
  const glm::dvec3 world = ray.origin + segment.begin * ray.direction;
  const auto index = glm::dvec3(scene.index_from_world * glm::dvec4(world, 1));
  if (section->color_map.empty()) {
    const ReferenceLabels::There there = scene.at(index);
    return {there.look.color, there.look.opacity > 0 ? there.solid * section->opacity : 0};
  }
  const double value = scene.field.at(index);
  if (std::isnan(value)) return {glm::dvec3(0), 0};
  const double share = std::clamp((value - section->window->x) / section->window->y + 0.5, 0.0, 1.0);
  glm::dvec3 color = displayMap(section->color_map).at(share);
  for (int channel = 0; channel < 3; ++channel) color[channel] = linearFromSrgb(color[channel]);
  return {color, section->opacity};
}

/// The scenes of a picture: one for each volume.
using Scenes = std::span<const std::unique_ptr<Scene>>;

/// Returns the share of a light that reaches a point through all volumes.
double shareFrom(Scenes scenes, const Shading& shading, const Light& light, const glm::dvec3& world,
                 const glm::dvec3& to_light) {
  if (!castsShadows(shading, light)) return 1;
  Ray ray{world, to_light, 0};
  if (light.kind == LightKind::kPoint) ray.end = glm::distance(light.place, world);
  double depth = 0;
  for (const std::unique_ptr<Scene>& scene : scenes) depth += depthAlong(*scene, ray);
  return 1 - light.shadow.strength * (1 - std::exp(-depth));
}

/// Returns the share of a light that reaches a surface, by a ray that begins at a height over the surface: towards the
/// light, and along the normal for the height that is missing. A `normal` of 0: none.
double reachingShare(Scenes scenes, const Shading& shading, const Light& light, const glm::dvec3& world,
                     const glm::dvec3& to_light, const glm::dvec3& normal) {
  const double missing = 1 - glm::dot(normal, to_light);
  const glm::dvec3 at = world + scenes.front()->settings.shadow_start * (to_light + missing * normal);
  const bool near = light.kind == LightKind::kPoint;
  return shareFrom(scenes, shading, light, at, near ? glm::normalize(light.place - at) : to_light);
}

/// Returns the share of ambient light that reaches a point with a normal: the mean of the visibility over directions
/// that are distributed as the cosine is. Matter at distance d takes away 1 - (d / radius)² of the light that it
/// absorbs.
double ambientShare(Scenes scenes, const Shading& shading, const glm::dvec3& world, const glm::dvec3& normal) {
  const ReferenceSettings& settings = scenes.front()->settings;
  if (settings.occlusion_rays == 0 || shading.occlusion.strength == 0) return 1;
  const glm::dvec3 beside = std::abs(normal.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 across = glm::normalize(glm::cross(normal, beside)), along = glm::cross(normal, across);
  std::uint64_t seed = 0;
  for (int axis = 0; axis < 3 && !settings.equal_occlusion_rays; ++axis)
    seed = hashBits(seed, std::bit_cast<std::uint64_t>(world[axis]));
  const double radius = shading.occlusion.radius, n = settings.occlusion_rays;
  double sum = 0;
  for (int i = 0; i < settings.occlusion_rays; ++i) {
    // A stratum of the cosine's distribution for each ray.
    const double u = (i + hashUnit(seed, 2 * static_cast<std::uint64_t>(i))) / n;
    const double angle = 2 * std::numbers::pi * hashUnit(seed, 2 * static_cast<std::uint64_t>(i) + 1);
    const glm::dvec3 direction =
        std::sqrt(u) * (std::cos(angle) * across + std::sin(angle) * along) + std::sqrt(1 - u) * normal;
    const Ray ray{world + settings.occlusion_start * normal, direction, 0, radius};
    double open = 1, seen = 1;
    for (const std::unique_ptr<Scene>& scene : scenes) {
      march(*scene, ray, [&](const glm::dvec3& index, double length) {
        const ReferenceLabels::There sample = scene->at(index);
        if (!(sample.look.opacity > 0)) return true;
        const glm::dvec3 at = scene->world_from_index * glm::dvec4(index, 1);
        const double part = glm::distance(at, ray.origin) / radius;
        const double through = std::exp(-extinctionAt(*scene, sample) * length);
        seen -= open * (1 - through) * std::max(0.0, 1 - part * part);
        open *= through;
        return open > 1e-3;
      });
    }
    sum += seen;
  }
  return 1 - shading.occlusion.strength * (1 - sum / n);
}

/// scene/shading.h: colour·(ambient + Σ L·diffuse·n·l) + Σ L·specular·(n·h)^power, n towards the eye.
glm::dvec3 shaded(Scenes scenes, const Scene& scene, const Shading& shading, const glm::dvec3& color,
                  const glm::dvec3& index, const glm::dvec3& world, const glm::dvec3& to_eye) {
  const TransferFunction& function = scene.transfer_function;
  if (!shading.phong || (!function.shaded && !function.scattering)) return color;
  const auto directionOf = [&](const Light& light) {
    if (light.kind == LightKind::kDirectional) return glm::normalize(light.place);
    return light.kind == LightKind::kPoint ? glm::normalize(light.place - world) : to_eye;
  };
  if (const auto& scattering = function.scattering) {
    glm::dvec3 sum(shading.ambient);
    for (const Light& light : shading.lights) {
      const glm::dvec3 towards = directionOf(light);
      sum += shading.diffuse * scattering->phase(-glm::dot(towards, to_eye)) *
             shareFrom(scenes, shading, light, world, towards) * light.intensity * light.color;
    }
    return scattering->albedo * color * sum;
  }
  const Normal found = normalAt(scene, index, to_eye);
  if (found.normal == glm::dvec3(0)) {
    // The material's colour, without the share of the lights that shadows take away.
    glm::dvec3 all(0), reaching(0);
    for (const Light& light : shading.lights) {
      const glm::dvec3 sent = light.intensity * light.color;
      all += sent, reaching += reachingShare(scenes, shading, light, world, directionOf(light), glm::dvec3(0)) * sent;
    }
    if (all == reaching) return color;
    return color * (shading.ambient * all + shading.diffuse * reaching) / ((shading.ambient + shading.diffuse) * all);
  }
  const glm::dvec3 seen = seenFrom(scene, found, to_eye);
  glm::dvec3 matte(shading.ambient * ambientShare(scenes, shading, world, seen)), gloss(0);
  for (const Light& light : shading.lights) {
    const glm::dvec3 to_light = directionOf(light);
    const bool from_eye = light.kind == LightKind::kHeadlight;
    const glm::dvec3 normal = from_eye && glm::dot(found.normal, to_eye) < 0 ? -found.normal
                              : from_eye                                     ? found.normal
                                                                             : seen;
    if (!(glm::dot(normal, to_light) > 0)) continue;
    const glm::dvec3 halfway = glm::normalize(to_light + to_eye);
    const glm::dvec3 reaching =
        reachingShare(scenes, shading, light, world, to_light, normal) * light.intensity * light.color;
    matte += shading.diffuse * glm::dot(normal, to_light) * reaching;
    gloss += shading.specular * std::pow(std::max(0.0, glm::dot(normal, halfway)), shading.power) * reaching;
  }
  return color * matte + gloss;
}

/// Returns the premultiplied RGBA of a ray over a clear background.
glm::dvec4 lightAlong(Scenes scenes, const Shading& shading, const Ray& ray) {
  const Scene& scene = *scenes.front();
  const Classified face = faceAt(scene, ray, clipped(scene, ray));
  glm::dvec3 light = face.opacity * face.color;
  double transmittance = 1 - face.opacity;
  bool closed = false;
  if (transmittance == 0) return {light, 1};
  march(scene, ray, [&](const glm::dvec3& index, double length) {
    const ReferenceLabels::There sample = scene.at(index);
    if (!(sample.look.opacity > 0)) return true;
    const double alpha = 1 - std::exp(-extinctionAt(scene, sample) * length);
    const glm::dvec3 world = scene.world_from_index * glm::dvec4(index, 1);
    light += transmittance * alpha * shaded(scenes, scene, shading, sample.look.color, index, world, -ray.direction);
    transmittance *= 1 - alpha;
    closed = scene.settings.opacity_threshold < 1 && 1 - transmittance >= scene.settings.opacity_threshold;
    return !closed && transmittance >= kStopTransmittance;
  });
  if (closed) return {light / (1 - transmittance), 1};
  return {light, 1 - transmittance};
}

/// Returns the light of several volumes along a ray: their extinctions add up.
glm::dvec4 lightAlong(Scenes scenes, const std::vector<ReferenceVolume>& volumes, const Ray& ray) {
  std::vector<Segment> segments;
  double step = std::numeric_limits<double>::infinity(), begin = step, end = -step;
  for (const std::unique_ptr<Scene>& scene : scenes) {
    const Segment segment = clipped(*scene, ray);
    segments.push_back(segment);
    step = std::min(step, scene->step_world);
    if (!(segment.begin < segment.end)) continue;
    begin = std::min(begin, segment.begin), end = std::max(end, segment.end);
  }
  glm::dvec3 light(0);
  double transmittance = 1;
  for (double at = begin; at < end; at += step) {
    double depth = 0;
    glm::dvec3 sent(0);
    for (std::size_t v = 0; v < scenes.size(); ++v) {
      // The part of the step inside the volume.
      const double from = std::max(at, segments[v].begin), to = std::min(at + step, segments[v].end);
      if (!(from < to)) continue;
      const Scene& scene = *scenes[v];
      if (from == segments[v].begin) {
        const Classified face = faceAt(scene, ray, segments[v]);
        const double of_face = extinctionOf(face.opacity, 1);
        depth += of_face, sent += of_face * face.color;
      }
      const glm::dvec3 world = ray.origin + 0.5 * (from + to) * ray.direction;
      const auto index = glm::dvec3(scene.index_from_world * glm::dvec4(world, 1));
      if (scene.empty_blocks && scene.empty_blocks->stepsToSkip(index, glm::dvec3(1)) > 0) continue;
      const ReferenceLabels::There sample = scene.at(index);
      if (!(sample.look.opacity > 0)) continue;
      const double of_volume = extinctionAt(scene, sample) * (to - from);
      depth += of_volume;
      sent += of_volume * shaded(scenes, scene, volumes[v].shading, sample.look.color, index, world, -ray.direction);
    }
    if (!(depth > 0)) continue;
    const double alpha = 1 - std::exp(-depth);
    light += transmittance * alpha * sent / depth;
    transmittance *= 1 - alpha;
    const double threshold = scenes.front()->settings.opacity_threshold;
    if (threshold < 1 && 1 - transmittance >= threshold) return {light / (1 - transmittance), 1};
    if (transmittance < kStopTransmittance) break;
  }
  return {light, 1 - transmittance};
}

/// Calls draw(column, row, rays) for every pixel with its n × n rays, through the centres of n × n equal squares.
template <class Draw>
void forEachPixel(const Scene& scene, const Draw& draw) {
  const int n = scene.settings.rays_per_axis;
  parallelFor(static_cast<std::size_t>(scene.view.size.height), [&](std::size_t line) {
    const int row = static_cast<int>(line);
    std::vector<Ray> rays;
    for (int column = 0; column < scene.view.size.width; ++column) {
      rays.clear();
      for (int sub_row = 0; sub_row < n; ++sub_row) {
        for (int sub_column = 0; sub_column < n; ++sub_column) {
          rays.push_back(rayThrough(scene.view, {column + (sub_column + 0.5) / n, row + (sub_row + 0.5) / n}));
        }
      }
      draw(column, row, rays);
    }
  });
}

}  // namespace

Ray rayThrough(const View& view, const glm::dvec2& pixel) {
  const glm::dmat4 world_from_view = glm::inverse(view.view_from_world);
  const glm::dvec2 offset = (pixel - view.centre_px) / view.focal_px;
  if (view.projection == Projection::kEquirectangular) {
    // Rotated about the up axis, then raised. View space has y down.
    const double longitude = 2 * glm::pi<double>() * (pixel.x / view.size.width - 0.5);
    const double latitude = glm::pi<double>() * (0.5 - pixel.y / view.size.height);
    const glm::dvec3 level = std::cos(longitude) * glm::dvec3(0, 0, 1) + std::sin(longitude) * glm::dvec3(1, 0, 0);
    const glm::dvec3 direction = std::cos(latitude) * level + std::sin(latitude) * glm::dvec3(0, -1, 0);
    return {glm::dvec3(world_from_view[3]), glm::normalize(glm::dvec3(world_from_view * glm::dvec4(direction, 0))), 0};
  }
  if (view.projection == Projection::kPerspective) {
    const glm::dvec3 direction = glm::dvec3(world_from_view * glm::dvec4(offset, 1, 0));
    return {glm::dvec3(world_from_view[3]), glm::normalize(direction), 0};
  }
  return {glm::dvec3(world_from_view * glm::dvec4(offset, 0, 1)),
          glm::normalize(glm::dvec3(world_from_view * glm::dvec4(0, 0, 1, 0))),
          -std::numeric_limits<double>::infinity()};
}

Image referenceImage(const DenseVolume& volume, const View& view, const TransferFunction& transfer_function,
                     const Shading& shading, const std::array<double, 4>& background,
                     const ReferenceSettings& settings) {
  std::vector<std::unique_ptr<Scene>> scenes;
  scenes.push_back(std::make_unique<Scene>(volume, view, transfer_function, settings));
  const glm::dvec4 behind(background[0], background[1], background[2], background[3]);
  Image image(view.size.width, view.size.height);
  forEachPixel(*scenes.front(), [&](int column, int row, const std::vector<Ray>& rays) {
    glm::dvec4 sum(0);
    for (const Ray& ray : rays) {
      const glm::dvec4 light = lightAlong(scenes, shading, ray);
      sum += light + (1 - light.a) * behind;
    }
    for (int channel = 0; channel < 4; ++channel) {
      image.pixel(column, row)[channel] = static_cast<float>(sum[channel] / static_cast<double>(rays.size()));
    }
  });
  return image;
}

Image referenceImage(const std::vector<ReferenceVolume>& volumes, const View& view, const ReferenceSettings& settings) {
  std::vector<ReferenceSettings> of_volumes;
  for (const ReferenceVolume& volume : volumes) {
    of_volumes.push_back(settings);
    of_volumes.back().clipping = volume.clipping;
  }
  std::vector<std::unique_ptr<Scene>> scenes;
  for (std::size_t v = 0; v < volumes.size(); ++v)
    scenes.push_back(std::make_unique<Scene>(*volumes[v].volume, view, volumes[v].transfer_function, of_volumes[v]));
  Image image(view.size.width, view.size.height);
  forEachPixel(*scenes.front(), [&](int column, int row, const std::vector<Ray>& rays) {
    glm::dvec4 sum(0);
    for (const Ray& ray : rays) sum += lightAlong(scenes, volumes, ray);
    for (int channel = 0; channel < 4; ++channel)
      image.pixel(column, row)[channel] = static_cast<float>(sum[channel] / static_cast<double>(rays.size()));
  });
  return image;
}

OpticalDepthImage opticalDepthImage(const DenseVolume& volume, const View& view,
                                    const TransferFunction& transfer_function, const ReferenceSettings& settings) {
  const Scene scene(volume, view, transfer_function, settings);
  OpticalDepthImage image{view.size.width, view.size.height, {}, {}};
  const auto pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  image.depth.resize(pixels);
  image.transmittance.resize(pixels);
  forEachPixel(scene, [&](int column, int row, const std::vector<Ray>& rays) {
    const auto place =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(column);
    for (const Ray& ray : rays) {
      const double depth = depthAlong(scene, ray);
      image.depth[place] += depth / static_cast<double>(rays.size());
      image.transmittance[place] += std::exp(-depth) / static_cast<double>(rays.size());
    }
  });
  return image;
}

std::vector<double> firstHits(const DenseVolume& volume, const View& view, const TransferFunction& transfer_function,
                              ReferenceSettings settings) {
  settings.rays_per_axis = 1;
  const Scene scene(volume, view, transfer_function, settings);
  std::vector<double> out(static_cast<std::size_t>(view.size.width) * static_cast<std::size_t>(view.size.height),
                          std::numeric_limits<double>::infinity());
  forEachPixel(scene, [&](int column, int row, const std::vector<Ray>& rays) {
    const Ray& ray = rays.front();
    double depth = 0;
    march(scene, ray, [&](const glm::dvec3& index, double length) {
      const ReferenceLabels::There sample = scene.at(index);
      if (!(sample.look.opacity > 0)) return true;
      depth += extinctionAt(scene, sample) * length;
      if (depth < std::numbers::ln2) return true;
      const glm::dvec3 world = scene.world_from_index * glm::dvec4(index, 1);
      out[static_cast<std::size_t>(row) * static_cast<std::size_t>(view.size.width) +
          static_cast<std::size_t>(column)] = glm::dot(world - ray.origin, ray.direction);
      return false;
    });
  });
  return out;
}

ProjectedImage projectedImage(const DenseVolume& volume, const View& view, const ReferenceSettings& settings) {
  ReferenceSettings one_ray = settings;
  one_ray.rays_per_axis = 1;
  one_ray.skip_empty = false;
  const TransferFunction none;
  const Scene scene(volume, view, none, one_ray);
  constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
  const auto pixels = static_cast<std::size_t>(view.size.width) * static_cast<std::size_t>(view.size.height);
  ProjectedImage image{view.size.width, view.size.height, std::vector(pixels, kNoValue), std::vector(pixels, kNoValue),
                       std::vector(pixels, kNoValue)};
  forEachPixel(scene, [&](int column, int row, const std::vector<Ray>& rays) {
    const auto place =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(column);
    ValueRange range;
    double sum = 0, length = 0;
    march(scene, rays.front(), [&](const glm::dvec3& index, double step) {
      const double value = scene.field.at(index);
      range.include(value);
      if (!std::isnan(value)) sum += value * step, length += step;
      return true;
    });
    if (range.empty()) return;
    image.greatest[place] = range.hi;
    image.least[place] = range.lo;
    image.mean[place] = sum / length;
  });
  return image;
}

std::vector<double> attenuatedImage(const DenseVolume& volume, const View& view, double attenuation,
                                    const ValueRange& values, const ReferenceSettings& settings) {
  ReferenceSettings one_ray = settings;
  one_ray.rays_per_axis = 1;
  one_ray.skip_empty = false;
  const TransferFunction none;
  const Scene scene(volume, view, none, one_ray);
  std::vector<double> out(static_cast<std::size_t>(view.size.width) * static_cast<std::size_t>(view.size.height),
                          std::numeric_limits<double>::quiet_NaN());
  const double per_length = attenuation / volume.geometry.meanSpacing();
  forEachPixel(scene, [&](int column, int row, const std::vector<Ray>& rays) {
    double depth = 0, most = -1;
    march(scene, rays.front(), [&](const glm::dvec3& index, double step) {
      const double value = scene.field.at(index);
      if (std::isnan(value)) return true;
      const double share = std::clamp((value - values.lo) / (values.hi - values.lo), 0.0, 1.0);
      const double own = per_length * share * step;
      most = std::max(most, share * std::exp(-(depth + 0.5 * own)));
      depth += own;
      return true;
    });
    if (most < 0) return;
    out[static_cast<std::size_t>(row) * static_cast<std::size_t>(view.size.width) + static_cast<std::size_t>(column)] =
        values.lo + most * (values.hi - values.lo);
  });
  return out;
}

}  // namespace kiln::test
