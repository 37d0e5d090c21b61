// The kernels of the pixel lattice as anyone would write them: one voxel, one pixel after the other. What every
// instruction set is held against, and measured beside.
#pragma once

#include <cstdint>
#include <functional>

#include "splat/lay_sheet.h"
#include "splat/sheet.h"
#include "splat/unit_load.h"

namespace kiln::test {

/// Calls f() with each instruction set that this machine has and that there are kernels for, the best one last.
void onEveryInstructionSet(const std::function<void(std::int64_t target)>& f);

/// loadUnit.
UnitRanges loadUnitScalar(const BrickBlock& block, const UnitLattice& lattice, double offset, const VoxelCoord& lo,
                          float* values);

/// addSamples.
void addSamplesScalar(std::span<const SlabSample* const> samples, const FootprintTable& footprint, Sheet& here,
                      Sheet& next);

/// A pixel of laySheet; whether it changes.
bool layPixelScalar(float* pixel, const std::int32_t* sum, std::int32_t filled, float erosion, float color_unit,
                    CoveredPixel& covered);
/// All of a block, as laySheet does without `pixels`.
LaidBlock laySheetScalar(const SheetBlock& block);

}  // namespace kiln::test
