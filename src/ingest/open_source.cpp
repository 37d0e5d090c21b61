// Identifies the format of a file by its first bytes, then by its name. Known formats that are not supported are
// refused by name, so that the user can convert the file. Phantoms (phantom:…) are not files and are tested first.
#include "ingest/open_source.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>

#include "base/error.h"
#include "base/file/file.h"
#include "base/text.h"
#include "ingest/bytes/inflate_stream.h"
#include "ingest/dicom/dicom_directory.h"
#include "ingest/hdf5/bdv_xml.h"
#include "ingest/nifti/nifti_pair.h"
#include "ingest/slice_directory.h"
#include "ingest/slice_names.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "ingest/source/placement.h"
#include "ingest/source/wrapped_source.h"
#include "ingest/volume_format.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

using namespace std::string_view_literals;

enum class Format {
  kUnknown,
  kNrrd,
  kMetaImage,
  kNifti,
  kNpy,
  kMrc,
  kMgh,
  kAmira,
  kVgi,
  kVti,
  kLegacyVtk,
  kVdb,
  kTiff,
  kDicom,
  kHdf5,
  kBdv,
  kForeign
};

struct Finding {
  Format format = Format::kUnknown;
  std::string name;
};

struct Magic {
  std::size_t offset;
  std::string_view bytes;
  Format format;
  const char* name;
};

constexpr Magic kMagics[] = {
    {0, "NRRD0"sv, Format::kNrrd, "NRRD"},
    {0, " BDV\0\0\0\0"sv, Format::kVdb, "OpenVDB"},
    {344, "n+1\0"sv, Format::kNifti, "NIfTI"},
    {344, "ni1\0"sv, Format::kNifti, "NIfTI"},
    {4, "n+2\0\r\n\x1a\n"sv, Format::kNifti, "NIfTI"},
    {4, "ni2\0\r\n\x1a\n"sv, Format::kNifti, "NIfTI"},
    {0, "\x93NUMPY"sv, Format::kNpy, "NumPy"},
    {0, "\x89PNG\r\n\x1a\n"sv, Format::kForeign, "PNG"},
    {0, "\xff\xd8\xff"sv, Format::kForeign, "JPEG"},
    {0, "\0\0\0\x0cjP  \r\n\x87\n"sv, Format::kForeign, "JPEG 2000"},
    {0, "\xff\x4f\xff\x51"sv, Format::kForeign, "JPEG 2000"},
    {0, "\x89HDF\r\n\x1a\n"sv, Format::kHdf5, "HDF5"},
    {0, "NanoVDB0"sv, Format::kForeign, "NanoVDB"},
    {0, "# vtk DataFile"sv, Format::kLegacyVtk, "VTK"},
    {0, "<VTKFile"sv, Format::kVti, "VTK"},
    {0, "<?xml"sv, Format::kForeign, "XML"},
    {0, "PK\x03\x04"sv, Format::kForeign, "ZIP"},
    {0, "BZh"sv, Format::kForeign, "bzip2"},
    {0, "\xfd\x37zXZ\0"sv, Format::kForeign, "xz"},
    {0, "\x28\xb5\x2f\xfd"sv, Format::kForeign, "Zstandard"},
    {0, "7z\xbc\xaf\x27\x1c"sv, Format::kForeign, "7-Zip"},
    {0, "\x76\x2f\x31\x01"sv, Format::kForeign, "OpenEXR"},
    {0, "CDF\x01"sv, Format::kForeign, "NetCDF"},
    {0, "CDF\x02"sv, Format::kForeign, "NetCDF"},
    {0, "GIF8"sv, Format::kForeign, "GIF"},
    {0, "%PDF"sv, Format::kForeign, "PDF"},
    {208, "MAP "sv, Format::kMrc, "MRC"},
    {0, "# AmiraMesh"sv, Format::kAmira, "AmiraMesh"},
    {0, "# Avizo"sv, Format::kAmira, "AmiraMesh"},
};

constexpr std::string_view kSpokenWithAn[] = {"HDF5", "XML", "xz", "OpenEXR", "OpenVDB", "MRC", "MGH", "AmiraMesh"};

std::string firstBytes(const File& file) {
  std::string bytes(512, '\0');
  bytes.resize(file.readSomeAt(0, std::as_writable_bytes(std::span(bytes))));
  return bytes;
}

