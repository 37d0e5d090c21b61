// A worker (base/worker_loop.h) that decodes compressed frames of DICOM: gdcm_reader MEMORY_BYTES SECONDS. GDCM decodes
// run lengths, JPEG of all kinds, JPEG-LS and JPEG 2000, with OpenJPEG and CharLS. GDCM gets an image in memory made of
// the fragments of one frame, never a file. A frame damaged by accident can decode to wrong values.
#include <gdcmFragment.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>

#include <cstring>
#include <exception>
#include <string>

#include "base/worker_loop.h"
#include "ingest/dicom/gdcm_protocol.h"

namespace {

using kiln::GdcmFrameHead;
using kiln::WorkerRefusal;

/// The parts of a request.
class Payload {
 public:
  explicit Payload(const std::string& bytes) : bytes_(bytes) {}
  const char* take(std::uint64_t count) {
    if (count > bytes_.size() - at_) throw WorkerRefusal("a request that is cut short");
    const char* const out = bytes_.data() + at_;
    at_ += count;
    return out;
  }
  template <class T>
  T take() {
    T out;
    std::memcpy(&out, take(sizeof out), sizeof out);
    return out;
  }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

gdcm::DataElement pixelsOf(Payload sizes, Payload bytes, std::uint32_t count) {
  const auto sequence = gdcm::SequenceOfFragments::New();
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto size = sizes.take<std::uint64_t>();
    gdcm::Fragment fragment;
    fragment.SetByteValue(bytes.take(size), static_cast<std::uint32_t>(size));
    sequence->AddFragment(fragment);
  }
  gdcm::DataElement out(gdcm::Tag(0x7fe0, 0x0010));
  out.SetVR(gdcm::VR::OB);
  out.SetValue(*sequence);
  return out;
}

std::string decode(const std::string& request) {
  Payload sizes(request);
  const auto head = sizes.take<GdcmFrameHead>();
  Payload bytes = sizes;
  bytes.take(head.fragments * sizeof(std::uint64_t));
  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, head.columns);
  image.SetDimension(1, head.rows);
  image.SetPixelFormat(
      gdcm::PixelFormat(1, head.bits_allocated, head.bits_stored, head.high_bit, head.is_signed != 0 ? 1 : 0));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(head.transfer_syntax));
  image.SetDataElement(pixelsOf(sizes, bytes, head.fragments));
  std::string why, out;
  try {
    if (image.GetBufferLength() == head.frame_bytes) {
      out.resize(head.frame_bytes);
      if (image.GetBuffer(out.data())) return out;
    }
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    why = std::string(" (\"") + error.what() + "\")";
  }
  throw WorkerRefusal("the pixels cannot be decoded" + why + "; the file is damaged");
}

}  // namespace

int main(int count, char** arguments) {
  const kiln::WorkerArguments limits = kiln::startWorker(count, arguments);
  // Messages of GDCM go to standard error by default.
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  kiln::serveRequests(limits, [](std::uint32_t, const std::string& payload) { return decode(payload); });
}
