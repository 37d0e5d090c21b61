// CT values follow textbook ranges at 120 kV (fat -100, muscle 50, liver 60, cortical bone 1000 and more). MR values
// have only the right order, as MR has no absolute scale.
#include "phantom/models/tissue.h"

namespace kiln::phantom {
namespace {

struct Row {
  Tissue tissue;
  std::string_view name;
  float ct, mr, casting;
};

constexpr Row kRows[kTissueCount] = {
    {Tissue::kAir, "air", 24, 20, 10},
    {Tissue::kSkin, "skin", 1060, 620, 0},
    {Tissue::kFat, "fat", 930, 900, 0},
    {Tissue::kMuscle, "muscle", 1075, 360, 0},
    {Tissue::kTendon, "tendon", 1105, 120, 0},
    {Tissue::kCartilage, "cartilage", 1140, 280, 0},
    {Tissue::kCorticalBone, "cortical bone", 2050, 60, 0},
    {Tissue::kMarrow, "marrow", 1290, 620, 0},
    {Tissue::kTooth, "tooth", 3000, 40, 0},
    {Tissue::kLung, "lung", 250, 60, 0},
    {Tissue::kBlood, "blood", 1066, 160, 0},
    {Tissue::kHeart, "heart muscle", 1078, 370, 0},
    {Tissue::kVessel, "vessel wall", 1070, 330, 0},
    {Tissue::kLiver, "liver", 1086, 480, 0},
    {Tissue::kSpleen, "spleen", 1074, 330, 0},
    {Tissue::kPancreas, "pancreas", 1064, 440, 0},
    {Tissue::kKidneyCortex, "kidney cortex", 1062, 400, 0},
    {Tissue::kKidneyMedulla, "kidney medulla", 1054, 330, 0},
    {Tissue::kGland, "gland", 1090, 420, 0},
    {Tissue::kGutWall, "gut wall", 1068, 360, 0},
    {Tissue::kGutContent, "gut content", 1050, 300, 0},
    {Tissue::kFluid, "fluid", 1034, 150, 0},
    {Tissue::kGreyMatter, "grey matter", 1062, 500, 0},
    {Tissue::kWhiteMatter, "white matter", 1054, 660, 0},
    {Tissue::kEye, "vitreous body", 1036, 160, 0},
    {Tissue::kLens, "lens", 1110, 300, 0},
    {Tissue::kAluminium, "aluminium", 2800, 0, 118},
    {Tissue::kIron, "iron", 4000, 0, 205},
};

constexpr ValueTable table(float Row::*column, float noise_sigma, float highest) {
  ValueTable out;
  for (const Row& row : kRows) out.values[static_cast<std::size_t>(row.tissue)] = row.*column;
  out.noise_sigma = noise_sigma;
  out.highest = highest;
  return out;
}

constexpr bool rowsFollowTheEnumeration() {
  for (std::size_t i = 0; i < kTissueCount; ++i) {
    if (static_cast<std::size_t>(kRows[i].tissue) != i) return false;
  }
  return true;
}
static_assert(rowsFollowTheEnumeration());

}  // namespace

std::string_view nameOf(Tissue tissue) { return kRows[static_cast<std::size_t>(tissue)].name; }

const ValueTable& ctValues() {
  static constexpr ValueTable kTable = table(&Row::ct, 10, 4095);
  return kTable;
}
const ValueTable& mrValues() {
  static constexpr ValueTable kTable = table(&Row::mr, 10, 4095);
  return kTable;
}
const ValueTable& castingValues() {
  static constexpr ValueTable kTable = table(&Row::casting, 3, 255);
  return kTable;
}

}  // namespace kiln::phantom