// Returns the first decompressed bytes; fewer if the stream is damaged, none if it is damaged from the start.
std::string firstDecompressedBytes(const fs::path& path) {
  std::string bytes(512, '\0');
  std::size_t got = 0;
  try {
    InflateStream stream(File(path), 0, StreamWrapper::kGzip);
    // Reads byte by byte, so that a cut stream still yields its first bytes.
    while (got < bytes.size() && stream.readSome(std::as_writable_bytes(std::span(bytes).subspan(got, 1)), "start"))
      ++got;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kFormat) throw;
  }
  bytes.resize(got);
  return bytes;
}

bool endsWith(const fs::path& path, std::initializer_list<const char*> endings) {
  const std::string name = lowered(path.filename().string());
  return std::any_of(endings.begin(), endings.end(), [&](const char* ending) { return name.ends_with(ending); });
}

Finding byBytes(const std::string& bytes) {
  if (sliceFormatOf(bytes) == SliceFormat::kTiff) return {Format::kTiff, "TIFF"};
  if (sliceFormatOf(bytes) == SliceFormat::kDicom) return {Format::kDicom, "DICOM"};
  // The XML declaration may stand before the first element.
  if (bytes.starts_with("<?xml") && bytes.find("<VTKFile") != std::string::npos) return {Format::kVti, "VTK"};
  if (bytes.find("<SpimData") != std::string::npos) return {Format::kBdv, "BigDataViewer"};
  for (const Magic& magic : kMagics) {
    if (bytes.size() > magic.offset && std::string_view(bytes).substr(magic.offset).starts_with(magic.bytes)) {
      return {magic.format, magic.name};
    }
  }
  for (const char* field : {"ObjectType", "NDims"}) {
    if (!bytes.starts_with(field)) continue;
    const std::string line = bytes.substr(0, std::min(bytes.find('\n'), bytes.size()));
    if (line.find('=') != std::string::npos) return {Format::kMetaImage, "MetaImage"};
  }
  return {};
}

Finding byName(const fs::path& path) {
  if (endsWith(path, {".nrrd", ".nhdr"})) return {Format::kNrrd, "NRRD"};
  if (endsWith(path, {".mhd", ".mha"})) return {Format::kMetaImage, "MetaImage"};
  if (endsWith(path, {".nii", ".nii.gz", ".hdr", ".hdr.gz"})) return {Format::kNifti, "NIfTI"};
  if (endsWith(path, {".mrc", ".mrcs", ".ccp4", ".mrc.gz", ".mrcs.gz", ".ccp4.gz"})) return {Format::kMrc, "MRC"};
  if (endsWith(path, {".mgh", ".mgz", ".mgh.gz"})) return {Format::kMgh, "MGH"};
  if (endsWith(path, {".am"})) return {Format::kAmira, "AmiraMesh"};
  if (endsWith(path, {".vgi"})) return {Format::kVgi, "VGI"};
  if (endsWith(path, {".vti"})) return {Format::kVti, "VTK"};
  if (endsWith(path, {".vtk"})) return {Format::kLegacyVtk, "VTK"};
  if (endsWith(path, {".npy"})) return {Format::kNpy, "NumPy"};
  if (endsWith(path, {".vdb"})) return {Format::kVdb, "OpenVDB"};
  return {};
}

// True if the bytes begin with the length of a NIfTI or ANALYZE header, in either byte order.
bool isNiftiHeader(const std::string& bytes) {
  constexpr std::string_view kLengths[] = {"\x5c\x01\0\0"sv, "\0\0\x01\x5c"sv, "\x1c\x02\0\0"sv, "\0\0\x02\x1c"sv};
  return std::any_of(std::begin(kLengths), std::end(kLengths),
                     [&](std::string_view length) { return bytes.starts_with(length); });
}

// The .img file of a NIfTI pair has no magic; the header beside it identifies the format.
bool isNiftiVoxels(const fs::path& path) {
  if (!isNamed(PairFile::kImage, path)) return false;
  const fs::path header = besideInPair(PairFile::kHeader, path);
  std::error_code ignored;
  if (!fs::is_regular_file(header, ignored)) return false;
  return endsInGz(header) || isNiftiHeader(firstBytes(File(header)));
}

