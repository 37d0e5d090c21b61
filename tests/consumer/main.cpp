// An external program: makes a volume file, converts and draws it, and draws equal voxels from memory.
#include <kiln/base/module.h>
#include <kiln/convert/convert.h>
#include <kiln/convert/open_array.h>
#include <kiln/ingest/open_source.h>
#include <kiln/sequence/render_job_run.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string picture = argv[1];
  const std::string raw = picture + ".raw";
  const std::string voxels = std::string(16 * 16 * 8, '\0') + std::string(16 * 16 * 8, '\xff');
  std::ofstream(raw, std::ios::binary) << voxels;
  kiln::SourceOptions options;
  options.dims = kiln::Extent3{16, 16, 16};
  options.type = kiln::VoxelType::u8;
  kiln::Progress silent;
  kiln::ConvertOptions conversion;
  conversion.overwrite = true;
  kiln::convert(*kiln::openSource(raw, options), raw + ".kiln", conversion, silent);
  kiln::programBesideModules("kiln_gdcm_reader", "an installed worker is not found");  // or throws
  kiln::RenderJob job;
  job.volume = raw + ".kiln";
  job.picture.size = {64, 64};
  job.output.path = picture;
  const kiln::RenderResult result = kiln::runRenderJob(job, 1, silent);
  std::printf("%s: alpha in the middle %.3f\n", picture.c_str(), static_cast<double>(result.image.pixel(32, 32)[3]));
  kiln::VoxelArray array;
  array.voxels = voxels.data();
  array.geometry.dims = {16, 16, 16};
  const auto volume = kiln::openArray(array, {}, silent);
  const kiln::BrickedVolume* const volumes[] = {volume.get()};
  const kiln::Image same = kiln::runRenderJob(job, volumes, silent).image;
  if (!std::equal(same.rgba.begin(), same.rgba.end(), result.image.rgba.begin(), result.image.rgba.end())) return 1;
  return result.image.pixel(32, 32)[3] > 0.5f ? 0 : 1;
}
