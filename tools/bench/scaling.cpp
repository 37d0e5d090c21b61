#include "bench/scaling.h"

#include <algorithm>
#include <vector>

#include "sequence/render_job_run.h"

namespace kiln {

ScalingPoint measureScaling(const Suite& suite, const std::filesystem::path& store, Progress& progress) {
  RenderJob job;
  job.volume = store;
  job.picture.size = suite.scaling.size;
  job.picture.samples = 1;  // equal for volumes of any size
  job.picture.transfer_function = suite.scaling.transfer_function;
  job.picture.camera = suite.scaling.camera;
  job.speed.memory_bytes = suite.memory_bytes;
  job.speed.threads = suite.threads;
  const RenderStatistics drawn = runRenderJob(job, 1 + suite.scaling.repeat, progress).statistics;
  ScalingPoint out;
  out.first = drawn.frames.front();
  out.first_s = out.first.wall_s;
  std::vector<double> later;
  for (std::size_t i = 1; i < drawn.frames.size(); ++i) later.push_back(drawn.frames[i].wall_s);
  std::nth_element(later.begin(), later.begin() + static_cast<std::ptrdiff_t>(later.size() / 2), later.end());
  out.render_s = later[later.size() / 2];
  out.memory_bytes = drawn.peak_cache_bytes + drawn.framebuffer_bytes + drawn.visibility_bytes + drawn.index_bytes;
  return out;
}

}  // namespace kiln
