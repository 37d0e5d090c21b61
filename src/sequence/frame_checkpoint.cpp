// The file consists of records (base/file/record_file.h). The first record holds the hashes of the frame's files, each
// later record one tile (sequence/tile_image.h). A tile of equal pixels, such as background, is stored as one pixel, so
// that the empty part of a poster takes no disk.
#include "sequence/frame_checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "annotate/annotator.h"
#include "base/byte_record.h"
#include "base/file/file.h"
#include "base/file/path_status.h"
#include "base/file/record_file.h"
#include "base/hash.h"
#include "frame/pass/aov_planes.h"
#include "frame/pass/frame_progress.h"
#include "job/job_facts.h"
#include "sequence/file_part.h"
#include "sequence/frame_files.h"
#include "sequence/tile_image.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr RecordMagic kCheckpointMagic = {'K', 'I', 'L', 'N', 'T', 'I', 'L', '3'};
// Edge of a tile: a multiple of the occlusion structure's blocks. unit: pixels.
constexpr int kEdge = 512;

using Place = std::tuple<int, int, int, int>;
Place placeOf(const PixelRect& at) { return {at.x0, at.y0, at.x1, at.y1}; }

template <class Values>
bool repeats(const Values& values, std::size_t pixels) {
  const std::size_t bytes = sizeof(float) * (values.size() / pixels);
  const auto* const first = reinterpret_cast<const char*>(values.data());
  // True if each pixel equals its predecessor.
  return pixels < 2 || std::memcmp(first, first + bytes, bytes * (pixels - 1)) == 0;
}

// Returns one pixel if all pixels are equal bit for bit.
std::optional<Image> onePixelOf(const Image& tile) {
  const std::size_t pixels = static_cast<std::size_t>(tile.width) * static_cast<std::size_t>(tile.height);
  const bool flat =
      repeats(tile.rgba, pixels) && std::all_of(tile.planes.begin(), tile.planes.end(),
                                                [&](const Plane& plane) { return repeats(plane.values, pixels); });
  if (!flat) return std::nullopt;
  Image out(1, 1);
  std::copy_n(tile.rgba.begin(), 4, out.rgba.begin());
  for (const Plane& plane : tile.planes) out.planes.push_back({plane.name, ZeroPages<float>(1, plane.values[0])});
  return out;
}

Image filledWith(const Image& pixel, const PixelRect& at) {
  Image out(at.width(), at.height());
  for (std::size_t i = 0; i < out.rgba.size(); ++i) out.rgba[i] = pixel.rgba[i % 4];
  for (const Plane& plane : pixel.planes)
    out.planes.push_back({plane.name, ZeroPages<float>(at.count(), plane.values[0])});
  return out;
}

enum class Stored : std::uint8_t { kPixels, kOnePixel };

// The time that a tile took; the plan of its run counts for the run's first tile.
struct TileTime {
  double wall_s = 0;
  BusyTimes busy;

  void add(const TileTime& other) {
    wall_s += other.wall_s;
    busy.add(other.busy);
  }
};

std::vector<std::byte> recordOf(const PixelRect& at, const Image& tile, const TileTime& time) {
  std::vector<std::byte> out;
  const std::optional<Image> pixel = onePixelOf(tile);
  appendValue(out, at);
  appendValue(out, time);
  appendValue(out, pixel ? Stored::kOnePixel : Stored::kPixels);
  appendTile(out, at, pixel ? *pixel : tile);
  return out;
}

struct PlacedTile {
  PixelRect at;
  TileTime time;
  Image image;
};

// Returns nothing if the bytes are no tile.
std::optional<PlacedTile> tileFrom(std::span<const std::byte> payload) {
  ByteTaker taker{payload};
  const auto at = taker.take<PixelRect>();
  const auto time = taker.take<TileTime>();
  const auto stored = taker.take<Stored>();
  if (!taker.ok || !(taker.take<PixelRect>() == at) || at.width() < 1 || at.height() < 1 || at.width() > kEdge ||
      at.height() > kEdge)
    return std::nullopt;
  std::optional<Image> image = takeTile(taker, stored == Stored::kOnePixel ? PixelRect{0, 0, 1, 1} : at);
  if (!image) return std::nullopt;
  return PlacedTile{at, time, stored == Stored::kOnePixel ? filledWith(*image, at) : *std::move(image)};
}

