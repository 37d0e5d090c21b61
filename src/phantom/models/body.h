// A standing man of 1.83 m as a table of parts, with the proportions of the Visible Human volume: a box of 587 × 341 ×
// 1878 mm, soles down, face towards -y, arms beside the body.
// Each list is one region. `bodyParts` orders the lists by precedence: a cavity overrides its bone, a bone the flesh
// around it, and air overrides everything.
// Left is +x; a paired part is written for the left side.
#pragma once

#include "phantom/models/figure.h"

namespace kiln::phantom {

/// Extents of the box, from (-x/2, -y/2, 0). unit: mm.
inline constexpr double kBodyBoxMm[3] = {587, 341, 1878};

PartList bodyParts();

// body_skin.cpp
PartSpec bodySurface();
// body_hands_feet.cpp: flesh is part of the surface, bones of the skeleton.
std::vector<ShapeSpec> handAndFootFlesh();
PartList handAndFootBones();
// body_spine.cpp: vertebrae, ribs and sternum, and the contents of the spinal canal.
PartList spineAndRibs();
PartList spinalCord();
// body_skeleton.cpp
PartList limbBones();
// body_head.cpp
PartList skull();
PartList headContents();
PartList teeth();
// body_organs.cpp
PartList trunkCavities();
PartList organs();
PartList vessels();
PartList airways();

// Tissues shared by many parts.
inline constexpr Layers kBone = shellOf(Tissue::kCorticalBone, Tissue::kMarrow);
inline constexpr Layers kAirFilled = filledWith(Tissue::kAir);

/// A chain of cones through the points; radii are interpolated between the ends.
std::vector<ShapeSpec> chain(const std::vector<glm::dvec3>& points, double first_radius, double last_radius);
/// Points of the smooth curve (Catmull-Rom) through `points`, ends included; `steps_a_piece` equal steps between two
/// points.
std::vector<glm::dvec3> curve(const std::vector<glm::dvec3>& points, int steps_a_piece);
/// Sets the blend and shell of all shapes.
std::vector<ShapeSpec> with(std::vector<ShapeSpec> shapes, double blend_mm, double shell_mm);

}  // namespace kiln::phantom
