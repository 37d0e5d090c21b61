// Directories of slices also hold notes, thumbnails, a DICOMDIR. Files that are not slices are passed over and named in
// a note, so that the user notices an unrecognised slice.
#include "ingest/slice_directory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <optional>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/folder.h"
#include "base/file/path_status.h"
#include "ingest/dicom/dicom_bytes.h"
#include "ingest/dicom/dicom_directory.h"
#include "ingest/source/header_text.h"
#include "ingest/volume_format.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

using namespace std::string_view_literals;

bool isDigit(char c) { return c >= '0' && c <= '9'; }

// Returns the digits at the front of `text` without leading zeros, and removes all of them from `text`.
std::string_view takeNumber(std::string_view& text) {
  const auto end = std::find_if_not(text.begin(), text.end(), isDigit);
  std::string_view digits = text.substr(0, static_cast<std::size_t>(end - text.begin()));
  text.remove_prefix(digits.size());
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return digits;
}

// A file that cannot be read, and the reason.
struct Unread {
  fs::path path;
  ErrorCode code;
  std::string reason;
};

Unread unreadBy(const Error& error, const fs::path& path) {
  const std::string text = error.what(), prefix = path.string() + ": ";
  return {path, error.code(), text.starts_with(prefix) ? text.substr(prefix.size()) : text};
}

// Drops an error's remedy, because a file beside other slices has another remedy.
std::string withoutRemedy(const std::string& sentence) { return sentence.substr(0, sentence.find(';')); }

// True if a slice has the ending of `path`. DICOM exports often have files without an ending.
bool isNamedLike(const fs::path& path, const std::vector<fs::path>& slices) {
  return std::any_of(slices.begin(), slices.end(),
                     [&](const fs::path& slice) { return slice.extension() == path.extension(); });
}

// An unreadable file named like a slice is an error, because without it the slices above would move down. Other
// unreadable files are passed over.
void passOver(const std::vector<Unread>& unread, const std::vector<fs::path>& slices, std::vector<std::string>& notes) {
  for (const Unread& file : unread) {
    if (slices.empty()) throw Error(file.code, file.path, "", file.reason);
    if (isNamedLike(file.path, slices))
      throw Error(file.code, file.path, "",
                  "is named like the slices beside it, and cannot be read (" + withoutRemedy(file.reason) +
                      "); mend or remove it");
    notes.push_back("passed over " + inQuotes(file.path.filename().string()) + ", which cannot be read (" +
                    withoutRemedy(file.reason) + ") and is not named like the slices");
  }
}

SliceFormat formatOf(const fs::path& path) {
  if (!isThere(path)) return SliceFormat::kNone;
  std::string bytes(512, '\0');
  const File file(path);
  bytes.resize(file.readSomeAt(0, std::as_writable_bytes(std::span(bytes))));
  if (bytes.starts_with("\x89PNG\r\n\x1a\n")) return SliceFormat::kPng;
  if (bytes.starts_with("\xff\xd8\xff")) return SliceFormat::kJpeg;
  if (bytes.starts_with("\0\0\0\x0cjP  \r\n\x87\n"sv) || bytes.starts_with("\xff\x4f\xff\x51"))
    return SliceFormat::kJpeg2000;
  return sliceFormatOf(bytes);
}

std::string named(const std::vector<fs::path>& files) {
  const std::string first = inQuotes(files.front().filename().string());
  return files.size() == 1 ? first : first + " and " + std::to_string(files.size() - 1) + " more";
}

// Moves the files named as logs out of `files`.
std::vector<fs::path> takeLogs(std::vector<fs::path>& files) {
  const auto isLog = [](const fs::path& path) { return extensionOf(path) == ".log"; };
  std::vector<fs::path> out;
  std::copy_if(files.begin(), files.end(), std::back_inserter(out), isLog);
  std::erase_if(files, isLog);
  return out;
}

// True for a link to nothing, or to itself.
bool isBadLink(const fs::path& path) {
  std::error_code unknown;
  return fs::is_symlink(fs::symlink_status(path, unknown)) && !fs::exists(fs::status(path, unknown));
}

