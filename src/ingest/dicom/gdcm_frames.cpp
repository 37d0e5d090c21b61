// GDCM decodes what it knows: run lengths, JPEG in all its kinds, JPEG-LS, JPEG 2000. It is shown an image in memory
// that is made of the frame's fragments alone; files it does not see. What cannot be checked here is inside the
// fragments: a frame that was altered there on purpose can end the process, one altered by accident can be read with
// wrong values. A module of its own: loading GDCM and its dictionaries takes a quarter of the time that the program
// needs to start.
#include "ingest/dicom/gdcm_frames.h"

#include <gdcmFragment.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>

#include <exception>

namespace kiln {
namespace {

bool decode(const DicomPixels& pixels, const std::vector<std::vector<char>>& fragments, std::vector<std::byte>& out) {
  // GDCM's messages go to the process's standard error unless they are turned off.
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
