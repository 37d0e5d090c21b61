// Shadows of a frame's lights, and their look-up by samples.
// Method. A sample looks up the transmittance between a light and a point at the height `start` above the sample's
// surface, towards the light. The layers of the sample's own surface lie lower, and do not shadow it.
// Source: Holbert 2011 (a step along the normal). Differs: light along the normal needs no such step.
// Invariant. The maps depend on the volumes, their functions, clipping and the light, never on the picture's crop.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "engine/shared/ambient_occlusion.h"
#include "engine/shared/deep_shadow_map.h"
#include "scene/clipping.h"
#include "scene/render_options.h"
#include "scene/shading.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

/// The shadow maps of a light. A soft light is the mean of several points, each with one map, or with six around a
/// point that is near the volume.
struct ShadowedLight {
  Light light;
  glm::dvec3 place{0};  // of the light in the world: a camera light's direction depends on the eye
  int edge_px = 0;      // longest edge of a map
  double start = 0;     // height over a surface of the layers that shadow it. unit: world
  std::vector<std::vector<std::shared_ptr<const DeepShadowMap>>> points;  // none: the light casts no shadows
};

/// Everything but the light that shadows depend on.
struct ShadowScene {
  std::vector<TransferFunction> functions;  // one for each volume
  std::vector<Clipping> clippings;          // without parts
  std::optional<int> level;
  int coarser = 0;
  Interpolation interpolation = Interpolation::kLinear;
  double sample_distance = 0;  // of the maps' own samples. unit: voxels
  double opacity_threshold = 1;
  bool operator==(const ShadowScene&) const = default;
};

/// Data about light that all samples of a frame share.
struct Illumination {
  ShadowScene scene;
  std::vector<ShadowedLight> lights;           // in the order of the frame's lights
  std::shared_ptr<const AmbientGrid> ambient;  // null: no ambient occlusion
  double ambient_radius = 0;                   // that the grid was made for. unit: world
};

/// The shadow of a light on samples given in view space.
class ShadowLookup {
 public:
  /// No shadow.
  ShadowLookup() = default;
  /// requires: `light` outlives the object.
  ShadowLookup(const ShadowedLight& light, const View& view);

  struct Map {
    const DeepShadowMap* map;
    glm::mat4 light_from_view;
  };

  bool none() const { return points_.empty(); }
  /// The maps of each point of the light.
  const std::vector<std::vector<Map>>& points() const { return points_; }
  float strength() const { return strength_; }
  /// Height over a sample's surface of the nearest layer that shadows the sample. unit: world.
  float start() const { return start_; }
  /// Returns the share of the light that reaches a sample. A step of length `start` towards the light rises by `start`
  /// times the cosine; a step along the normal adds the rest. Figures:
  /// frame/decisions/shadow-start.md. `normal`, `to_light`: unit vectors in view space; `normal` is 0 if there is none.
  /// requires: an angle between them of at most 90 degrees.
  float operator()(const glm::vec3& view_point, const glm::vec3& normal, const glm::vec3& to_light) const {
    if (points_.empty()) return 1;
    const float missing = 1 - glm::dot(normal, to_light);
    return share(view_point + start_ * (to_light + missing * normal));
  }
  /// Returns the share at a point itself. requires: maps.
  float share(const glm::vec3& view_point) const {
    float sum = 0;
    for (const std::vector<Map>& maps : points_) sum += reaching(maps, view_point);
    return 1 - strength_ * (1 - sum / static_cast<float>(points_.size()));
  }

 private:
  static float reaching(const std::vector<Map>& maps, const glm::vec3& view_point) {
    // The map, among six around the light, of the face that the point lies behind.
    for (const Map& map : maps) {
      const glm::vec3 at(map.light_from_view * glm::vec4(view_point, 1));
      if (maps.size() > 1 && !(at.z > 0 && at.z >= std::abs(at.x) && at.z >= std::abs(at.y))) continue;
      return map.map->transmittance(at);
    }
    return 1;
  }

  std::vector<std::vector<Map>> points_;
  float start_ = 0, strength_ = 1;
};

}  // namespace kiln
