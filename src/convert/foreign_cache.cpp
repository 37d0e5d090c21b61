#include "convert/foreign_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <system_error>
#include <utility>

#include "base/file/file_lock.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "base/hash.h"
#include "base/memory/memory.h"
#include "base/shell_text.h"
#include "convert/plan.h"
#include "convert/resume/journal.h"
#include "convert/resume/output_directory.h"
#include "convert/store_of_source.h"
#include "ingest/open_source.h"
#include "ingest/source/formats.h"
#include "store/manifest/read_manifest.h"
#include "store/manifest/store_files.h"
#include "store/manifest/store_name.h"
#include "store/store_reader.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Returns the command that made or began the store; nothing if the command is unknown.
std::optional<std::string> makerOf(const fs::path& store) {
  try {
    if (isStore(store)) return readManifest(store).source.command;
    if (const std::optional<ConversionIdentity> begun = Journal::identityIn(store)) return begun->command;
  } catch (const Error&) {
  }
  return std::nullopt;
}

// The commands that make a store of a volume file on the way. Only their stores may be replaced, never a store that a
// user converted.
constexpr std::array kDrawingCommands = {"kiln render ", "kiln slice ", "kiln gallery ", "kiln view "};

void requireOwn(const fs::path& store, const fs::path& input) {
  if (isNothing(store)) return;
  const std::optional<std::string> maker = makerOf(store);
  const auto made = [&](const char* command) { return maker->starts_with(command); };
  if (maker && std::any_of(kDrawingCommands.begin(), kDrawingCommands.end(), made)) return;
  if (maker && !isStore(store))
    throw Error(ErrorCode::kExists, store, "", "is an unfinished conversion; finish it first, by --resume: " + *maker);
  throw Error(ErrorCode::kExists, store, "",
              "is no store that render, slice, gallery or view made of " + input.string() +
                  ", and is not of it as it is now or as it is described; render that store itself, or convert " +
                  input.string() + " to another name");
}

// Returns a part of a file as the end of a name: ".x.y" for "/x/y".
std::string dotted(std::string part) {
  std::replace(part.begin(), part.end(), '/', '.');
  return part;
}

// Returns the name to which ".kiln" is appended: "a.h5.x.y" for "a.h5:/x/y". Resolves "." and ".." and removes a
// trailing slash, so that the store lies beside a directory and not inside.
fs::path baseOf(const fs::path& input) {
  std::error_code error;
  if (const std::string part = partOf(input); !part.empty()) return containerOf(input).string() + dotted(part);
  if (!fs::is_directory(input, error)) return input;
  const fs::path whole = fs::canonical(input, error);
  const fs::path named = withoutTrailingSlash(input);
  return error || (named.filename() != "." && named.filename() != "..") ? named : whole;
}

// Returns an absolute path without links and without a trailing slash.
fs::path wholeNameOf(const fs::path& file) {
  std::error_code unknown;
  fs::path out = fs::weakly_canonical(file, unknown);
  if (unknown) out = fs::absolute(file, unknown);
  return withoutTrailingSlash(out);
}

void requireNoPhantom(const fs::path& input) {
  if (!namesPhantom(input)) return;
  const std::string name = input.string();
  const bool has_size = std::count(name.begin(), name.end(), ':') > 1;
  throw Error(ErrorCode::kUsage,
              "'" + name +
                  "' is computed and not a file, so no store can stand beside it; convert it first: kiln convert " +
                  shellText(has_size ? name : name + ":256x256x256") + " NAME.kiln");
}

bool canWriteIn(const fs::path& folder) {
  try {
    FileSystem::real().makeScratch(folder);
    return true;
  } catch (const Error&) {
    return false;
  }
}

// Checks that the store can be made: in its folder, or in place, in a folder of others.
void requireFolderFor(const fs::path& store, const ForeignVolume& volume) {
  const fs::path folder = store.has_parent_path() ? store.parent_path() : ".";
  if (isFolder(store) && canWriteIn(store)) return;
  try {
    FileSystem::real().makeDirectories(folder);
    FileSystem::real().makeScratch(folder);
  } catch (const Error& error) {
    const std::string text = error.what(), prefix = folder.string() + ": ";
    throw Error(error.code(), folder, "",
                fmt::format("the store of {} cannot be made here ({}); name another folder by --store DIR or the "
                            "variable KILN_STORE_DIR",
                            volume.input.string(), text.starts_with(prefix) ? text.substr(prefix.size()) : text));
  }
}

// True if the input is for StoreReader; options about voxels are then refused.
bool namesStore(const ForeignVolume& volume) {
  requireNoPhantom(volume.input);
  if (!isForStoreReader(volume.input)) return false;
  // StoreReader reports a name without a file.
  if (isThere(volume.input)) requireNoOptions(volume.input, volume.options);
  return true;
}