class TileFile {
 public:
  TileFile(FrameTiles& tiles, std::string identity)
      : path_(tiles.path), identity_(std::move(identity)), records_(tiles.records) {}

  // Finds the finished tiles. throws: Error kExists for the file of another picture, or of none.
  std::set<Place> read(const std::vector<PixelRect>& tiles) {
    std::set<Place> known, found;
    for (const PixelRect& tile : tiles) known.insert(placeOf(tile));
    bool is_first = true, is_ours = false;
    end_ = kCheckpointMagic.size();
    const std::optional<std::uint64_t> bytes =
        readRecords(path_, kCheckpointMagic, [&](std::span<const std::byte> payload) {
          const std::uint64_t offset = end_ + kRecordHead;
          if (std::exchange(is_first, false)) {
            ByteTaker taker{payload};
            end_ = offset + payload.size();
            return is_ours = taker.takeText() == identity_;
          }
          const std::optional<PlacedTile> tile = tileFrom(payload);
          if (!tile || !known.contains(placeOf(tile->at))) return false;
          if (found.insert(placeOf(tile->at)).second) {
            records_.push_back({tile->at, offset, payload.size(), hashOf(payload)});
            time_.add(tile->time);
          }
          end_ = offset + payload.size();
          return true;
        });
    begun_ = bytes && is_ours;
    if (!begun_ && isThere(path_))
      throw Error(ErrorCode::kExists, path_, "",
                  fmt::format("{}; name another picture, or remove the file",
                              bytes && !is_first ? "has tiles of another picture, or of another volume"
                                                 : "is where tiles would be kept, and has none"));
    // Cuts off a torn record, so that the next record is readable.
    std::error_code failed;
    if (begun_) fs::resize_file(path_, *bytes, failed);
    if (failed) throw systemError(failed.value(), path_, "shortening");
    return found;
  }

  /// The time of the tiles that were read.
  const TileTime& time() const { return time_; }

  void add(const PixelRect& at, const Image& tile, const TileTime& time) {
    FileSystem& disk = FileSystem::real();
    if (!std::exchange(begun_, true)) {
      std::vector<std::byte> beginning = beginningOf(kCheckpointMagic), identity;
      appendText(identity, identity_);
      appendRecord(beginning, identity);
      disk.writeAtomic(path_, beginning);
      end_ = beginning.size();
    }
    std::vector<std::byte> record;
    const std::vector<std::byte> payload = recordOf(at, tile, time);
    appendRecord(record, payload);
    disk.appendFile(path_, record);
    records_.push_back({at, end_ + kRecordHead, payload.size(), hashOf(payload)});
    end_ += record.size();
  }

 private:
  static constexpr std::uint64_t kRecordHead = sizeof(std::uint32_t) + sizeof(Hash128);
  const fs::path path_;
  const std::string identity_;
  std::vector<FrameTiles::Record>& records_;
  TileTime time_;
  bool begun_ = false;
  std::uint64_t end_ = 0;  // offset of the next record in the file. unit: bytes
};

std::string identityOf(const OpenedJob& opened, int frame, const FrameScene& scene) {
  std::string out;
  for (const OutputFile& file : filesOf(opened.job(), frame))
    out += contentHash(opened.job(), file, scene, opened.firstVolume().manifest()) + "\n";
  return out;
}

}  // namespace

fs::path checkpointOf(const RenderJob& job, int frame) { return filesOf(job, frame).front().path.string() + ".tiles"; }

MemoryBeside checkpointMemory(const RenderJob& job) {
  const PixelRect whole = drawnPixels(job.picture.size, job.picture.crop);
  const std::uint64_t of_pixel = 16 + aovBytes(drawnAovs(job));
  const std::uint64_t of_annotations = job.picture.annotations.any() ? kAnnotationPixelBytes : 0;
  // A tile, its record (twice while the record is assembled), and a band of rows.
  MemoryBeside out = of_pixel * 3 * std::uint64_t{kEdge} * kEdge +
                     (of_pixel + of_annotations) * static_cast<std::uint64_t>(whole.width()) *
                         static_cast<std::uint64_t>(std::min(kEdge, whole.height()));
  for (const PixelRect& tile : checkpointTiles(whole))
    if (!out.at_a_time || tile.count() > out.at_a_time->count()) out.at_a_time = tile;
  return out;
}

