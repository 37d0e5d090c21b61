// One long frame, tile by tile: each tile that is finished is kept beside the picture, under a name that nothing takes
// for one, until the picture is there. A tile's pixels are the whole frame's bit for bit, so it does not matter which
// run drew it.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "base/hash.h"
#include "image/image_rows.h"
#include "image/pixel_rect.h"
#include "sequence/opened_job.h"

namespace kiln {

class FilePart;

/// The file of a frame's tiles: the name of its first file with ".tiles" added. requires: the job names a file.
std::filesystem::path checkpointOf(const RenderJob& job, int frame);

/// What drawing in tiles takes: one tile is drawn at a time, and the picture is written in bands of one row of tiles.
MemoryBeside checkpointMemory(const RenderJob& job);

/// throws: Error kUsage where a frame of this job is not kept in tiles: its pixels would depend on them, or on what
/// was damaged when they were drawn.
void requireCheckpoint(const RenderJob& job);

/// As OpenedJob::draw, but the picture is not in memory: `tiles` of the result refers to the file. Tile by tile, with
/// progress in pixels. Tiles that are kept of the same frame are taken where `resume` says so; what is kept of another
/// is replaced. The file stays for the caller to remove, when the frame's files are written. The statistics are of what
/// was drawn. throws: as OpenedJob::draw; of kCancelled it says how to go on; Error kExists where tiles of this frame
/// are kept and nobody resumes it, kNoSpace, kIo.
DrawnFrame drawInTiles(OpenedJob& opened, int frame, bool resume, Progress& progress);

/// The finished tiles of a frame in their file. shape: of the picture `whole`, whose tiles are checkpointTiles(whole).
struct FrameTiles {
  struct Record {
    PixelRect at;
    std::uint64_t offset = 0, bytes = 0;  // of the payload in the file
    Hash128 hash;
  };
  std::filesystem::path path;
  PixelRect whole;
  std::vector<Record> records;
};

/// What a file of the job's holds of a frame, read band by band from its tiles.
class TileRows : public ImageRows {
 public:
  /// requires: all tiles are finished; `tiles` outlives this.
  TileRows(const FrameTiles& tiles, const OutputFile& file, const Aovs& aovs);
  ~TileRows() override;
  /// throws: Error kDamaged where a tile's bytes are not those that were written, kIo.
  Band bandAt(int row) override;

 private:
  const FrameTiles& tiles_;
  const OutputFile& file_;
  const Aovs aovs_;
  int first_row_ = 0;
  Image band_;
  std::unique_ptr<FilePart> part_;
};

/// The tiles of a frame, which fill `pixels`, neighbours behind each other.
std::vector<PixelRect> checkpointTiles(const PixelRect& pixels);

}  // namespace kiln
