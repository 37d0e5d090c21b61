// The writers of all formats.
#pragma once

#include <filesystem>
#include <memory>

#include "base/file/file.h"
#include "export/source/volume_writer.h"

namespace kiln {

/// The output of a writer, and the choices that formats leave to the user.
struct ExportTarget {
  const StoreReader& store;
  std::filesystem::path out;
  FileSystem& disk;
  /// True if files of the output may be replaced.
  bool overwrite = false;
  bool compress = false;
  /// True if an interrupted export is continued.
  bool resume = false;
  /// The region of the request, for further levels of the pyramid.
  std::optional<VoxelBox> region = {};
};

/// Each function opens the output of a volume and appends to `notes` what the format cannot hold.
/// throws: Error kUnsupported (a volume that the format cannot hold), kExists, kIo, kNoSpace.
using OpenWriter = std::unique_ptr<VolumeWriter>(const ExportTarget& target, const ExportedVolume& volume,
                                                 ExportNotes& notes);
OpenWriter openNrrdWriter, openNiftiWriter, openGzipNiftiWriter, openMetaImageWriter, openMetaImagePairWriter,
    openRawWriter, openTiffWriter, openOmeZarrWriter;

/// True if a finished OME-Zarr holds this volume of this store. throws: Error kIo.
bool isWrittenOmeZarr(const ExportTarget& target, const ExportedVolume& volume);

}  // namespace kiln
