#include "job/stereo.h"

#include <glm/geometric.hpp>
#include <string>

#include "base/error.h"
#include "job/frame_list.h"
#include "job/job_names.h"
#include "scene/camera/lens.h"

namespace kiln {
namespace fs = std::filesystem;

View resolve(const Camera& camera, const std::optional<Stereo>& stereo, const ImageSize& size) {
  View view = resolve(camera, size);
  if (!stereo) return view;
  if (view.projection != Projection::kPerspective)
    throw Error(ErrorCode::kUsage,
                "--stereo: a pair is of a perspective camera; an orthographic one sees the same with both eyes, and a "
                "panorama has no left and right; choose perspective");
  if (stereo->eye == StereoEye::kBoth) return view;
  const double offset = (stereo->eye == StereoEye::kLeft ? -0.5 : 0.5) * stereo->interocular;
  const double convergence = stereo->convergence.value_or(glm::length(camera.target - camera.eye));
  return fromMovedEye(view, {offset, 0}, convergence);
}

bool hasEyePlace(const fs::path& pattern) { return pathOfEye(pattern, StereoEye::kLeft) != pattern; }

fs::path pathOfEye(const fs::path& pattern, StereoEye eye) {
  std::string text = pattern.native();
  const std::string name(nameIn(kStereoEyeNames, eye));
  for (std::size_t at = literalPart(text, '%'); (at = text.find('%', at)) != std::string::npos; ++at) {
    const char kind = at + 1 < text.size() ? text[at + 1] : ' ';
    if (kind == 'V' || kind == 'v') text.replace(at, 2, kind == 'V' ? name : name.substr(0, 1));
  }
  return text;
}

}  // namespace kiln
