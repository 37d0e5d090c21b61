// The formats behind `openSource`, one opener a file. Each throws Error as `openSource` says.
#pragma once

#include "ingest/source/slice_files.h"
#include "ingest/source/volume_source.h"

namespace kiln {

std::unique_ptr<VolumeSource> openRaw(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openNrrd(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openMetaImage(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openNifti(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openVdb(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openTiff(const SliceFiles& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openDicom(const SliceFiles& input, const SourceOptions& options);

/// Whether `input` asks for a computed volume, "phantom:NAME:XxYxZ", and not for a file.
bool namesPhantom(const std::filesystem::path& input);
std::unique_ptr<VolumeSource> openPhantom(const std::filesystem::path& input, const SourceOptions& options);

}  // namespace kiln
