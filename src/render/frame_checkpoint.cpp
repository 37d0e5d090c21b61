// The file: records (base/record_file.h), the first of which is the hashes of the frame's files; then each tile
// (render/tile_image.h).
#include "render/frame_checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "base/byte_record.h"
#include "base/file.h"
#include "base/record_file.h"
#include "render/aov_planes.h"
#include "render/frame_files.h"
#include "render/frame_progress.h"
#include "render/tile_image.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr RecordMagic kMagic = {'K', 'I', 'L', 'N', 'T', 'I', 'L', '1'};
// A multiple of what the visibility structure is made of. unit: pixels.
constexpr int kEdge = 512;

using Place = std::tuple<int, int, int, int>;
Place placeOf(const PixelRect& at) { return {at.x0, at.y0, at.x1, at.y1}; }

class TileFile {
 public:
  TileFile(fs::path path, std::string identity) : path_(std::move(path)), identity_(std::move(identity)) {}

  // Puts the tiles that are there into the image; returns which. throws: Error kExists where the file is of another
  // picture, or of no picture at all.
  std::set<Place> read(const std::vector<PixelRect>& tiles, const PixelRect& whole, Image& image) {
    std::set<Place> known, found;
    for (const PixelRect& tile : tiles) known.insert(placeOf(tile));
    bool is_first = true, is_ours = false;
    const std::optional<std::uint64_t> bytes = readRecords(path_, kMagic, [&](std::span<const std::byte> payload) {
      ByteTaker taker{payload};
      if (std::exchange(is_first, false)) return is_ours = taker.takeText() == identity_;
      const auto at = taker.take<PixelRect>();
      if (!taker.ok || !known.contains(placeOf(at))) return false;
      const std::optional<Image> tile = takeTile(taker, at);
      if (!tile) return false;
      putTile(*tile, at, whole, image);
      found.insert(placeOf(at));
      return true;
    });
    begun_ = bytes && is_ours;
    if (!begun_ && fs::exists(path_))
      throw Error(ErrorCode::kExists, path_, "",
                  fmt::format("{}; name another picture, or remove the file",
                              bytes && !is_first ? "has tiles of another picture, or of another volume"
                                                 : "is where tiles would be kept, and has none"));
    // What was torn is cut off, so that the next one is read again.
    std::error_code failed;
    if (begun_) fs::resize_file(path_, *bytes, failed);
    if (failed) throw systemError(failed.value(), path_, "shortening");
    return found;
  }

  void add(const PixelRect& at, const Image& tile) {
    FileSystem& disk = FileSystem::real();
    if (!std::exchange(begun_, true)) {
      std::vector<std::byte> beginning = beginningOf(kMagic), identity;
      appendText(identity, identity_);
      appendRecord(beginning, identity);
      disk.writeAtomic(path_, beginning);
    }
    std::vector<std::byte> bytes, record;
    appendTile(bytes, at, tile);
    appendRecord(record, bytes);
    disk.appendFile(path_, record);
  }

  const fs::path& path() const { return path_; }

 private:
  const fs::path path_;
  const std::string identity_;
  bool begun_ = false;
};

std::string identityOf(const OpenedJob& opened, int frame, const FrameScene& scene) {
  std::string out;
  for (const OutputFile& file : filesOf(opened.job(), frame))
    out += contentHash(opened.job(), file, scene, opened.store()) + "\n";
  return out;
}

}  // namespace

fs::path checkpointOf(const RenderJob& job, int frame) { return filesOf(job, frame).front().path.string() + ".tiles"; }

std::uint64_t checkpointBytes(const RenderJob& job) {
  // A tile and its record, twice where the record is put together.
  return 3 * (16 + aovBytes(drawnAovs(job))) * std::uint64_t{kEdge} * kEdge;
}

void requireCheckpoint(const RenderJob& job) {
  if (job.picture.skip_damaged)
    throw Error(ErrorCode::kUsage,
                "--checkpoint: tiles of a picture with --skip-damaged are not kept; give one of them");
  if (job.speed.visibility.method == VisibilityMethod::kQuadtree)
    throw Error(ErrorCode::kUsage,
                "--checkpoint: what --visibility quadtree hides depends on the tiles; choose an exact method");
  if (const char* const view = viewWithoutTiles(job))
    throw Error(ErrorCode::kUsage, fmt::format("--checkpoint: tiles of {} are not kept; leave it out", view));
}

std::vector<PixelRect> checkpointTiles(const PixelRect& pixels) {
  std::vector<PixelRect> out;
  bool backwards = false;
  for (int y = pixels.y0 / kEdge * kEdge; y < pixels.y1; y += kEdge, backwards = !backwards) {
    const std::size_t row = out.size();
    for (int x = pixels.x0 / kEdge * kEdge; x < pixels.x1; x += kEdge)
      out.push_back(intersection(PixelRect{x, y, x + kEdge, y + kEdge}, pixels));
    if (backwards) std::reverse(out.begin() + static_cast<std::ptrdiff_t>(row), out.end());
  }
  return out;
}

DrawnFrame drawInTiles(OpenedJob& opened, int frame, bool resume, Progress& progress) {
  DrawnFrame out;
  out.scene = opened.sceneAt(frame);
  const FrameRequest request = opened.requestFor(out.scene);
  const PixelRect whole = drawnPixels(request.view.size, request.crop);
  const std::vector<PixelRect> tiles = checkpointTiles(whole);
  Image& image = out.views.emplace_back(DrawnView{Image(whole.width(), whole.height()), request.view}).image;
  TileFile file(checkpointOf(opened.job(), frame), identityOf(opened, frame, out.scene));
  const std::set<Place> kept = file.read(tiles, whole, image);
  if (!kept.empty() && !resume)
    throw Error(ErrorCode::kExists, file.path(), "",
                fmt::format("{} of {} tiles of this picture are finished; go on from them by --resume, or remove the "
                            "file to begin anew",
                            kept.size(), tiles.size()));
  if (!kept.empty()) progress.note(fmt::format("{} of {} tiles are finished already", kept.size(), tiles.size()));
  UncountedProgress of_tiles(progress);
  const std::unique_ptr<FramePainter> painter = opened.painterFor(out.scene, of_tiles);
  const std::string step = stepOfFrame(frame);
  std::uint64_t done = 0;
  for (const PixelRect& at : tiles) done += kept.contains(placeOf(at)) ? at.count() : 0;
  std::size_t finished = kept.size();
  try {
    progress.advance(step.c_str(), "pixels", done, whole.count());
    for (const PixelRect& at : tiles) {
      if (kept.contains(placeOf(at))) continue;
      const Image tile = painter->draw(at);
      file.add(at, tile);
      putTile(tile, at, whole, image);
      ++finished;
      progress.advance(step.c_str(), "pixels", done += at.count(), whole.count());
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCancelled || finished == 0) throw;
    throw Error(error.code(),
                fmt::format("{}; {} of {} tiles are kept in {}, and the same command with --resume goes on",
                            error.what(), finished, tiles.size(), file.path().string()));
  }
  out.statistics = opened.finish(*painter, frame);
  out.continued = !kept.empty();
  return out;
}

}  // namespace kiln
