// Exports a volume as files of grids side by side, which an interrupted export keeps for a later one.
// Method. Tiles are made in a folder of their own, each with a note of its report, and get their names when all are
// whole.
#pragma once

#include "export/vdb/export_vdb.h"

namespace kiln {

/// Number of tiles, and the choice to continue an interrupted export.
struct TileChoices {
  int tiles = 2;
  bool resume = false;
};

/// Writes `whole` as tiles with the name `request.out`, which has # in place of the number. The bound of memory counts
/// for each tile. The report is the sum of all tiles. throws: as tilesOf, PendingFolder and exportVdb; kExists if the
/// folder has a further file of the pattern; after an error whole tiles stay in the folder NAME.partial.
VdbReport exportTiles(const StoreReader& store, const ExportedVolume& whole, const VdbRequest& request,
                      const TileChoices& choices, Progress& progress, FileSystem& disk);

}  // namespace kiln
