// Shadows of a frame's lights, and their look-up by samples.
// Method. A sample looks up the transmittance between a light and a point `start` from the sample towards the light.
// The layers of the sample's own surface lie nearer than `start`, and do not shadow it.
// Invariant. The maps depend on the volumes, their functions, clipping and the light, never on the picture's crop.
#pragma once

#include <algorithm>
#include <cmath>
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
  double start = 0;     // unit: world
  std::vector<std::vector<std::shared_ptr<const DeepShadowMap>>> points;  // none: the light casts no shadows
};

/// Everything but the light that shadows depend on.
struct ShadowScene {
  std::vector<TransferFunction> functions;  // one for each volume
  std::vector<Clipping> clippings;          // without parts
  std::optional<int> level;
  int coarser = 0;
  Interpolation interpolation = Interpolation::kLinear;
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
  /// In grazing light a pixel of the map covers a long part of a surface: samples look up a point farther away, up to
  /// four times. Without, rounded bone in grazing light has bright and dark lines.
  static constexpr float kLeastCosine = 0.25f;

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
  /// Distance from a sample to the nearest layer that shadows the sample. unit: world.
  float start() const { return start_; }
  /// Returns the share of the light that reaches a sample. `to_light`: unit vector in view space; `cosine`: of the
  /// angle between the sample's normal and the light, 1 without a normal.
  float operator()(const glm::vec3& view_point, const glm::vec3& to_light, float cosine) const {
    if (points_.empty()) return 1;
    return share(view_point + start_ / std::max(cosine, kLeastCosine) * to_light);
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
