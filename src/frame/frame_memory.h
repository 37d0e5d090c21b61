// The account of a frame: all memory that grows with the picture or the store is charged to the user's number; bricks
// get the rest.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "frame/render_frame.h"
#include "job/render_job.h"
#include "store/bricked_volume.h"

namespace kiln {

/// unit: bytes.
struct FrameMemory {
  std::uint64_t image = 0;       // RGBA in floats and planes of the drawn pixels
  std::uint64_t band = 0;        // the rows of samples drawn at a time; 0 if a pixel is one sample
  std::uint64_t face = 0;        // one face of a panorama
  std::uint64_t deep = 0;        // samples of a deep image, up to the user's bound per pixel
  std::uint64_t shadows = 0;     // shadow maps and ambient occlusion, with the memory for drawing them
  std::uint64_t visibility = 0;  // the structure of the visibility method
  std::uint64_t index = 0;       // the indices of the stores, and the frame's octree above bricks
  std::uint64_t slabs = 0;       // scratch of each thread: cells, sums of several volumes; a tile of voxels
  std::uint64_t files = 0;       // compressing the picture's files, with as many threads as a share of the rest allows
  std::uint64_t threads = 0;     // stacks of threads and memory that libraries keep per thread
  std::uint64_t trace = 0;       // the trace, if requested
  std::uint64_t functions = 0;   // transfer functions, charged by the caller, who has resolved them
  std::uint64_t behind =
      0;  // the previous frame of a sequence, whose files are being written, out of the remaining memory
  std::uint64_t shared = 0;  // brick files exchanged by ranks; a share of the rest
  std::uint64_t brick = 0;   // the largest brick; with several volumes, all bricks that meet in a tile

  bool several = false;  // volumes

  std::uint64_t least_slabs = 0;              // with one brick at a time
  std::uint64_t least_band = 0;               // with the lowest band
  std::uint64_t least_files = 0;              // with one thread
  int bricks_together = kMostBricksTogether;  // bricks drawn at a time, as many as the remaining memory allows
  int band_px = 64;  // height of the band: at most a quarter of the budget, and bricks get no less

  std::uint64_t besideBricks() const {
    return framebuffer() + visibility + index + slabs + files + threads + trace + functions + shared;
  }
  /// Memory that grows with the drawn pixels.
  std::uint64_t framebuffer() const { return image + face + band + deep + shadows + behind; }
  /// Describes `brick` for a sentence that begins with its bytes.
  const char* brickText() const { return several ? "of bricks that meet in a tile" : "to read one brick"; }
  /// The least budget that draws the frame.
  std::uint64_t smallest() const {
    return besideBricks() - shared - behind - slabs + least_slabs - band + least_band - files + least_files + brick;
  }
};

/// The planes of annotations in a picture for an EXR. unit: bytes.
inline constexpr std::uint64_t kAnnotationPixelBytes = 4 * sizeof(float);

/// Memory in use beside the drawing of a picture.
struct MemoryBeside {
  MemoryBeside(std::uint64_t b = 0) : bytes(b) {}
  std::uint64_t bytes = 0;  // charged with the image
  /// Set if the picture is drawn in pieces: the largest piece.
  std::optional<PixelRect> at_a_time;
};

/// `brick_bytes`: the least memory for bricks. `written`: the pixels of the files, if more than the drawn pixels.
FrameMemory frameMemory(const std::vector<const BrickedVolume*>& stores, const RenderJob& job,
                        std::uint64_t brick_bytes, const std::optional<PixelRect>& written = {});
/// For one volume.
FrameMemory frameMemory(const BrickedVolume& store, const RenderJob& job);

/// Returns the memory for writing a frame's files while the next frame is drawn: pictures and files, if they take at
/// most a quarter of the bricks' memory; else 0. unit: bytes.
std::uint64_t writeBehindBytes(const FrameMemory& memory, const RenderJob& job);

/// Returns the part of `budget_bytes` for bricks. throws: Error kBudget naming the smallest sufficient budget and its
/// parts.
std::uint64_t cacheBytes(const FrameMemory& memory, std::uint64_t budget_bytes, const std::filesystem::path& store);

/// The share of `budget_bytes` for pages of evicted bricks that wait for the next brick (base/memory/large_pages.h);
/// cacheBytes does without. unit: bytes.
std::uint64_t sparePagesBytes(const FrameMemory& memory, std::uint64_t budget_bytes);

}  // namespace kiln
