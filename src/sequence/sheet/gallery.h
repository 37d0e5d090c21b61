// A sheet of thumbnails of a volume: each preset from several sides, with the options that draw it.
// Method. All thumbnails are drawn from one cache of bricks, at the levels that fit their size. A volume of any size
// costs the bricks of its coarse levels once.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/progress.h"
#include "image/image.h"
#include "job/look.h"
#include "job/render_job.h"

namespace kiln {

struct GalleryRequest {
  std::filesystem::path store;
  std::vector<std::string> presets;  // empty: all presets that fit the volume
  int thumbnail_px = 192;            // edge of a thumbnail
  Look look = Look::kPlain;
  SpeedOptions speed;
};

/// A row of the sheet: a preset, and how many of its views show something.
struct GalleryRow {
  std::string preset;
  int shown = 0;
};

struct Gallery {
  Image sheet;
  std::vector<GalleryRow> rows;  // presets that show nothing, or do not fit, have no row
  std::uint64_t bricks_read = 0, read_bytes = 0;
};

/// The look as an option of render: " --look studio"; "" for the default.
std::string optionOf(Look look);

/// The views of a row, as options of render: "", "--view front", ….
const std::vector<std::string>& galleryViews();

/// Draws the sheet; pictures have the light that a PNG shows. throws: as renderFrame; Error kUsage if a named preset
/// does not fit the volume, or no preset shows anything; kBudget if the sheet does not fit in the memory.
Gallery drawGallery(const GalleryRequest& request, Progress& progress);

}  // namespace kiln
