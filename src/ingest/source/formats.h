// The formats behind `openSource`, one opener per file. Each opener throws the errors of `openSource`.
#pragma once

#include <string_view>

#include "ingest/source/listed_volume.h"
#include "ingest/source/slice_files.h"
#include "ingest/source/volume_source.h"

namespace kiln {

std::unique_ptr<VolumeSource> openRaw(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openNrrd(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openMetaImage(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openNifti(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openNpy(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openMrc(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openAmira(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openVgi(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openMgh(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openVti(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openLegacyVtk(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openVdb(const std::filesystem::path& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openTiff(const SliceFiles& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openPictures(const SliceFiles& input, const SourceOptions& options);
std::unique_ptr<VolumeSource> openDicom(const SliceFiles& input, const SourceOptions& options);
/// True if `folder` is a Zarr or N5 container, group or array, by its header or its name.
bool isZarrFolder(const std::filesystem::path& folder, const SourceOptions& options);
std::unique_ptr<VolumeSource> openZarr(const std::filesystem::path& input, const SourceOptions& options);
std::vector<ListedVolume> listHdf5(const std::filesystem::path& file, const SourceOptions& options);
/// `path` names a data set; empty for the only one.
std::unique_ptr<VolumeSource> openHdf5(const std::filesystem::path& file, const std::string& path,
                                       const SourceOptions& options);

/// Lists grids of a file, series of files, pages of a file, and slices of files that form one stack.
std::vector<ListedVolume> listVdb(const std::filesystem::path& input, const SourceOptions& options);
/// The scales of a folder of Zarr or N5.
std::vector<ListedVolume> listZarr(const std::filesystem::path& folder, const SourceOptions& options);
std::vector<ListedVolume> listDicom(const std::vector<std::filesystem::path>& files, const SourceOptions& options);
std::vector<ListedVolume> listTiff(const std::vector<std::filesystem::path>& stack);
ListedVolume listPictures(SliceFormat format, const std::vector<std::filesystem::path>& stack);

/// Beginning of the name of a computed volume.
inline constexpr std::string_view kPhantomScheme = "phantom:";
/// True if `input` names a computed volume, "phantom:NAME:XxYxZ", instead of a file.
bool namesPhantom(const std::filesystem::path& input);
std::unique_ptr<VolumeSource> openPhantom(const std::filesystem::path& input, const SourceOptions& options);

}  // namespace kiln
