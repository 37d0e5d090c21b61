#include "store/store_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "base/file/renamed_error.h"
#include "base/file/same_file.h"
#include "base/memory/large_pages.h"
#include "base/memory/memory.h"
#include "base/thread/profile_scope.h"
#include "store/brick_index.h"
#include "store/codec/brick_codec.h"
#include "store/manifest/read_manifest.h"
#include "store/manifest/store_files.h"
#include "store/store_writer.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kLargestManifest = 64ull << 20;

// True if a voxel of the type may have the value.
bool holds(VoxelType type, double value) {
  return withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_floating_point_v<T>) return true;
    return value >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
           value <= static_cast<double>(std::numeric_limits<T>::max());
  });
}

// True for a finished or unfinished store. Two names are tested, because a folder of slices may hold one file of such a
// name.
bool holdsStore(const fs::path& folder) {
  std::error_code unknown;
  const auto holds_both = [&](const char* a, const char* b) {
    return fs::exists(folder / a, unknown) && fs::exists(folder / b, unknown);
  };
  return holds_both(kManifestFile, kIndexFile) || holds_both("journal.bin", "bricks");
}

// The name itself if the working directory is gone.
fs::path absoluteName(const fs::path& directory) {
  std::error_code unknown;
  const fs::path out = fs::absolute(directory, unknown);
  return unknown ? directory : out;
}

// `store`: the folder of the store. A part made by kiln split lacks bricks that are not damaged.
File opened(const fs::path& path, std::uint64_t bytes, const fs::path& store) {
  try {
    return File(path);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    std::error_code unknown;
    const char* const remedy = fs::exists(store / kPartFile, unknown)
                                   ? "the store is a part that kiln split made (kiln info names its voxels); draw the "
                                     "part with --part, name the whole store, or split the store again"
                                   : "restore the file or convert the source again";
    throw Error(ErrorCode::kNotFound, path, "", fmt::format("is missing, expected {} bytes; {}", bytes, remedy));
  }
}

// Reads a file, tests its size before allocating memory, and its checksum before returning the bytes.
template <class Bytes>
Bytes readChecked(const fs::path& path, std::uint64_t bytes, const Hash128& expected, const fs::path& store) {
  const File file = opened(path, bytes, store);
  if (file.size() != bytes) {
    throw Error(
        ErrorCode::kDamaged, path, "",
        fmt::format("has {} bytes, expected {}; restore the file or convert the source again", file.size(), bytes));
  }
  Bytes data(bytes);
  file.readAt(0, data);
  const Hash128 found = hashOf(data);
  if (found != expected) {
    throw Error(ErrorCode::kDamaged, path, "",
                fmt::format("checksum {}, expected {}; restore the file or convert the source again", toHex(found),
                            toHex(expected)));
  }
  return data;
}

// Counts are limited by the size of the index file, because a manifest may claim more bricks.
void requireIndexWithin(const Manifest& manifest, std::uint64_t memory_bytes, std::uint64_t held_bytes,
                        const fs::path& store) {
  const std::uint64_t entries = manifest.index_bytes / BrickIndex::fileBytes(0, 1, manifest.brick_size);
  std::uint64_t bricks = 0, stored = 0;
  for (const LevelInfo& level : manifest.levels) {
    bricks += std::min(static_cast<std::uint64_t>(level.bricks.count()), entries);
    stored += std::min(level.stored_bricks, entries);
  }
  bricks = std::min(bricks, entries), stored = std::min(stored, bricks);
  const std::uint64_t needed = manifest.index_bytes + BrickIndex::bytesOf(stored, bricks - stored, manifest.brick_size);
  if (held_bytes <= memory_bytes && needed <= memory_bytes - held_bytes) return;
  const std::string beside = held_bytes > 0 ? fmt::format(" beside {} of other stores", formatBytes(held_bytes)) : "";
  throw Error(
      ErrorCode::kBudget, store, "--memory",
      fmt::format(
          "the index of {} bricks alone takes {}{} (allowed: {}), and bricks take more; give more than --memory {}, "
          "or convert the source again with a --brick-size larger than {}",
          bricks, formatBytes(needed), beside, formatBytes(memory_bytes), roundedUpBytes(held_bytes + needed),
          manifest.brick_size));
}

// Returns the manifest's path. throws: Error kNotFound, kFormat if `directory` is no store.
fs::path manifestOf(const fs::path& directory) {
  const fs::path path = directory / kManifestFile;
  if (!isThere(directory))
    throw Error(ErrorCode::kNotFound, directory, "", "there is no such file or store; check the name");
  if (!isFolder(directory))
    throw Error(ErrorCode::kFormat, directory, "", "is a file, not a store; name a store's folder");
  if (!isThere(path)) {
    throw Error(ErrorCode::kFormat, directory, kManifestFile,
                "is missing: not a store, or a conversion that did not finish; run kiln convert again");
  }
  return path;
}

}  // namespace

Manifest readManifest(const fs::path& directory) {
  const fs::path path = manifestOf(directory);
  return parseManifest(readTextFile(path, kLargestManifest), path);
}