// DICOM slices carry their positions: a missing slice moves no other slice, and the gap is detected later. So links to
// nothing are passed over.
void passOverBadLinks(std::vector<Unread>& unread, std::vector<fs::path>& other, std::vector<std::string>& notes) {
  std::vector<fs::path> links;
  for (const Unread& file : unread) {
    if (isBadLink(file.path)) links.push_back(file.path);
  }
  std::copy_if(other.begin(), other.end(), std::back_inserter(links), isBadLink);
  std::erase_if(unread, [](const Unread& file) { return isBadLink(file.path); });
  std::erase_if(other, isBadLink);
  if (!links.empty()) notes.push_back("passed over " + named(links) + ": links to nothing");
}

// The entries of a directory: files; and pipes, devices and folders, which cannot be slices.
struct Entries {
  std::vector<fs::path> files, others;
};

Entries entriesOf(const fs::path& directory) {
  Entries out;
  forEachEntry(directory, [&](const fs::directory_entry& entry) {
    // An entry without a status, such as a link to nothing, may be a missing slice.
    std::error_code unknown;
    const fs::file_status status = entry.status(unknown);
    const bool hidden = entry.path().filename().string().starts_with('.');
    const bool file = unknown || !fs::exists(status) || fs::is_regular_file(status);
    if (!hidden) (file ? out.files : out.others).push_back(entry.path());
    return Walk::kGoOn;
  });
  for (std::vector<fs::path>* const paths : {&out.files, &out.others}) {
    std::sort(paths->begin(), paths->end(), [](const fs::path& a, const fs::path& b) {
      return naturallyBefore(a.filename().string(), b.filename().string());
    });
  }
  return out;
}

// Returns all folders below a directory, in natural order of their paths. Links to folders are not followed.
std::vector<fs::path> foldersBelow(const fs::path& directory) {
  std::vector<fs::path> out;
  forEachEntryBelow(directory, [&](const fs::directory_entry& entry) {
    std::error_code unknown;
    if (entry.path().filename().string().starts_with('.')) return Walk::kPassOver;
    if (!entry.is_symlink(unknown) && entry.is_directory(unknown)) out.push_back(entry.path());
    return Walk::kGoOn;
  });
  std::sort(out.begin(), out.end(),
            [](const fs::path& a, const fs::path& b) { return naturallyBefore(a.string(), b.string()); });
  return out;
}

struct FolderFile {
  fs::path path;
  SliceFormat format;
};

// The entries of one folder or several.
struct FolderEntries {
  std::vector<FolderFile> files;
  /// Pipes, devices and folders.
  std::vector<fs::path> no_files;
  std::vector<Unread> unread;

  void add(const fs::path& folder) {
    const Entries entries = entriesOf(folder);
    no_files.insert(no_files.end(), entries.others.begin(), entries.others.end());
    for (const fs::path& path : entries.files) {
      try {
        files.push_back({path, formatOf(path)});
      } catch (const Error& error) {
        unread.push_back(unreadBy(error, path));
      }
    }
  }
  void addBelow(const fs::path& directory) {
    for (const fs::path& folder : foldersBelow(directory)) add(folder);
  }
  std::vector<fs::path> of(SliceFormat format) const {
    std::vector<fs::path> out;
    for (const FolderFile& file : files)
      if (file.format == format) out.push_back(file.path);
    return out;
  }
  // Returns all files that are no slices of a volume of this format.
  std::vector<fs::path> besides(SliceFormat format) const {
    std::vector<fs::path> out;
    for (const FolderFile& file : files)
      if (file.format != format || format == SliceFormat::kNone) out.push_back(file.path);
    return out;
  }
  // Removes the lists of DICOM files. Returns the first one; nothing if there is none.
  std::optional<fs::path> takeDicomDirectory() {
    std::optional<fs::path> out;
    std::erase_if(files, [&](const FolderFile& file) {
      const bool is_list = file.format == SliceFormat::kDicom && isDicomDirectory(file.path);
      if (is_list && !out) out = file.path;
      return is_list;
    });
    return out;
  }
};

