// Kernels as anyone would write them: one voxel after the other. Every instruction set is held against them, and
// measured beside them.
#pragma once

#include <cstdint>
#include <functional>

#include "engine/pixel/unit_load.h"

namespace kiln::test {

/// Calls f() with each instruction set that this machine has and that there are kernels for, the best one last.
void onEveryInstructionSet(const std::function<void(std::int64_t target)>& f);

/// loadUnit.
SampledRange loadUnitScalar(const BrickBlock& block, const SampleLattice& lattice, double offset, const VoxelCoord& lo,
                            float* values);

}  // namespace kiln::test