StoreReader::StoreReader(const fs::path& directory, std::uint64_t memory_bytes, std::uint64_t held_bytes)
    : BrickedVolume(directory), folder_(absoluteName(directory)) {
  // A store replaced between reading its two files is opened again. After so many tries the error is reported.
  constexpr int kTries = 5;
  for (int i = 1;; ++i) {
    try {
      open(memory_bytes, held_bytes);
      return;
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kReplaced || i == kTries) throw;
    }
  }
}

void StoreReader::open(std::uint64_t memory_bytes, std::uint64_t held_bytes) {
  opened_ = std::make_shared<const std::optional<FileIdentity>>(identityOf(manifestOf(path())));
  Manifest manifest = readManifest(path());
  requireIndexWithin(manifest, memory_bytes, held_bytes, path());
  const auto data = checkedFile<UnsetBytes>(kIndexFile, manifest.index_bytes, manifest.index_checksum);
  BrickIndex entries = BrickIndex::decode(data, manifest.lattices(), path() / kIndexFile);
  hold(std::move(manifest), std::move(entries));
}

std::unique_ptr<BrickedVolume> StoreReader::share() const { return std::make_unique<StoreReader>(*this); }

std::vector<std::byte> StoreReader::readFile(const BrickKey& key) const {
  return bytesOfFile<std::vector<std::byte>>(key);
}

void StoreReader::requireUnchanged() const {
  const std::optional<FileIdentity> now = identityOf(folder_ / kManifestFile);
  if (now == *opened_) return;
  throw Error(ErrorCode::kReplaced, path(), "",
              fmt::format("the store was {} while it was read by this command; run the command again",
                          now ? "replaced" : "replaced or removed"));
}

template <class Bytes>
Bytes StoreReader::checkedFile(const fs::path& name, std::uint64_t bytes, const Hash128& checksum) const {
  const fs::path file = folder_ / name;
  try {
    return readChecked<Bytes>(file, bytes, checksum, folder_);
  } catch (const Error& error) {
    // Files of a replacement store are no damage.
    if (error.code() == ErrorCode::kDamaged || error.code() == ErrorCode::kNotFound) requireUnchanged();
    throw renamed(error, file, path() / name);
  }
}

template <class Bytes>
Bytes StoreReader::bytesOfFile(const BrickKey& key) const {
  const BrickEntry& entry = index().at(key);
  ProfileScope span(Activity::kRead);
  if (span.traced()) {
    span.note("brick", brickPath(key).native());
    span.note("bytes", entry.file_bytes);
  }
  return checkedFile<Bytes>(brickPath(key), entry.file_bytes, entry.checksum);
}

std::optional<double> StoreReader::constantOf(const BrickKey& key) const {
  const BrickEntry& entry = index().at(key);
  if (!entry.constant) return std::nullopt;
  if (!holds(manifest().type, entry.core.lo))
    throw Error(
        ErrorCode::kDamaged, path() / kIndexFile, brickPath(key).string(),
        fmt::format("is all {}, which is no {}; convert the source again", entry.core.lo, nameOf(manifest().type)));
  return entry.core.lo;
}

BrickBlock StoreReader::read(const BrickKey& key) const {
  if (const std::optional<double> constant = constantOf(key)) return constantBrick(frame(key), *constant);
  return decode(key, bytesOfFile<UnsetBytes>(key));
}

bool StoreReader::check(const BrickKey& key, std::span<const std::byte> file) const {
  const BrickEntry& entry = index().at(key);
  return file.size() == entry.file_bytes && hashOf(file) == entry.checksum;
}

BrickBlock StoreReader::decode(const BrickKey& key, std::span<const std::byte> file) const {
  ProfileScope span(Activity::kDecode);
  if (span.traced()) span.note("brick", brickPath(key).native());
  return decodeBrick(frame(key), file, path() / brickPath(key));
}

std::size_t StoreReader::readBytes(const BrickKey& key) const {
  return decodeBytes(frame(key)) + index().at(key).file_bytes;
}

std::uint64_t StoreReader::largestFileBytes() const {
  return index().largest([this](const BrickKey& key) { return index().at(key).file_bytes; });
}

bool isStore(const fs::path& directory) { return isThere(directory) && isThere(directory / kManifestFile); }

void requireOutsideStores(const fs::path& path, const std::string& option) {
  if (isWrittenInPlace(path)) return;
  std::error_code unknown;
  // Only the existing folders, if some folders of the name are still to be made.
  fs::path folder = behindLinks(withoutTrailingSlash(path)).parent_path();
  folder = fs::weakly_canonical(fs::absolute(folder.empty() ? "." : folder, unknown), unknown);
  for (; !unknown && folder.has_relative_path(); folder = folder.parent_path()) {
    if (!holdsStore(folder)) continue;
    throw Error(ErrorCode::kUsage,
                fmt::format("{}{} would be in the store {}, which holds its own files only; name another folder",
                            option.empty() ? "" : option + ": ", path.string(), folder.string()));
  }
}

}  // namespace kiln
