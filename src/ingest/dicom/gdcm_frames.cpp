// GDCM decodes run lengths, JPEG of all kinds, JPEG-LS and JPEG 2000. It gets an image in memory made of one frame's
// fragments, never a file. Damage inside the fragments cannot be checked here: a frame altered on purpose can end the
// process; a frame damaged by accident can decode to wrong values.
// A module of its own, because loading GDCM and its dictionaries takes a quarter of the program's start time.
#include "ingest/dicom/gdcm_frames.h"

#include <gdcmFragment.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>

#include <exception>

namespace kiln {
namespace {

bool decode(const DicomPixels& pixels, const std::vector<std::vector<char>>& fragments, std::vector<std::byte>& out) {
  // GDCM writes its messages to standard error unless they are turned off.
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  const auto sequence = gdcm::SequenceOfFragments::New();
  for (const std::vector<char>& bytes : fragments) {
    gdcm::Fragment fragment;
    fragment.SetByteValue(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    sequence->AddFragment(fragment);
  }
  gdcm::DataElement element(gdcm::Tag(0x7fe0, 0x0010));
  element.SetVR(gdcm::VR::OB);
  element.SetValue(*sequence);
  const auto bits = [](int n) { return static_cast<unsigned short>(n); };
  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, static_cast<unsigned>(pixels.columns));
  image.SetDimension(1, static_cast<unsigned>(pixels.rows));
  image.SetPixelFormat(gdcm::PixelFormat(1, bits(pixels.bits_allocated), bits(pixels.bits_stored),
                                         bits(pixels.high_bit), pixels.is_signed ? 1 : 0));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(pixels.transfer_syntax.c_str()));
  image.SetDataElement(element);
  return image.GetBufferLength() == out.size() && image.GetBuffer(reinterpret_cast<char*>(out.data()));
}

}  // namespace
}  // namespace kiln

extern "C" __attribute__((visibility("default"))) bool kilnDecodeByGdcm(const kiln::DicomPixels& pixels,
                                                                        const std::vector<std::vector<char>>& fragments,
                                                                        std::vector<std::byte>& out, std::string& why) {
  try {
    return kiln::decode(pixels, fragments, out);
  } catch (const std::exception& error) {
    why = error.what();
    return false;
  }
}
