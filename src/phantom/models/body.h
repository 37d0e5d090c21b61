// A standing man of 1.83 m as a table of parts, in a box of 587 × 341 × 1878 mm, soles down, face towards -y, arms
// beside the body: the proportions of the Visible Human's volume. Each list is one region; `bodyParts` puts them in
// order of precedence, so that a cavity lies in its bone, a bone in its flesh, and air in everything.
// Left is +x; what has two sides is written for the left.
#pragma once

#include "phantom/models/figure.h"

namespace kiln::phantom {

/// The extents of the box, from (-x/2, -y/2, 0). unit: mm.
inline constexpr double kBodyBoxMm[3] = {587, 341, 1878};

PartList bodyParts();

// body_skin.cpp
PartSpec bodySurface();
// body_hands_feet.cpp: the flesh joins the surface, the bones the skeleton.
std::vector<ShapeSpec> handAndFootFlesh();
PartList handAndFootBones();
// body_spine.cpp: vertebrae, ribs and sternum, and what runs in the spinal canal.
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

// Tissues that many parts share.
inline constexpr Layers kBone = shellOf(Tissue::kCorticalBone, Tissue::kMarrow);
inline constexpr Layers kAirFilled = filledWith(Tissue::kAir);

/// A chain of cones through the points, radii between those of its ends.
std::vector<ShapeSpec> chain(const std::vector<glm::dvec3>& points, double first_radius, double last_radius);
/// `count` + 1 points of the smooth curve (Catmull-Rom) through `points`, ends included, a piece having equal shares.
std::vector<glm::dvec3> curve(const std::vector<glm::dvec3>& points, int steps_a_piece);
/// All shapes with this blend and shell.
std::vector<ShapeSpec> with(std::vector<ShapeSpec> shapes, double blend_mm, double shell_mm);

}  // namespace kiln::phantom
