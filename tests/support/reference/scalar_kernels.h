// Kernels as plain loops, voxel by voxel: the truth for every instruction set, and the baseline of benchmarks.
#pragma once

#include <cstdint>
#include <functional>

#include "engine/pixel/voxels/load_patch.h"

namespace kiln::test {

/// Calls f() with each instruction set that has kernels and is supported by the machine, the best set last.
void onEveryInstructionSet(const std::function<void(std::int64_t target)>& f);

/// loadPatch.
SampledRange loadPatchScalar(const BrickBlock& block, const SampleLattice& lattice, double offset, const VoxelCoord& lo,
                             float* values);

}  // namespace kiln::test
