// Grey files of JPEG 2000 as slices of a volume: codestreams (.j2k), or codestreams in boxes (.jp2). Workers that run
// OpenJPEG decode them (tools/openjpeg_reader), one for each thread that decodes.
#pragma once

#include "base/worker_process.h"
#include "ingest/bytes/handle_pool.h"
#include "ingest/pictures/picture_slice.h"

namespace kiln {

/// As readPngHeader. cost: reads the headers of boxes and the first segment.
PictureHeader readJpeg2000Header(const std::filesystem::path& path);

/// thread: any.
class Jpeg2000Decoder {
 public:
  /// As decodePng. throws: Error also kUnsupported without the worker's program.
  std::vector<std::byte> decode(const std::filesystem::path& path, const PictureSlice& slice,
                                std::uint64_t limit_bytes);

  /// Memory of one decoding beside the file and the slice, of this process and of a worker. unit: bytes.
  static std::uint64_t decodeBytes(const PictureSlice& slice, std::uint64_t file_bytes);

 private:
  HandlePool<WorkerProcess> workers_;  // of slices of one size
};

}  // namespace kiln
