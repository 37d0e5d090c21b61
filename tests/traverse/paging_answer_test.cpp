// Bricks are read only where the picture needs them. The first frame reads little more than it draws, and the next
// frame of a slow rotation reads almost nothing.
#include <gtest/gtest.h>

#include "convert/convert.h"
#include "frame/render_frame.h"
#include "ingest/open_source.h"
#include "sequence/frame_requests.h"
#include "sequence/render_job_run.h"
#include "store/store_reader.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// Known because a cache that holds the whole volume reads no brick twice, so the second frame reads only bricks not
// read by the first. The skin of a head hides most bricks, and a degree moves the outline by a hundredth of the radius.
TEST(Paging, AFrameReadsWhatItDraws) {
  const auto head = openSource("phantom:head:256x256x256", {});
  const std::filesystem::path path = freshDirectory("paging") / "head.kiln";
  ConvertOptions options;
  options.brick_size = 64;  // in smaller bricks the apron has more voxels than the core
  Progress progress;
  convert(*head, path, options, progress);
  const StoreReader store(path);
  for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
    RenderJob job;
    job.picture.size = {256, 256};
    job.picture.transfer_function = std::string("ct-skin");
    job.picture.camera.projection = projection;
    BrickCache cache(store, std::uint64_t{1} << 30);
    std::vector<FrameStatistics> frames(2);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      job.picture.camera.azimuth_deg = 20 + static_cast<double>(i);
      const FrameRequest request =
          frameRequest(job.picture, job.speed, cameraFor(job.picture, store), transferFunctionFor(job.picture, store));
      renderFrame(cache, request, progress, frames[i]);
    }
    EXPECT_GT(frames[0].bricks_contributing, 20u);
    EXPECT_GT(frames[0].bricks_hidden, 2u);
    EXPECT_GE(frames[0].bricks_read, frames[0].bricks_contributing);
    // A third of these small bricks contributes nothing: rays could reach them only through skin beside open pixels.
    EXPECT_LE(static_cast<double>(frames[0].bricks_read_bytes),
              1.7 * static_cast<double>(frames[0].bricks_contributing_bytes));
    EXPECT_LT(10 * frames[1].bricks_read_bytes, frames[0].bricks_read_bytes);
  }
}

}  // namespace
}  // namespace kiln::test