// Refuses an .img whose header is missing. requires: nothing else identifies the file.
void requireHeaderOfImage(const fs::path& path) {
  if (!isNamed(PairFile::kImage, path)) return;
  const fs::path header = besideInPair(PairFile::kHeader, path);
  std::error_code ignored;
  if (!fs::exists(header, ignored))
    throw Error(ErrorCode::kNotFound, path, "",
                "the header of this image, " + inQuotes(header.filename().string()) +
                    ", is missing; put it beside this file, or give --dims and --type of headerless raw voxels");
}

bool isReadInGzip(Format format) {
  return format == Format::kNifti || format == Format::kMrc || format == Format::kMgh;
}

// HDF5 may begin behind a block of the user's own bytes, as in files of MATLAB: at 512 bytes, 1024, and so on.
bool isHdf5BehindBlock(const File& file) {
  constexpr std::string_view kMagic = "\x89HDF\r\n\x1a\n";
  for (std::uint64_t at = 512; at <= (1 << 20) && at + kMagic.size() <= file.size(); at *= 2) {
    std::string bytes(kMagic.size(), '\0');
    file.readAt(at, std::as_writable_bytes(std::span(bytes)));
    if (bytes == kMagic) return true;
  }
  return false;
}

Finding identify(const fs::path& path, bool described) {
  const File file(path);
  const std::string bytes = firstBytes(file);
  Finding found = byBytes(bytes);
  if (!described && found.format == Format::kUnknown && isNiftiVoxels(path)) return {Format::kNifti, "NIfTI"};
  if (found.format != Format::kUnknown) return found;
  if (bytes.starts_with("\x1f\x8b")) {
    const Finding inside = byBytes(firstDecompressedBytes(path));
    if (isReadInGzip(inside.format)) return inside;
    if (!inside.name.empty()) return {Format::kForeign, "gzip-compressed " + inside.name};
    found = byName(path);
    return isReadInGzip(found.format) ? found : Finding{Format::kForeign, "gzip-compressed"};
  }
  found = byName(path);
  if (!described && found.format == Format::kUnknown && isHdf5BehindBlock(file)) return {Format::kHdf5, "HDF5"};
  return found;
}

// Refuses pipes, which block, and devices, which have no length.
void requireRegularFile(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw Error(ErrorCode::kUnsupported, path, "",
                "is a pipe or a device, which cannot be read at any place; copy it to a file first");
  }
}

// Returns " or give 'engine.nhdr', …" if a header with the raw file's name lies beside the raw file.
std::string headerBeside(const fs::path& path) {
  for (const char* extension : {".nhdr", ".mhd", ".vgi"}) {
    const fs::path header = fs::path(path).replace_extension(extension);
    std::error_code ignored;
    if (header != path && fs::is_regular_file(header, ignored)) {
      return ", or give " + inQuotes(header.filename().string()) + ", the header beside it";
    }
  }
  return "";
}

// Returns "an OpenEXR", "a PNG": the article by the sound of the format's first letter.
std::string withArticle(const std::string& format) {
  const bool vowel = std::any_of(std::begin(kSpokenWithAn), std::end(kSpokenWithAn),
                                 [&](std::string_view name) { return format.starts_with(name); });
  return (vowel ? "an " : "a ") + format;
}

constexpr const char* kStore = "a store";
constexpr const char* kZarr = "Zarr";

// Refuses an option that chooses one of several `parts`, in a format that has none.
void refusePart(bool given, const fs::path& path, const char* option, const std::string& format, const char* parts) {
  if (!given) return;
  const std::string owner = format.starts_with("a ") ? format + " has" : format + " files have";
  throw Error(ErrorCode::kUsage, path, option, owner + " no " + parts + "; leave the option out");
}

