// Decodes compressed frames of DICOM files, in workers that run GDCM (tools/gdcm_reader), one for each thread that
// decodes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/worker_process.h"
#include "ingest/bytes/handle_pool.h"
#include "ingest/dicom/dicom_header.h"

namespace kiln {

/// thread: any.
class DicomDecoder {
 public:
  /// Returns the stored values of a frame, x fastest, in the machine's byte order. requires: pixels that are packed.
  /// throws: Error kFormat if the frame cannot be decoded, kIo, kUnsupported without the worker's program.
  std::vector<std::byte> frame(const DicomHeader& header, std::int64_t index);

  /// Memory of one decoding, of this process and of a worker. unit: bytes.
  static std::uint64_t decodeBytes(const DicomPixels& pixels);

 private:
  HandlePool<WorkerProcess> workers_;  // by the bytes of their frames
};

}  // namespace kiln
