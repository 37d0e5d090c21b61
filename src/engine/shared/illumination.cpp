#include "engine/shared/illumination.h"

#include <glm/matrix.hpp>

namespace kiln {

ShadowLookup::ShadowLookup(const ShadowedLight& light, const View& view)
    : start_(static_cast<float>(light.start)), strength_(static_cast<float>(light.light.shadow.strength)) {
  const glm::dmat4 world_from_view = glm::inverse(view.view_from_world);
  for (const auto& maps : light.points) {
    std::vector<Map>& out = points_.emplace_back();
    for (const std::shared_ptr<const DeepShadowMap>& map : maps)
      out.push_back({map.get(), glm::mat4(map->view().view_from_world * world_from_view)});
  }
}

}  // namespace kiln