// Notes DICOM files in folders below a folder that has slices of its own, because these files may belong to the volume.
// Unreadable files there are no part of the volume.
void noteSlicesBelow(const fs::path& directory, std::vector<std::string>& notes) {
  FolderEntries entries;
  entries.addBelow(directory);
  const std::vector<fs::path> below = entries.of(SliceFormat::kDicom);
  if (below.empty()) return;
  notes.push_back(fmt::format(
      "passed over {} DICOM file{} in folders below, as {}: the folder has slices of its own; to read them, name their "
      "folder, or put all slices into one",
      below.size(), below.size() == 1 ? "" : "s", inQuotes(below.front().lexically_relative(directory).string())));
}

[[noreturn]] void refuseFolder(const fs::path& directory, const std::string& what) {
  throw Error(ErrorCode::kUnsupported, directory, "", what);
}

[[noreturn]] void refuseBoth(const fs::path& directory, SliceFormat a, const std::vector<fs::path>& of_a, SliceFormat b,
                             const std::vector<fs::path>& of_b) {
  refuseFolder(directory,
               fmt::format("holds {} files ({}) and {} files ({}); a directory is read as one volume, so put "
                           "them apart",
                           nameOf(a), named(of_a), nameOf(b), named(of_b)));
}

using FormatFiles = std::pair<SliceFormat, std::vector<fs::path>>;

// The pictures among the entries, by their formats.
std::vector<FormatFiles> picturesOf(const FolderEntries& entries) {
  std::vector<FormatFiles> out;
  for (const SliceFormat format : kPictureFormats)
    if (std::vector<fs::path> files = entries.of(format); !files.empty()) out.emplace_back(format, std::move(files));
  return out;
}

// Refuses a folder of volume files; returns if there are none.
void refuseVolumeFiles(const fs::path& directory, std::vector<fs::path> files) {
  std::erase_if(files, [](const fs::path& file) { return !isThere(file) || !volumeFormatOf(file).read; });
  if (files.empty()) return;
  const std::string found = files.size() == 1 ? "a volume file" : fmt::format("{} volume files", files.size());
  refuseFolder(directory,
               fmt::format("a directory is read as slices of one volume (found {}: {}); name {}; kiln convert "
                           "DIRECTORY --list lists all",
                           found, named(files), files.size() == 1 ? "the file" : "one file at a time"));
}

// The slices of a folder by their format, without notes on other files. Searches the folders below if `in_subfolders`
// is true, or the folder has no slices; sets `in_subfolders` if they were searched.
SliceFiles chosenSlices(const fs::path& directory, FolderEntries& entries, bool& in_subfolders) {
  using enum SliceFormat;
  const std::vector<FormatFiles> pictures = picturesOf(entries);
  in_subfolders = in_subfolders || (entries.of(kTiff).empty() && entries.of(kDicom).empty());
  if (in_subfolders) entries.addBelow(directory);
  const std::vector<fs::path> tiff = entries.of(kTiff), dicom = entries.of(kDicom);
  if (!tiff.empty() && !dicom.empty()) refuseBoth(directory, kTiff, tiff, kDicom, dicom);
  if (!dicom.empty()) return {directory, kDicom, dicom, {}, {}};
  if (!tiff.empty() && !in_subfolders) return {directory, kTiff, tiff, {}, {}};
  if (pictures.size() > 1)
    refuseBoth(directory, pictures[0].first, pictures[0].second, pictures[1].first, pictures[1].second);
  if (!pictures.empty()) return {directory, pictures[0].first, pictures[0].second, {}, {}};
  if (!tiff.empty())
    refuseFolder(directory, "a directory without slices, but there are TIFF files in " +
                                tiff.front().parent_path().string() +
                                "; name the folder that holds the slices of one volume");
  return {directory, kNone, {}, {}, {}};
}

