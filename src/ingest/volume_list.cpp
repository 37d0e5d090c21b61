#include "ingest/volume_list.h"

#include <algorithm>
#include <iterator>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/folder.h"
#include "ingest/hdf5/bdv_xml.h"
#include "ingest/open_source.h"
#include "ingest/slice_directory.h"
#include "ingest/slice_names.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "ingest/volume_format.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

using Volumes = std::vector<ListedVolume>;

void append(Volumes& out, Volumes more) {
  out.insert(out.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

// The name of a format without the number of the only part that is described.
std::string withoutPart(std::string format, const std::string& part) {
  if (const std::size_t at = format.find(part); at != std::string::npos) format.erase(at, part.size());
  return format;
}

// Of several channels or times, the first is described, with the option that chooses one.
ListedVolume oneOf(const fs::path& input, const SourceOptions& options) try {
  const SourceInfo info = openSource(input, options)->info();
  ListedVolume out;
  out.name = input.filename().string();
  out.kind = info.format;
  out.dims = info.geometry.dims;
  out.type = info.type;
  return out;
} catch (const UnchosenPart& several) {
  SourceOptions first = options;
  if (several.part() == "time")
    first.time = 0;
  else
    first.channel = "0";
  ListedVolume out = oneOf(input, first);
  out.kind = withoutPart(out.kind, partOf(several.part().c_str(), 0, 2)) + ", " + several.parts();
  out.option = "--" + several.part() + " N" + (out.option.empty() ? "" : " " + out.option);
  return out;
}

Volumes listOfOne(const fs::path& input, const SourceOptions& options) { return {oneOf(input, options)}; }

Volumes ofFile(const fs::path& file, const SourceOptions& options) {
  const std::string format = options.dims ? "" : volumeFormatOf(file).name;
  if (format == "an OpenVDB") return listVdb(file, options);
  if (format == "a TIFF") return listTiff({file});
  if (format == "a DICOM") return listDicom({file}, options);
  if (format == "an HDF5") return listHdf5(file, options);
  if (format == "a BigDataViewer") return listHdf5(imageOfBdv(file), options);
  return listOfOne(file, options);
}

// Returns the volumes of files in a folder; files that cannot be listed are one volume with the reason.
template <class List>
Volumes listedOrRefused(const std::string& name, const std::string& kind, List&& list) {
  try {
    return list();
  } catch (const Error& error) {
    ListedVolume out;
    out.name = name;
    out.kind = kind;
    out.refusal = error.what();
    return {out};
  }
}

// Names the volumes of a file or folder in the listed folder by its path.
Volumes namedByPath(Volumes volumes, const fs::path& path) {
  for (ListedVolume& volume : volumes) {
    if (volume.name != path.filename()) volume.kind += " in " + inQuotes(path.filename().string());
    // A data set of HDF5 is named by its file already.
    if (volume.refusal.empty() && (volume.option.empty() || volume.option.starts_with("--")))
      volume.option = path.string() + (volume.option.empty() ? "" : " " + volume.option);
  }
  return volumes;
}

// The reason why a conversion refuses slices by their names; empty if the slices are one stack.
std::string reasonAgainst(SliceFiles slices, const SourceOptions& options) {
  try {
    requireOneStack(slices, options);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// The stacks of the slices in a folder. A single TIFF file among other slices is named by its path.
Volumes stacksIn(const SliceFiles& all, bool is_alone, const SourceOptions& options) {
  Volumes out;
  const std::vector<std::vector<fs::path>> stacks = stacksByName(all.files);
  const std::vector<std::string> numbers = numbersOfStacks(all.files, stacks);
  const std::string reason = numbers.empty() ? reasonAgainst(all, options) : "";
  const bool is_tiff = all.format == SliceFormat::kTiff;
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    Volumes volumes = listedOrRefused(nameOfStack(stacks[i]), nameOf(all.format), [&] {
      return is_tiff ? listTiff(stacks[i]) : Volumes{listPictures(all.format, stacks[i])};
    });
    if (is_tiff && stacks[i].size() == 1 && !(is_alone && stacks.size() == 1)) {
      append(out, namedByPath(std::move(volumes), stacks[i].front()));
      continue;
    }
    ListedVolume& volume = volumes.front();
    if (!numbers.empty()) volume.option = "--channel " + numbers[i];
    if (volume.refusal.empty())
      volume.refusal = numbers.empty() ? reason : reasonAgainst({all.input, all.format, stacks[i], {}, {}}, options);
    append(out, std::move(volumes));
  }
  return out;
}

Volumes zarrFoldersIn(const fs::path& folder, const SourceOptions& options) {
  std::vector<fs::path> folders;
  forEachEntry(folder, [&](const fs::directory_entry& entry) {
    std::error_code ignored;
    const std::string name = entry.path().filename().string();
    if (!name.starts_with('.') && entry.is_directory(ignored)) folders.push_back(entry.path());
    return Walk::kGoOn;
  });
  std::sort(folders.begin(), folders.end(), [](const fs::path& a, const fs::path& b) {
    return naturallyBefore(a.filename().string(), b.filename().string());
  });
  Volumes out;
  for (const fs::path& path : folders)
    append(out, listedOrRefused(path.filename().string(), "Zarr", [&] {
             return isZarrFolder(path, options) ? namedByPath(listZarr(path, options), path) : Volumes();
           }));
  return out;
}

Volumes ofFolder(const fs::path& folder, const SourceOptions& options) {
  const FolderFiles files = filesIn(folder);
  Volumes out;
  if (!files.dicom.empty()) append(out, listDicom(files.dicom, options));
  append(out, stacksIn({folder, SliceFormat::kTiff, files.tiff, {}, {}}, files.dicom.empty(), options));
  for (const auto& [format, pictures] : files.pictures)
    append(out, stacksIn({folder, format, pictures, {}, {}}, true, options));
  append(out, zarrFoldersIn(folder, options));
  for (const fs::path& file : files.other) {
    const VolumeFormat format = volumeFormatOf(file);
    // The image of a description is listed itself.
    if (!format.read || format.name == "a BigDataViewer") continue;
    append(out,
           listedOrRefused(file.filename().string(), "file", [&] { return namedByPath(ofFile(file, options), file); }));
  }
  if (out.empty()) slicesIn(folder);  // throws with the name of a subfolder that has slices
  if (out.empty()) throw Error(ErrorCode::kUnsupported, folder, "", "a directory without a volume; name another");
  return out;
}

}  // namespace

std::vector<ListedVolume> volumesIn(const fs::path& input, const SourceOptions& options) {
  std::error_code ignored;
  if (namesPhantom(input)) return listOfOne(input, options);
  if (containerOf(input) != input) return listOfOne(input, options);
  if (!fs::is_directory(input, ignored)) return ofFile(input, options);
  return isZarrFolder(input, options) ? listZarr(input, options) : ofFolder(input, options);
}

}  // namespace kiln