// A store, and the class of its values. A coarser voxel of labels is the most frequent label, of amounts the mean.
struct ExpectedStore {
  bool as_labels = false;  // by the user's word alone
  fs::path path;

  ExpectedStore(const ForeignVolume& volume, const SourceInfo& info, bool by_user)
      : as_labels(by_user && info.volume_class != VolumeClass::kLabels), path(storePathOf(volume, as_labels)) {}

  bool isMade(const SourceInfo& info, std::uint64_t memory_bytes) const {
    const bool labels = as_labels || info.volume_class == VolumeClass::kLabels;
    return isStoreOf(path, info, memory_bytes) && (readManifest(path).volume_class == VolumeClass::kLabels) == labels;
  }
};

}  // namespace

bool isForStoreReader(const fs::path& input) {
  std::error_code ignored;
  return isStore(input) || (!fs::exists(input, ignored) && containerOf(input) == input) ||
         (fs::is_directory(input, ignored) && input.extension() == ".kiln");
}

std::unique_ptr<VolumeSource> openedWithin(std::uint64_t memory_bytes, const ForeignVolume& volume) {
  SourceOptions options = volume.options;
  options.memory_bytes = memory_bytes;
  return openSource(volume.input, options);
}

fs::path storePathOf(const ForeignVolume& volume, bool as_labels) {
  const std::string ending = as_labels ? ".labels" : "";
  if (volume.store_directory.empty()) return baseOf(volume.input).string() + ending + ".kiln";
  const fs::path file = wholeNameOf(containerOf(volume.input));
  const std::string part = partOf(volume.input);
  const std::string whole = part.empty() ? file.string() : file.string() + ":" + part;
  const std::string hash = toHex(hashOf(whole)).substr(0, kStoreHashDigits);
  return volume.store_directory / hashedStoreName(file.filename().string() + dotted(part) + ending, hash);
}

std::optional<fs::path> madeStoreOf(const ForeignVolume& volume, const SourceInfo& source, std::uint64_t memory_bytes) {
  const ExpectedStore store(volume, source, false);
  return isStore(store.path) && store.isMade(source, memory_bytes) ? std::optional(store.path) : std::nullopt;
}

fs::path madeStoreFor(const ForeignVolume& volume, std::uint64_t memory_bytes, bool labels,
                      const std::function<void(const SourceInfo&)>& opened) {
  const fs::path& input = volume.input;
  if (namesStore(volume)) return input;
  const std::unique_ptr<VolumeSource> source = openedWithin(memory_bytes, volume);
  if (opened) opened(source->info());
  const ExpectedStore store(volume, source->info(), labels);
  if (store.isMade(source->info(), memory_bytes)) return store.path;
  throw Error(
      ErrorCode::kUsage, input, "",
      "is no store, and none of it is there; what its pictures cost is known once it is converted: kiln convert " +
          shellText(input.string()) + (store.as_labels ? " --labels" : "") + " NAME.kiln");
}

fs::path storeFor(const ForeignVolume& volume, const ConvertOptions& options, Progress& progress,
                  const std::function<void(const SourceInfo&)>& opened) {
  const fs::path& input = volume.input;
  if (namesStore(volume)) return input;
  std::unique_ptr<VolumeSource> source = openedWithin(options.memory_bytes, volume);
  if (opened) opened(source->info());
  const ExpectedStore expected(volume, source->info(), options.labels);
  const fs::path& store = expected.path;
  if (expected.isMade(source->info(), options.memory_bytes)) {
    progress.note("using the store " + store.string() + " made from it before");
    return store;
  }
  requireFolderFor(store, volume);
  bool waits = false;
  const FileLock lock(lockOf(behindLinks(store)), [&] {
    if (!std::exchange(waits, true)) progress.note("waiting for another process that converts " + input.string());
    progress.throwIfCancelled("waiting for another process");
  });
  if (expected.isMade(source->info(), options.memory_bytes)) return store;
  for (const char* const of_name : {"", ".partial"}) requireOwn(store.string() + of_name, input);
  // Tests the budget before any note, so that an error about the budget stands alone.
  planConversion(*source, options);
  progress.note("converting to the store " + store.string() + " first");
  ConvertOptions replacing = options;
  replacing.overwrite = replacing.resume = true;
  replacing.lock = &lock;
  convert(*source, store, replacing, progress);
  // Frees the source, so that the picture has the whole budget.
  source.reset();
  returnFreedMemory();
  return store;
}

}  // namespace kiln