void requireOptionsApply(const fs::path& path, const std::string& format, const SourceOptions& options) {
  const auto refuse = [&](bool given, const std::string& option, const std::string& where) {
    if (given) {
      throw Error(ErrorCode::kUsage, path, "",
                  option + " applies to " + where + " only, and this is " + format + "; leave it out");
    }
  };
  const bool raw = format == "raw", vdb = format == "OpenVDB", dicom = format == "DICOM";
  const bool stack = format == "TIFF" || format == "PNG" || format.starts_with("JPEG");
  const bool has_scales = format == kZarr || format == "HDF5";
  const bool has_times = stack || has_scales || format == "MRC" || format == "NIfTI" || format == "MGH";
  const bool has_channels = stack || dicom || has_scales || format == "VTK";
  refuse(options.dims && !raw, "--dims", "headerless raw data");
  refuse(options.type && !raw, "--type", "headerless raw data");
  refuse(options.big_endian && !raw, "--endian", "headerless raw data");
  refuse(options.skip_bytes > 0 && !raw, "--skip", "headerless raw data");
  refuse(options.grid_name && !vdb, "--grid", "OpenVDB files");
  refuse(options.series.has_value() && !dicom, "--series", "DICOM files");
  refuse(options.allow_irregular && !stack && !dicom, "--allow-irregular",
         "slices of TIFF, DICOM, PNG, JPEG and JPEG 2000");
  refuse(options.luminance && format != "TIFF", "--luminance", "TIFF files of RGB colours");
  refusePart(options.channel && !has_channels, path, "--channel", format, "channels");
  refusePart(options.time && !has_times, path, "--time", format, "times");
  refusePart(options.scale && !has_scales, path, "--scale", format, "scales");
  refuse(options.spacing && (vdb || format == kStore), "--spacing", "files without axes of their own");
  refuse(!options.placement.none() && format == kStore, "--flip, --orient, --up-axis or --unit", "volume files");
  if (!options.spacing) return;
  for (int axis = 0; axis < 3; ++axis) {
    const double edge = (*options.spacing)[axis];
    if (!(edge > 0) || !std::isfinite(edge)) throw Error(ErrorCode::kUsage, "--spacing takes three positive numbers");
  }
}

std::unique_ptr<VolumeSource> openDirectory(const fs::path& input, const SourceOptions& options) {
  if (isZarrFolder(input, options)) {
    requireOptionsApply(input, kZarr, options);
    return openZarr(input, options);
  }
  SliceFiles slices = slicesIn(input);
  requireOptionsApply(input, nameOf(slices.format), options);
  if (slices.format == SliceFormat::kDicom) return openDicom(slices, options);
  requireOneStack(slices, options);
  return slices.format == SliceFormat::kTiff ? openTiff(slices, options) : openPictures(slices, options);
}

}  // namespace

void requireNoOptions(const fs::path& store, const SourceOptions& options) {
  requireOptionsApply(store, kStore, options);
}

VolumeFormat volumeFormatOf(const fs::path& input) {
  const fs::path path = containerOf(input);
  constexpr std::string_view kVolumes[] = {"NetCDF", "gzip-compressed"};
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return {};
  const Finding found = identify(path, false);
  const bool foreign = std::any_of(std::begin(kVolumes), std::end(kVolumes),
                                   [&](std::string_view name) { return found.name.starts_with(name); });
  if (found.format == Format::kUnknown || (found.format == Format::kForeign && !foreign)) return {};
  return {withArticle(found.name), found.format != Format::kForeign};
}

fs::path containerOf(const fs::path& input) {
  const std::string text = input.string();
  const std::size_t colon = text.find(":/");
  std::error_code ignored;
  if (colon == std::string::npos || fs::exists(input, ignored)) return input;
  const fs::path file = text.substr(0, colon);
  return fs::is_regular_file(file, ignored) ? file : input;
}

std::string partOf(const fs::path& input) {
  const fs::path file = containerOf(input);
  return file == input ? "" : input.string().substr(file.string().size() + 1);
}

