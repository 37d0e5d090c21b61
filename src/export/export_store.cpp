#include "export/export_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/error.h"
#include "base/file/chosen_disk.h"
#include "base/file/folder.h"
#include "base/file/path_name.h"
#include "base/memory/large_pages.h"
#include "base/text.h"
#include "base/thread/parallel.h"
#include "export/source/box_plan.h"
#include "export/source/export_formats.h"
#include "export/source/output_place.h"
#include "export/source/store_boxes.h"
#include "export/vdb/export_tiles.h"
#include "export/vdb/export_vdb.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Writes the boxes of a writer's volumes, one after another.
class BoxExport {
 public:
  BoxExport(const StoreReader& store, const ExportRequest& request, VolumeWriter& writer, Progress& progress)
      : store_(store), request_(request), writer_(writer), progress_(progress) {
    for (const ExportedVolume& volume : writer.volumes()) total_ += static_cast<std::uint64_t>(volume.box.count());
  }

  void run() {
    for (const ExportedVolume& volume : writer_.volumes()) write(volume);
  }

 private:
  void write(const ExportedVolume& volume) {
    const BoxPlan plan = planBoxes(store_, volume, writer_, request_.memory_bytes, request_.out);
    const ThreadLimit limit(plan.threads);
    const BoxList boxes(volume.box, plan);
    UnsetBytes voxels;
    for (std::int64_t i = 0; i < boxes.count(); ++i) {
      progress_.throwIfCancelled("exporting");
      const VoxelBox box = boxes.at(i);
      if (!writer_.holds(volume, box)) {
        voxels.resize(static_cast<std::size_t>(box.count()) * sizeOf(volume.type));
        readBox(store_, volume.level, box, progress_, voxels);
        writer_.write(volume, box, voxels);
      }
      done_ += static_cast<std::uint64_t>(box.count());
      progress_.advance("exporting", "voxels", done_, total_);
    }
  }

  const StoreReader& store_;
  const ExportRequest& request_;
  VolumeWriter& writer_;
  Progress& progress_;
  std::uint64_t done_ = 0, total_ = 0;
};

struct ExportParts {
  const StoreReader& store;
  const ExportRequest& request;
  Progress& progress;
  FileSystem& disk;
};

ExportTarget targetOf(const ExportParts& parts) {
  const ExportRequest& request = parts.request;
  return {.store = parts.store,
          .out = request.out,
          .disk = parts.disk,
          .overwrite = request.overwrite,
          .compress = request.compress,
          .resume = request.resume,
          .region = request.region};
}

WrittenFiles written(const ExportParts& parts, VolumeWriter& writer) {
  try {
    BoxExport(parts.store, parts.request, writer, parts.progress).run();
    return writer.finish();
  } catch (...) {
    if (const std::string kept = writer.keepParts(); !kept.empty())
      parts.progress.note(parts.request.out.string() + ": " + kept);
    throw;
  }
}

template <OpenWriter kOpen>
ExportReport exportBoxes(const ExportParts& parts) {
  const ExportRequest& request = parts.request;
  const ExportedVolume volume = exportedVolume(parts.store, request.level, request.region);
  ExportNotes notes;
  const std::unique_ptr<VolumeWriter> writer = kOpen(targetOf(parts), volume, notes);
  WrittenFiles files = written(parts, *writer);
  for (const std::string& note : notes) parts.progress.note(request.out.string() + ": " + note);
  return {extentText(volume), files.bytes, std::move(files.lines)};
}

std::uint64_t bytesBelow(const fs::path& folder) {
  std::uint64_t out = 0;
  forEachEntryBelow(folder, [&](const fs::directory_entry& entry) {
    if (entry.is_regular_file()) out += entry.file_size();
    return Walk::kGoOn;
  });
  return out;
}

ExportReport exportOmeZarr(const ExportParts& parts) {
  const ExportRequest& request = parts.request;
  const ExportedVolume volume = exportedVolume(parts.store, request.level, request.region);
  if (request.resume && isWrittenOmeZarr(targetOf(parts), volume))
    return {extentText(volume), bytesBelow(request.out), {"an earlier export finished the image, which is kept"}};
  return exportBoxes<openOmeZarrWriter>(parts);
}

ExportReport exportGrids(const GridArchive& archive, const ExportParts& parts) {
  const ExportRequest& request = parts.request;
  const ExportedVolume whole = exportedVolume(parts.store, request.level, request.region);
  const VdbRequest grids{archive, request.out, request.overwrite, request.memory_bytes, request.values, request.baked};
  const VdbReport sum = request.tiles > 1 ? exportTiles(parts.store, whole, grids, {request.tiles, request.resume},
                                                        parts.progress, parts.disk)
                                          : exportVdb(parts.store, whole, grids, parts.progress, parts.disk);
  if (!whole.geometry.unit.empty() || whole.geometry.frame != PatientFrame::kUnknown)
    parts.progress.note(request.out.string() + ": grids have no unit of length and no patient frame");
  if (sum.voxels == 0)
    parts.progress.note(
        request.out.string() +
        (request.baked
             ? ": --tf makes no voxel visible, so the grids are empty and hold no size; choose another function"
             : ": no voxel differs from the background by more than --tolerance, so the grid is empty and "
               "holds no size; --background with another value keeps the voxels"));
  else if (!request.baked && sum.voxels < static_cast<std::uint64_t>(whole.box.count()))
    parts.progress.note(
        fmt::format("{}: grids have no box; programs read the box of the active voxels, without the "
                    "background around them",
                    request.out.string()));
  ExportReport out = {fmt::format("{} active voxels", sum.voxels), sum.bytes, {}};
  if (!request.baked && (request.values.type != VdbType::kExact || request.values.tolerance > 0))
    out.lines.push_back(fmt::format("the largest error of a voxel is {:.6g}", sum.largest_error));
  return out;
}

