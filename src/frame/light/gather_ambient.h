// Gathers the visibility of the surroundings of each point of a grid from a lattice of opacities.
// Method. From each point near visible matter, cones march through coarser and coarser means of the lattice. Matter at
// distance s counts with the weight 1 - (s / radius)².
// Source: Crassin et al. 2011 (cone tracing); Hernell, Ljung and Ynnerman 2010 (local ambient occlusion).
// Differs: means over the three axes instead of one set of means for each direction.
// Cost. 24 cones, with a look-up for each step, for each point of the grid near matter; none for other points.
// Figures: frame/decisions/occlusion.md.
#pragma once

#include <cstdint>

#include "base/progress.h"
#include "engine/shared/ambient_occlusion.h"
#include "engine/shared/extinction_lattice.h"

namespace kiln {

/// `radius`: distance beyond which matter does not occlude. unit: world. thread: uses all. throws: Error kCancelled.
AmbientGrid gatherAmbient(const ExtinctionLattice& lattice, double radius, const Progress& progress);

/// Returns the memory of a lattice, of gathering from it, and of the grid. unit: bytes.
std::uint64_t ambientBytes(const LatticeView& lattice);

}  // namespace kiln
