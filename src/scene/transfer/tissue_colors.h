// Colours of tissues in presets, in linear light.
#pragma once

#include <glm/vec3.hpp>

namespace kiln::tint {

inline const glm::dvec3 kSkin{0.78, 0.50, 0.36}, kSkinLight{0.90, 0.66, 0.50}, kBone{0.88, 0.80, 0.64},
    kWhite{0.95, 0.94, 0.92};
inline const glm::dvec3 kMuscle{0.55, 0.12, 0.09}, kMuscleLight{0.75, 0.30, 0.22}, kFat{0.95, 0.75, 0.30},
    kBlood{0.70, 0.03, 0.02}, kBloodLight{0.90, 0.25, 0.08}, kLung{0.85, 0.45, 0.45};
inline const glm::dvec3 kCortex{0.62, 0.36, 0.32}, kWhiteMatter{0.85, 0.72, 0.64};
// A radiograph, from thin to dense.
inline const glm::dvec3 kFilmDark{0.15, 0.25, 0.40}, kFilm{0.35, 0.50, 0.70}, kFilmLight{0.60, 0.75, 0.90},
    kFilmWhite{0.95, 0.98, 1.0};

}  // namespace kiln::tint