ExportReport exportOpenVdb(const ExportParts& parts) { return exportGrids(openVdbArchive(), parts); }

ExportReport exportNanoVdb(const ExportParts& parts) {
  return exportGrids(nanoVdbArchive(parts.request.compress), parts);
}

/// The options and contents of a format beside those of all formats.
struct FormatOptions {
  bool compresses = false, resumes = false, holds_grids = false, holds_half = false;
  /// True if the format has words for a DeclaredLook.
  bool holds_look = false;
};

struct ExportFormat {
  const char* ending;
  ExportReport (*write)(const ExportParts& parts);
  FormatOptions takes = {};
};

// An ending that ends in another stands before it.
constexpr ExportFormat kExportFormats[] = {
    {".nrrd", exportBoxes<openNrrdWriter>, {.compresses = true}},
    {".nii.gz", exportBoxes<openGzipNiftiWriter>},
    {".nii", exportBoxes<openNiftiWriter>},
    {".mha", exportBoxes<openMetaImageWriter>},
    {".mhd", exportBoxes<openMetaImagePairWriter>},
    {".raw", exportBoxes<openRawWriter>},
    {".tif", exportBoxes<openTiffWriter>},
    {".tiff", exportBoxes<openTiffWriter>},
    {".zarr", exportOmeZarr, {.resumes = true, .holds_look = true}},
    {".nvdb", exportNanoVdb, {.compresses = true, .holds_grids = true}},
    {".vdb", exportOpenVdb, {.holds_grids = true, .holds_half = true}},
};

const ExportFormat& exportFormatOf(const ExportRequest& request) {
  const std::string name = lowered(withoutTrailingSlash(request.out).filename().string());
  const auto found = std::find_if(std::begin(kExportFormats), std::end(kExportFormats),
                                  [&](const ExportFormat& format) { return name.ends_with(format.ending); });
  if (found == std::end(kExportFormats))
    throw Error(ErrorCode::kUsage, request.out, "",
                fmt::format("has the ending of no format that is written; write {}", exportEndings()));
  const auto refuse = [&](const char* option, const char* ending) {
    throw Error(ErrorCode::kUsage, request.out, option,
                fmt::format("is for {} only (found {}); leave it out", ending, found->ending));
  };
  if (request.compress && !found->takes.compresses) refuse("--compress", ".nrrd and .nvdb");
  if (request.resume && !found->takes.resumes && !(found->takes.holds_grids && request.tiles > 1))
    refuse("--resume", ".zarr and --tiles");
  if (request.values.type == VdbType::kHalf && found->takes.holds_grids && !found->takes.holds_half)
    throw Error(ErrorCode::kUsage, request.out, "--type",
                fmt::format("half is for .vdb only (found {}); write --type float", found->ending));
  if (found->takes.holds_grids) return *found;
  if (request.tiles != 1) refuse("--tiles", ".vdb and .nvdb");
  if (request.values.type != VdbType::kExact) refuse("--type", ".vdb and .nvdb");
  if (request.values.tolerance != 0) refuse("--tolerance", ".vdb and .nvdb");
  if (request.values.background) refuse("--background", ".vdb and .nvdb");
  if (request.baked) refuse("--tf", ".vdb and .nvdb");
  return *found;
}

// A region without a voxel is refused later.
void noteCutRegion(const StoreReader& store, const ExportRequest& request, Progress& progress) {
  const VoxelBox inside = intersection(*request.region, boxOf(store.manifest().geometry().dims));
  if (inside.empty() || inside == *request.region) return;
  progress.note(
      fmt::format("{}: --region reaches beyond the volume; the box that is written is {},{},{},{},{},{} of level 0",
                  request.out.string(), inside.lo.x, inside.lo.y, inside.lo.z, inside.hi.x, inside.hi.y, inside.hi.z));
}

}  // namespace

std::string exportEndings() {
  std::string out;
  for (const ExportFormat& format : kExportFormats) out += (out.empty() ? "" : ", ") + std::string(format.ending);
  return out;
}

void requireExportFormat(const ExportRequest& request) { exportFormatOf(request); }

ExportReport exportStore(const StoreReader& store, const ExportRequest& request, Progress& progress) {
  if (request.region) noteCutRegion(store, request, progress);
  const ExportFormat& format = exportFormatOf(request);
  ExportReport out = format.write({store, request, progress, chosenDisk(request.disk)});
  if (!store.manifest().look.empty() && !format.takes.holds_look && !request.baked)
    progress.note(request.out.string() + ": the format has no place for the window or the colours of the source");
  return out;
}

}  // namespace kiln
