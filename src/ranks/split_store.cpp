#include "ranks/split_store.h"

#include <fmt/format.h>

#include <sstream>
#include <system_error>
#include <utility>

#include "base/file/file.h"
#include "base/file/file_lock.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "base/file/same_file.h"
#include "scene/clip_region.h"
#include "store/manifest/store_files.h"
#include "store/store_writer.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Links or copies a file under the same name of another directory.
void bring(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::create_hard_link(from, to, failed);
  if (failed) FileSystem::real().writeOwn(to, readFile(from), WritePolicy::kUnsynced);
}

// A directory named NAME.partial until all files are in it, then renamed to NAME. The holder of the lock removes the
// remains of a killed process.
class NewDirectory {
 public:
  explicit NewDirectory(const fs::path& path) : path_(path), building_(path.string() + ".partial") {
    std::error_code ignored;
    if (fs::exists(fs::symlink_status(building_, ignored))) {
      requireOwner(building_);
      const fs::path mark = building_ / kPartFile;
      if (!fs::exists(mark, ignored) && !fs::exists(mark.string() + ".tmp", ignored) &&
          !fs::is_empty(building_, ignored))
        throw Error(ErrorCode::kExists, building_, "", "is in the way and is no unfinished part; move it");
      FileSystem::real().removeAll(building_);
    }
    FileSystem::real().makeDirectories(building_);
    requireOwner(building_);
  }
  ~NewDirectory() {
    std::error_code ignored;
    fs::remove_all(building_, ignored);
  }
  NewDirectory(const NewDirectory&) = delete;
  NewDirectory& operator=(const NewDirectory&) = delete;

  const fs::path& building() const { return building_; }
  void publish() { FileSystem::real().rename(building_, path_); }

 private:
  const fs::path path_, building_;
};

// Returns whether a directory is a finished part of the same store for `box`. The manifest, written last, holds the
// checksum of the index.
bool isPartOf(const StoreReader& store, const VoxelBox& box, const fs::path& directory) {
  try {
    return boxOfStorePart(directory) == box &&
           readFile(directory / kManifestFile) == readFile(store.path() / kManifestFile);
  } catch (const Error&) {
    return false;
  }
}

std::string textOf(const VoxelBox& box) {
  return fmt::format("{} {} {} {} {} {}\n", box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z);
}

}  // namespace

std::function<bool(const BrickKey&)> bricksOfStorePart(const StoreReader& store, const VoxelBox& box) {
  Clipping clipping;
  clipping.part = box;
  std::vector<ClipRegion::Part> parts;  // a level each
  for (int level = 0; level < store.index().levels(); ++level)
    parts.push_back(ClipRegion(clipping, store.manifest().geometry(), store.manifest().spanOf(level)).part());
  return [&store, parts = std::move(parts), overview = store.overviewLevel()](const BrickKey& key) {
    if (store.index().at(key).constant) return false;
    return key.level == overview ||
           parts[static_cast<std::size_t>(key.level)].touches(dilated(store.frame(key).core(), store.manifest().apron));
  };
}

StorePart writeStorePart(const StoreReader& store, const VoxelBox& box, const fs::path& path, Progress& progress) {
  FileSystem& disk = FileSystem::real();
  const fs::path directory = withoutTrailingSlash(path);
  requireOutsideStores(directory, "-o");
  if (directory.has_parent_path()) disk.makeDirectories(directory.parent_path());
  const FileLock lock(lockOf(directory), refusalOf(directory));
  std::error_code unreadable;
  const bool is_there = fs::exists(directory, unreadable) || unreadable;
  if (is_there && isPartOf(store, box, directory)) return {.was_there = true};
  if (is_there)
    throw Error(ErrorCode::kExists, directory, "", "is there already; remove it, or name another directory");
  const auto holds = bricksOfStorePart(store, box);
  const auto forEach = [&](auto&& body) {
    store.index().forEachKey([&](const BrickKey& key) {
      if (holds(key)) body(key);
    });
  };
  NewDirectory part(directory);
  const fs::path& building = part.building();
  disk.writeOwn(building / kPartFile, textOf(box));  // marks the unfinished folder as a part
  std::uint64_t bytes = 0, done = 0, bricks = 0;
  forEach([&](const BrickKey&) { ++bricks; });
  try {
    forEach([&](const BrickKey& key) {
      progress.throwIfCancelled("splitting");
      const fs::path name = brickPath(key);
      disk.makeDirectories((building / name).parent_path());
      bring(store.path() / name, building / name);
      bytes += store.index().at(key).file_bytes;
      progress.advance("splitting", "bricks", ++done, bricks);
    });
    bring(store.path() / kIndexFile, building / kIndexFile);
    disk.syncAll(building);
    const std::vector<std::byte> manifest = readFile(store.path() / kManifestFile);
    // Files were copied by name; an unchanged store proves that all files belong to one store.
    store.requireUnchanged();
    disk.writeOwn(building / kManifestFile, manifest);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kNotFound) store.requireUnchanged();
    throw;
  }
  part.publish();
  return {.bytes = bytes};
}

VoxelBox boxOfStorePart(const fs::path& directory) {
  const fs::path path = directory / kPartFile;
  std::istringstream in(readTextFile(path, 1024));
  VoxelBox box;
  for (VoxelCoord* const corner : {&box.lo, &box.hi}) {
    for (int axis = 0; axis < 3; ++axis) in >> (*corner)[axis];
  }
  if (!in || box.empty()) throw Error(ErrorCode::kFormat, path, "", "is not the box of a part that kiln split made");
  return box;
}

std::optional<VoxelBox> findStorePart(const fs::path& store, Progress& progress) {
  if (!isThere(store / kPartFile)) return std::nullopt;
  try {
    return boxOfStorePart(store);
  } catch (const Error& error) {
    progress.note(std::string(error.what()) + "; the store is taken as a whole one");
    return std::nullopt;
  }
}

void requireWhole(const std::vector<VoxelBox>& boxes, const Extent3& dims) {
  std::int64_t voxels = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    voxels += boxes[i].count();
    for (std::size_t j = 0; j < i; ++j) {
      if (!intersection(boxes[i], boxes[j]).empty())
        throw Error(
            ErrorCode::kUsage,
            fmt::format("--store-local: ranks {} and {} hold the same voxels; each needs a part of its own", j, i));
    }
  }
  if (voxels != dims.count())
    throw Error(ErrorCode::kUsage,
                fmt::format("--store-local: the parts of {} ranks hold {} of {} voxels; run as many ranks as kiln "
                            "split made parts",
                            boxes.size(), voxels, dims.count()));
}

}  // namespace kiln