TileRows::TileRows(const FrameTiles& tiles, const OutputFile& file, const Aovs& aovs, const Finish& finish,
                   const Annotator* annotator)
    : ImageRows(tiles.whole.width(), tiles.whole.height()),
      tiles_(tiles),
      file_(file),
      aovs_(aovs),
      finish_(finish),
      annotator_(annotator) {}

TileRows::~TileRows() = default;

ImageRows::Band TileRows::bandAt(int row) {
  if (part_ && row >= first_row_ && row < first_row_ + band_.height) return {&part_->image(), first_row_};
  part_.reset();
  band_ = {};
  const int y = tiles_.whole.y0 + row;
  PixelRect rect = tiles_.whole;
  rect.y0 = std::max(rect.y0, y / kEdge * kEdge);
  rect.y1 = std::min(rect.y1, (y / kEdge + 1) * kEdge);
  band_ = Image(rect.width(), rect.height());
  const File file(tiles_.path);
  for (const FrameTiles::Record& record : tiles_.records) {
    if (record.at.y0 != rect.y0) continue;
    std::vector<std::byte> payload(record.bytes);
    file.readAt(record.offset, payload);
    const std::optional<PlacedTile> tile =
        hashOf(payload) == record.hash ? tileFrom(payload) : std::optional<PlacedTile>();
    if (!tile)
      throw Error(ErrorCode::kDamaged, tiles_.path, fmt::format("byte {}", record.offset),
                  "a finished tile is not what was written; run the same command with --resume");
    putTile(tile->image, tile->at, rect, band_);
  }
  const Medium medium = mediumOf(file_.path);
  finishPicture(band_, rect.y0, finish_, medium);
  if (annotator_ != nullptr && medium == Medium::kDisplay) annotator_->over(band_, 0, rect.y0, depthOf(band_));
  if (annotator_ != nullptr && medium == Medium::kLight) annotator_->addPlanes(band_, rect.y0, depthOf(band_));
  first_row_ = rect.y0 - tiles_.whole.y0;
  part_ = std::make_unique<FilePart>(band_, file_, aovs_);
  return {&part_->image(), first_row_};
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
  out.views.push_back({Image(), request.view});
  out.tiles = std::make_shared<FrameTiles>(FrameTiles{checkpointOf(opened.job(), frame), whole, {}});
  TileFile file(*out.tiles, identityOf(opened, frame, out.scene));
  const std::set<Place> kept = file.read(tiles);
  if (!kept.empty() && !resume)
    throw Error(ErrorCode::kExists, out.tiles->path, "",
                fmt::format("{} of {} tiles of this picture are finished; go on from them by --resume, or remove the "
                            "file to begin anew",
                            kept.size(), tiles.size()));
  if (!kept.empty())
    progress.note(
        fmt::format("{}: {} of {} tiles are finished already", out.tiles->path.string(), kept.size(), tiles.size()));
  UncountedProgress of_tiles(progress);
  const std::unique_ptr<FramePainter> painter = opened.painterFor(out.scene, of_tiles);
  const std::string step = stepOfFrame(frame);
  std::uint64_t done = 0;
  for (const PixelRect& at : tiles) done += kept.contains(placeOf(at)) ? at.count() : 0;
  std::size_t finished = kept.size();
  TileTime before;
  try {
    progress.advance(step.c_str(), "pixels", done, whole.count());
    for (const PixelRect& at : tiles) {
      if (kept.contains(placeOf(at))) continue;
      const Image tile = painter->draw(at);
      const TileTime now{painter->wallSeconds(), painter->busy()};
      file.add(at, tile, {now.wall_s - before.wall_s, now.busy.since(before.busy)});
      before = now;
      ++finished;
      progress.advance(step.c_str(), "pixels", done += at.count(), whole.count());
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCancelled || finished == 0) throw;
    throw Error(error.code(),
                fmt::format("{}; {} of {} tiles are kept in {}, and the same command with --resume goes on",
                            error.what(), finished, tiles.size(), out.tiles->path.string()));
  }
  out.statistics = opened.finish(*painter, frame);
  out.statistics.wall_s += file.time().wall_s;
  out.statistics.busy.add(file.time().busy);
  out.continued = !kept.empty();
  return out;
}

}  // namespace kiln
