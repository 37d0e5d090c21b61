#include "support/reference/companions.h"

#include <utility>

#include "companion/accompanied_volume.h"
#include "companion/color_values.h"
#include "companion/label_mask.h"
#include "store/store_reader.h"

namespace kiln::test {
namespace {

std::unique_ptr<BrickedVolume> openedBeside(const std::filesystem::path& store, const BrickedVolume& volume) {
  auto out = std::make_unique<StoreReader>(store);
  out->placeIn(volume.manifest().geometry());
  return out;
}

template <class... Companions>
std::unique_ptr<BrickedVolume> accompanied(std::unique_ptr<BrickedVolume> volume,
                                           std::unique_ptr<Companions>... companion) {
  std::vector<std::unique_ptr<Companion>> companions;
  (companions.push_back(std::move(companion)), ...);
  return std::make_unique<AccompaniedVolume>(std::move(volume), std::move(companions));
}

}  // namespace

std::unique_ptr<BrickedVolume> masked(const std::filesystem::path& store, const std::filesystem::path& mask,
                                      std::vector<std::int64_t> labels) {
  auto volume = std::make_unique<StoreReader>(store);
  auto companion = std::make_unique<LabelMask>(openedBeside(mask, *volume), std::move(labels), volume->manifest());
  return accompanied(std::move(volume), std::move(companion));
}

std::unique_ptr<BrickedVolume> maskedWithValues(const std::filesystem::path& store, const std::filesystem::path& mask,
                                                std::vector<std::int64_t> labels, const std::filesystem::path& values) {
  auto volume = std::make_unique<StoreReader>(store);
  auto shown = std::make_unique<LabelMask>(openedBeside(mask, *volume), std::move(labels), volume->manifest());
  auto colors = std::make_unique<ColorValues>(openedBeside(values, *volume), volume->manifest());
  return accompanied(std::move(volume), std::move(shown), std::move(colors));
}

std::unique_ptr<BrickedVolume> withValues(const std::filesystem::path& store, const std::filesystem::path& values) {
  auto volume = std::make_unique<StoreReader>(store);
  auto companion = std::make_unique<ColorValues>(openedBeside(values, *volume), volume->manifest());
  return accompanied(std::move(volume), std::move(companion));
}

}  // namespace kiln::test
