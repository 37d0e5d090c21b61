// Colours of tissues in presets, in linear light. Of tissues at most 0.8: a highlight of the default shading adds 0.2,
// so that a face towards the light does not saturate.
#pragma once

#include <glm/vec3.hpp>

namespace kiln::tint {

inline const glm::dvec3 kSkin{0.78, 0.50, 0.36}, kSkinLight{0.80, 0.59, 0.45}, kBone{0.80, 0.73, 0.58},
    kWhite{0.80, 0.79, 0.78};
inline const glm::dvec3 kMuscle{0.55, 0.12, 0.09}, kMuscleLight{0.75, 0.30, 0.22}, kFat{0.80, 0.63, 0.25},
    kBlood{0.70, 0.03, 0.02}, kBloodLight{0.80, 0.22, 0.07}, kLung{0.80, 0.42, 0.42};
inline const glm::dvec3 kCortex{0.62, 0.36, 0.32}, kWhiteMatter{0.80, 0.68, 0.60};
// A radiograph, from thin to dense.
inline const glm::dvec3 kFilmDark{0.15, 0.25, 0.40}, kFilm{0.35, 0.50, 0.70}, kFilmLight{0.60, 0.75, 0.90},
    kFilmWhite{0.95, 0.98, 1.0};

}  // namespace kiln::tint
