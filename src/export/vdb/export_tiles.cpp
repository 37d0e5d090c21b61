#include "export/vdb/export_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>
#include <span>
#include <sstream>
#include <vector>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_status.h"
#include "base/hash.h"
#include "export/output/pending_folder.h"
#include "export/source/numbered_name.h"
#include "export/source/output_place.h"
#include "export/vdb/grid_archive.h"
#include "export/vdb/grid_placement.h"
#include "export/vdb/vdb_tiles.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// The parts of a function that a baked grid depends on.
std::string functionText(const TransferFunction& function) {
  std::string out = fmt::format("{}", function.unit);
  for (const TransferPoint& point : function.points)
    out += fmt::format(" {}:{},{},{},{}", point.value, point.color.r, point.color.g, point.color.b, point.opacity);
  for (const LabelStyle& label : function.labels)
    out += fmt::format(" {}={},{},{},{}", label.label, label.color.r, label.color.g, label.color.b, label.opacity);
  return out;
}

std::string gridText(const GridPlacement& place) {
  return fmt::format("grid {} from {},{},{} at {}", toHex(hashOf(place.name)), place.origin.x, place.origin.y,
                     place.origin.z, fmt::join(std::span(glm::value_ptr(place.world_from_grid), 16), " "));
}

// An unfinished export must have the tiles of the finished export.
std::string contentsText(const StoreReader& store, const ExportedVolume& whole, const VdbRequest& request, int tiles) {
  const VdbValues& values = request.values;
  return fmt::format("kiln export 3, {} tiles of {}, {}, {}, type {}, background {}, tolerance {}, function {}\n",
                     tiles, request.archive.name(), identityOf(store, whole),
                     gridText(placementOf(store, whole.level, request.out)), static_cast<int>(values.type),
                     values.background ? fmt::format("{}", *values.background) : "of the store", values.tolerance,
                     request.baked ? toHex(hashOf(functionText(*request.baked))) : "none");
}

class TileFolder {
 public:
  TileFolder(const fs::path& out, const std::string& contents, Leftover leftover, FileSystem& disk)
      : disk_(disk), folder_(out, contents, leftover, disk) {}

  void requirePlaces(const std::vector<fs::path>& tiles) const { folder_.requirePlaces(tiles); }
  fs::path pathOf(const fs::path& tile) const { return folder_.path() / tile.filename(); }

  /// Returns the report of a tile of an earlier export; nothing if the tile is not whole.
  std::optional<VdbReport> kept(const fs::path& tile) const {
    if (!folder_.continued() || !isThere(pathOf(tile)) || !isThere(noteOf(tile))) return std::nullopt;
    VdbReport out;
    std::istringstream note(readTextFile(noteOf(tile)));
    if (!(note >> out.voxels >> out.bytes >> out.largest_error)) return std::nullopt;
    if (File(pathOf(tile)).size() != out.bytes) return std::nullopt;
    return out;
  }
  /// Keeps a whole tile for a later export, if this one fails.
  void keep(const fs::path& tile, const VdbReport& report) {
    disk_.writeOwn(noteOf(tile), fmt::format("{} {} {:.17g}\n", report.voxels, report.bytes, report.largest_error));
    folder_.keep();
  }
  /// Gives all tiles their names.
  void publish(const std::vector<fs::path>& tiles) { folder_.moveOut(tiles); }
  const fs::path& path() const { return folder_.path(); }

 private:
  fs::path noteOf(const fs::path& tile) const { return pathOf(tile).string() + ".txt"; }

  FileSystem& disk_;
  PendingFolder folder_;
};

// Tiles of an earlier export into more tiles would lie in the volume a second time.
void refuseOtherTiles(const fs::path& out, int tiles) {
  const NumberedName names(out);
  forEachEntry(names.folder().empty() ? "." : names.folder(), [&](const fs::directory_entry& entry) {
    if (names.isOther(entry.path().filename().string(), 1, tiles + 1))
      throw Error(ErrorCode::kExists, entry.path(), "",
                  fmt::format("would be taken for one of these {} tiles; move it, or name another output", tiles));
    return Walk::kGoOn;
  });
}

}  // namespace

VdbReport exportTiles(const StoreReader& store, const ExportedVolume& whole, const VdbRequest& request,
                      const TileChoices& choices, Progress& progress, FileSystem& disk) {
  std::vector<fs::path> names;
  for (int tile = 1; tile <= choices.tiles; ++tile) names.push_back(pathOfTile(request.out, tile));
  const auto require_names = [&] {
    for (const fs::path& name : names) requirePlace(store, name, request.overwrite, disk);
    refuseOtherTiles(request.out, choices.tiles);
  };
  require_names();
  const std::vector<ExportedVolume> tiles = tilesOf(whole, choices.tiles, request.out);
  TileFolder folder(request.out, contentsText(store, whole, request, choices.tiles),
                    leftoverFor(choices.resume, request.overwrite), disk);
  require_names();  // again: the folder may have given names to files of a killed export
  folder.requirePlaces(names);
  VdbReport sum;
  std::size_t done = 0;
  try {
    for (; done < tiles.size(); ++done) {
      std::optional<VdbReport> report = folder.kept(names[done]);
      if (!report) {
        VdbRequest tile = request;
        tile.out = folder.pathOf(names[done]);
        tile.overwrite = true;  // the folder is the export's own
        report = exportVdb(store, tiles[done], tile, progress, disk);
        folder.keep(names[done], *report);
      }
      sum.voxels += report->voxels;
      sum.bytes += report->bytes;
      sum.largest_error = std::max(sum.largest_error, report->largest_error);
    }
    folder.publish(names);
  } catch (...) {
    if (done > 0)
      progress.note(fmt::format("{}: {} of {} tiles are kept in {}; continue with --resume", request.out.string(), done,
                                tiles.size(), folder.path().string()));
    throw;
  }
  return sum;
}

}  // namespace kiln
