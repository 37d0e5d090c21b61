// Zarr, OME-Zarr and N5. Known because the test writes each header as text and each chunk byte by byte.
#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/volumes/foreign_files.h"

namespace kiln::test {
namespace {

// Known: the format of version 2 without a compressor: a chunk is its voxels, the last axis fastest.
TEST(IngestZarr, OneUncompressedChunkReadsBack) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 301);
  const auto folder = files.directory() / "a.zarr";
  std::filesystem::create_directory(folder);
  files.write("a.zarr/.zarray",
              R"({"zarr_format": 2, "shape": [3, 4, 5], "chunks": [3, 4, 5], "dtype": ">u2", "compressor": null,
                  "fill_value": 0, "order": "C", "filters": null})");
  files.write("a.zarr/0.0.0", volume.stored(true));
  expectReadsBack(volume, folder, 302);
}

}  // namespace
}  // namespace kiln::test