// Skipping a file named like a slice would move the slices above it down.
void requireNoneNamedAlike(const SliceFiles& slices, const std::vector<fs::path>& other,
                           const std::vector<fs::path>& no_files) {
  for (const fs::path& path : other) {
    if (!path.has_extension() || !isNamedLike(path, slices.files)) continue;
    if (!isThere(path))
      throw Error(ErrorCode::kNotFound, path, "",
                  "is named like the slices beside it, and is a link to nothing; mend or remove it");
    throw Error(
        ErrorCode::kFormat, path, "",
        fmt::format("is named like the slices beside it, but is no {} file: empty or damaged; mend or remove it",
                    nameOf(slices.format)));
  }
  for (const fs::path& path : no_files) {
    if (!isNamedLike(path, slices.files)) continue;
    // DICOM slices carry their positions, and names of files and folders may be identifiers such as 1.3.6.1.
    if (isFolder(path) && (slices.format == SliceFormat::kDicom || !path.has_extension())) continue;
    throw Error(ErrorCode::kFormat, path, "",
                fmt::format("is named like the slices beside it, but is a {}; rename or remove it",
                            isFolder(path) ? "folder" : "pipe or a device"));
  }
}

}  // namespace

SliceFormat sliceFormatOf(std::string_view bytes) {
  if (bytes.size() >= 132 && bytes.substr(128, 4) == "DICM") return SliceFormat::kDicom;
  for (const std::string_view magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (bytes.starts_with(magic)) return SliceFormat::kTiff;
  }
  return looksLikeDicom(bytes) ? SliceFormat::kDicom : SliceFormat::kNone;
}

bool naturallyBefore(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a, whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (isDigit(a.front()) && isDigit(b.front())) {
      const std::string_view n = takeNumber(a), m = takeNumber(b);
      if (n.size() != m.size()) return n.size() < m.size();
      if (n != m) return n < m;
    } else {
      if (a.front() != b.front()) return static_cast<unsigned char>(a.front()) < static_cast<unsigned char>(b.front());
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  return a.empty() != b.empty() ? a.empty() : whole_a < whole_b;
}

FolderFiles filesIn(const fs::path& directory) {
  using enum SliceFormat;
  FolderEntries entries;
  entries.add(directory);
  const bool listed = entries.takeDicomDirectory().has_value();
  FolderFiles out = {entries.of(kTiff), entries.of(kDicom), entries.of(kNone), {}};
  if (!listed && !(out.tiff.empty() && out.dicom.empty())) return out;
  std::vector<FormatFiles> pictures = picturesOf(entries);
  entries.addBelow(directory);
  entries.takeDicomDirectory();
  out.dicom = entries.of(kDicom);
  if (out.tiff.empty() && out.dicom.empty()) out.pictures = std::move(pictures);
  return out;
}

SliceFiles slicesIn(const fs::path& directory) {
  FolderEntries entries;
  entries.add(directory);
  const std::optional<fs::path> list = entries.takeDicomDirectory();
  const std::string missing = list ? missingOf(*list) : "";
  bool in_subfolders = list.has_value();
  SliceFiles out = chosenSlices(directory, entries, in_subfolders);
  const bool dicom = out.format == SliceFormat::kDicom;
  std::vector<fs::path> other = entries.besides(out.format);
  // Pictures are slices of their own folder only.
  if (std::find(std::begin(kPictureFormats), std::end(kPictureFormats), out.format) != std::end(kPictureFormats))
    std::erase_if(other, [&](const fs::path& path) { return path.parent_path() != directory; });
  if (dicom) passOverBadLinks(entries.unread, other, out.notes);
  passOver(entries.unread, out.files, out.notes);
  if (out.files.empty()) refuseVolumeFiles(directory, other);
  if (out.files.empty())
    refuseFolder(directory, "a directory without slices: it holds no TIFF, DICOM, PNG, JPEG or JPEG 2000 file (found " +
                                (other.empty() ? std::string("no file") : named(other)) + ")");
  requireNoneNamedAlike(out, other, entries.no_files);
  if (!in_subfolders && dicom) noteSlicesBelow(directory, out.notes);
  if (!missing.empty()) out.notes.push_back(missing);
  if (out.format == SliceFormat::kTiff) out.logs = takeLogs(other);
  if (!other.empty()) out.notes.push_back("passed over " + named(other) + ", which are no slices");
  return out;
}

}  // namespace kiln
