// Hounsfield units: air -1000, aerated lung -950 to -700, fat -120 to -60, water 0, muscle and blood 30 to 80, blood
// with contrast agent 150 to 450, spongy bone 150 to 500, compact bone 500 to 1900, enamel and metal above. Surfaces
// reach 0.9 within the blur of a scanner. Tissue that other tissue shows through has 0.05 to 0.3 per voxel of a CT of
// 512 voxels: a layer of a few voxels is a veil, an organ is nearly solid.
#include "scene/transfer/ct_presets.h"

#include "scene/transfer/tissue_colors.h"

namespace kiln {
namespace {

std::vector<CtPreset> madePresets() {
  return {
      {"ct-skin",
       OpacityLength::kVoxel,
       {{-550, tint::kSkin, 0}, {-350, tint::kSkin, 0.9}, {100, tint::kSkinLight, 0.9}, {300, tint::kBone, 0.95}}},
      {"ct-bone", OpacityLength::kVoxel, {{130, tint::kBone, 0}, {330, tint::kBone, 0.9}, {1000, tint::kWhite, 0.97}}},
      // Skin is the border to air; tissue between skin and bone would hide the bone and is left out.
      {"ct-bone-and-skin",
       OpacityLength::kObject,
       {{-700, tint::kSkin, 0},
        {-400, tint::kSkin, 0.1},
        {-200, tint::kSkin, 0.1},
        {-50, tint::kSkinLight, 0},
        {130, tint::kBone, 0},
        {330, tint::kBone, 0.9},
        {1000, tint::kWhite, 0.97}}},
      // Fat is left out, so that muscles below it show; skin is a veil.
      {"ct-muscle",
       OpacityLength::kObject,
       {{0, tint::kMuscle, 0},
        {40, tint::kMuscle, 0.12},
        {90, tint::kMuscle, 0.2},
        {150, tint::kMuscleLight, 0.15},
        {250, tint::kBone, 0.3},
        {400, tint::kBone, 0.9},
        {1000, tint::kWhite, 0.97}}},
      {"ct-fat",
       OpacityLength::kObject,
       {{-180, tint::kFat, 0},
        {-130, tint::kFat, 0.15},
        {-60, tint::kFat, 0.15},
        {-20, tint::kFat, 0},
        {200, tint::kBone, 0},
        {400, tint::kBone, 0.7},
        {1000, tint::kWhite, 0.95}}},
      // Aerated tissue alone. The border of the body has the same values within a voxel, a faint outline.
      {"ct-lung",
       OpacityLength::kObject,
       {{-940, tint::kLung, 0},
        {-860, tint::kLung, 0.04},
        {-760, tint::kLung, 0.04},
        {-600, tint::kLung, 0.012},
        {-350, tint::kLung, 0}}},
      // Blood with contrast agent in red; bone has the same values where it is spongy.
      {"ct-vessels",
       OpacityLength::kObject,
       {{130, tint::kBlood, 0},
        {250, tint::kBlood, 0.35},
        {400, tint::kBloodLight, 0.7},
        {600, tint::kBone, 0.9},
        {1200, tint::kWhite, 0.95}}},
      // Enamel and fillings in the shadow of the bone.
      {"ct-teeth",
       OpacityLength::kObject,
       {{250, tint::kBone, 0},
        {500, tint::kBone, 0.015},
        {1300, tint::kBone, 0.03},
        {1600, tint::kWhite, 0.6},
        {2200, tint::kWhite, 0.97}}},
      // As a radiograph: each layer absorbs little, more with its density, and no layer reflects light.
      {"ct-xray",
       OpacityLength::kObject,
       {{-500, tint::kFilmDark, 0},
        {-100, tint::kFilmDark, 0.0015},
        {80, tint::kFilm, 0.003},
        {300, tint::kFilmLight, 0.012},
        {1000, tint::kFilmWhite, 0.05},
        {2000, glm::dvec3(1), 0.12}},
       false},
  };
}

}  // namespace

const std::vector<CtPreset>& ctPresets() {
  static const std::vector<CtPreset> presets = madePresets();
  return presets;
}

}  // namespace kiln
