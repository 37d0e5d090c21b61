// Expects pictures that are equal to the bit, however they are drawn.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "frame/render_frame.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

/// A volume for such tests, of another type and spacing for each index. requires: 0 <= index < 3.
DenseVolume drawnAlikeVolume(int index);

/// Returns stores of the volume with bricks of 8, 16 and 64 voxels.
std::vector<std::filesystem::path> storesOfThreeBricks(const DenseVolume& volume);

/// Expects equal pictures of the finest level for bricks of all stores, visibility methods, a single thread with tiles
/// of a size by `seed` and little memory, and a crop. Returns the picture without visibility tests.
Image expectDrawnAlike(const std::vector<std::filesystem::path>& stores, FrameRequest request, std::uint64_t seed);

/// Expects equal pictures that show something for all instruction sets, two kinds of interpolation, two levels and
/// levels by distance.
void expectAlikeOnInstructionSets(const std::filesystem::path& store, FrameRequest request);

}  // namespace kiln::test
