// Problem: continue one long frame after an interrupt. Method: draw the frame tile by tile and keep finished tiles in a
// file beside the picture until the picture is written. Invariant: a tile's pixels equal the whole frame's bit for bit,
// so any run may draw any tile.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "base/hash.h"
#include "frame/background.h"
#include "image/image_rows.h"
#include "image/pixel_rect.h"
#include "sequence/opened_job.h"

namespace kiln {

class Annotator;
class FilePart;

/// Returns the file of a frame's tiles: the name of the frame's first file with ".tiles" added. requires: the job names
/// a file.
std::filesystem::path checkpointOf(const RenderJob& job, int frame);

/// Returns the memory for drawing in tiles: one tile at a time, and one row of tiles while the picture is written.
MemoryBeside checkpointMemory(const RenderJob& job);

/// throws: Error kUsage for a job whose frames cannot be kept in tiles, because pixels would depend on the tiles, or on
/// bricks that were damaged at the time of drawing.
void requireCheckpoint(const RenderJob& job);

/// Draws as OpenedJob::draw, tile by tile, with progress in pixels. The picture is not in memory: `tiles` of the result
/// refers to the file, and the caller removes the file after writing the frame's files. With `resume`, kept tiles of
/// the same frame are reused. Statistics cover the tiles drawn by the call.
/// throws: as OpenedJob::draw; kCancelled, with the way to resume; Error kExists if tiles of the frame exist and
/// `resume` is false, or if the tiles are another frame's; kNoSpace, kIo.
DrawnFrame drawInTiles(OpenedJob& opened, int frame, bool resume, Progress& progress);

/// The finished tiles of a frame in their file. shape: the tiles are checkpointTiles(whole).
struct FrameTiles {
  struct Record {
    PixelRect at;
    std::uint64_t offset = 0, bytes = 0;  // position of the payload in the file
    Hash128 hash;
  };
  std::filesystem::path path;
  PixelRect whole;
  std::vector<Record> records;
};

/// Reads the planes of one output file band by band from a frame's tiles.
class TileRows : public ImageRows {
 public:
  /// `annotator` may be null. requires: all tiles are finished; `tiles` and `annotator` outlive the object.
  TileRows(const FrameTiles& tiles, const OutputFile& file, const Aovs& aovs, const Finish& finish,
           const Annotator* annotator);
  ~TileRows() override;
  /// throws: Error kDamaged if a tile's bytes have changed since writing, kIo.
  Band bandAt(int row) override;

 private:
  const FrameTiles& tiles_;
  const OutputFile& file_;
  const Aovs aovs_;
  const Finish finish_;
  const Annotator* const annotator_;
  int first_row_ = 0;
  Image band_;
  std::unique_ptr<FilePart> part_;
};

/// Returns tiles that fill `pixels`; consecutive tiles are neighbours.
std::vector<PixelRect> checkpointTiles(const PixelRect& pixels);

}  // namespace kiln
