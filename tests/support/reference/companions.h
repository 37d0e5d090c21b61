// Volumes with companions, for tests of masks and of colours by another volume.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "store/bricked_volume.h"

namespace kiln::test {

/// Opens a store that is shown where the store `mask` has one of the labels.
std::unique_ptr<BrickedVolume> masked(const std::filesystem::path& store, const std::filesystem::path& mask,
                                      std::vector<std::int64_t> labels);
/// Opens a store that is shown where the store `mask` has one of the labels, and carries the values of `values`.
std::unique_ptr<BrickedVolume> maskedWithValues(const std::filesystem::path& store, const std::filesystem::path& mask,
                                                std::vector<std::int64_t> labels, const std::filesystem::path& values);
/// Opens a store whose bricks carry the values of the store `values`.
std::unique_ptr<BrickedVolume> withValues(const std::filesystem::path& store, const std::filesystem::path& values);

}  // namespace kiln::test