namespace {

// Opens a file of a format that is read; null for headerless voxels.
std::unique_ptr<VolumeSource> openFormat(Format format, const fs::path& input, const std::string& part,
                                         const SourceOptions& options) {
  switch (format) {
    case Format::kNrrd:
      return openNrrd(input, options);
    case Format::kMetaImage:
      return openMetaImage(input, options);
    case Format::kNifti:
      return openNifti(input, options);
    case Format::kNpy:
      return openNpy(input, options);
    case Format::kMrc:
      return openMrc(input, options);
    case Format::kMgh:
      return openMgh(input, options);
    case Format::kAmira:
      return openAmira(input, options);
    case Format::kVgi:
      return openVgi(input, options);
    case Format::kVti:
      return openVti(input, options);
    case Format::kLegacyVtk:
      return openLegacyVtk(input, options);
    case Format::kVdb:
      return openVdb(input, options);
    case Format::kHdf5:
      return openHdf5(input, part, options);
    case Format::kTiff:
      return openTiff({input, SliceFormat::kTiff, {input}, {}, {}}, options);
    case Format::kDicom:
      // The list of a CD stands for its folder.
      if (isDicomDirectory(input)) return openDirectory(input.has_parent_path() ? input.parent_path() : ".", options);
      return openDicom({input, SliceFormat::kDicom, {input}, {}, {}}, options);
    case Format::kBdv:
    case Format::kUnknown:
    case Format::kForeign:
      break;
  }
  return nullptr;
}

// throws: Error naming what is missing to read headerless voxels.
[[noreturn]] void refuseUndescribed(const fs::path& input, const SourceOptions& options) {
  if (options.dims || options.type)
    throw Error(ErrorCode::kUsage, input, options.dims ? "--type" : "--dims",
                options.dims
                    ? "headerless raw voxels need a type, and none is given; add --type, for example --type u16"
                    : "headerless raw voxels need a size, and none is given; add --dims X,Y,Z");
  if (File(input).size() == 0)
    throw Error(ErrorCode::kFormat, input, "", "is empty (found 0 bytes); copy or write the file again");
  requireHeaderOfImage(input);
  throw Error(
      ErrorCode::kUsage, input, "",
      "not a format that is known (NRRD, MetaImage, NIfTI, NumPy, MRC, MGH, AmiraMesh, VGI, VTK, TIFF, DICOM, "
      "OpenVDB, HDF5, Zarr); if it is headerless raw voxels, give --dims and --type, for example --dims 256,256,113 "
      "--type u16" +
          headerBeside(input));
}

// Opens a volume where its file places it.
std::unique_ptr<VolumeSource> openAsStored(const fs::path& given, const SourceOptions& options) {
  const fs::path input = containerOf(given);
  const std::string part = partOf(given);
  if (namesPhantom(input)) {
    requireOptionsApply(input, "a phantom", options);
    return openPhantom(input, options);
  }
  std::error_code ignored;
  if (fs::is_directory(input, ignored)) return openDirectory(input, options);
  requireRegularFile(input);
  // Some magics are short and raw voxels may hold any bytes: explicit dimensions and type override the magic.
  const bool described = options.dims && options.type;
  Finding found = identify(input, described);
  if (found.format == Format::kBdv && !described)
    return openAsStored(imageOfBdv(input).string() + (part.empty() ? "" : ":" + part), options);
  if (found.format == Format::kForeign && !described) {
    throw Error(
        ErrorCode::kUnsupported, input, "",
        withArticle(found.name) + " file, which is not read; convert it to NRRD, MetaImage, NIfTI, OpenVDB or raw");
  }
  const bool slices = found.format == Format::kTiff || found.format == Format::kDicom;
  if ((slices && described) || found.format == Format::kBdv || found.format == Format::kForeign ||
      found.format == Format::kUnknown)
    found = {Format::kUnknown, "raw"};
  requireOptionsApply(input, found.name, options);
  if (!part.empty() && found.format != Format::kHdf5)
    throw Error(ErrorCode::kUsage, given, "",
                inQuotes(part) + " names a part of an HDF5 file, and this is " + withArticle(found.name) + " file");
  if (std::unique_ptr<VolumeSource> out = openFormat(found.format, input, part, options)) return out;
  if (!described) refuseUndescribed(input, options);
  return openRaw(input, options);
}

// A volume that lies where the user places it.
class PlacedSource : public WrappedSource {
 public:
  PlacedSource(std::unique_ptr<VolumeSource> source, const fs::path& input, const Placement& placement)
      : WrappedSource(std::move(source)) {
    info_.geometry = placed(info_.geometry, placement, input.string());
    if (!info_.vdb) return;
    const VoxelCoord& at = info_.vdb->index_origin;
    info_.vdb->world_from_grid =
        glm::translate(info_.geometry.world_from_index,
                       -glm::dvec3(static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z)));
  }
};

}  // namespace

std::unique_ptr<VolumeSource> openSource(const fs::path& input, const SourceOptions& options) {
  std::unique_ptr<VolumeSource> source = openAsStored(input, options);
  if (options.placement.none()) return source;
  return std::make_unique<PlacedSource>(std::move(source), input, options.placement);
}

}  // namespace kiln
