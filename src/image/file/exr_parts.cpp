#include "image/file/exr_parts.h"

#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>

#include <algorithm>
#include <cstring>
#include <map>

namespace kiln {
namespace {

// Imath multiplies row vectors (v·M), glm column vectors (M·v), so the equivalent matrix is the transpose. glm's [i] is
// a column and Imath's [i] a row, so the indices stay.
Imath::M44f imathOf(const glm::dmat4& m) {
  Imath::M44f out;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) out[i][j] = static_cast<float>(m[i][j]);
  }
  return out;
}

}  // namespace

void ExrWriter::write(const char data[], int count) {
  const auto size = static_cast<std::size_t>(count);
  if (place_ + size > bytes_.size()) bytes_.resize(place_ + size);
  std::memcpy(bytes_.data() + place_, data, size);
  place_ += size;
}

void ExrScratchWriter::write(const char data[], int count) {
  const auto bytes = std::as_bytes(std::span(data, static_cast<std::size_t>(count)));
  try {
    out_.write(place_, bytes);
  } catch (...) {
    if (!failure_) failure_ = std::current_exception();
    throw;
  }
  place_ += bytes.size();
}

Imf::Compression exrCompression(const std::string& name) {
  static const std::map<std::string, Imf::Compression> kCompressions = {
      {"none", Imf::NO_COMPRESSION},   {"rle", Imf::RLE_COMPRESSION}, {"zips", Imf::ZIPS_COMPRESSION},
      {"zip", Imf::ZIP_COMPRESSION},   {"piz", Imf::PIZ_COMPRESSION}, {"dwaa", Imf::DWAA_COMPRESSION},
      {"dwab", Imf::DWAB_COMPRESSION},
  };
  const auto found = kCompressions.find(name);
  if (found != kCompressions.end()) return found->second;
  throw Error(ErrorCode::kUsage, "'" + name + "' is no OpenEXR compression that Kiln writes");
}

int compressingThreads(int wanted) {
  if (Imf::globalThreadCount() < wanted) Imf::setGlobalThreadCount(wanted);
  return wanted;
}

Imf::Header exrHeader(int width, int height, const ImageMetadata& metadata, Imf::Compression compression) {
  const ImageMetadata::Whole whole = metadata.whole.value_or(ImageMetadata::Whole{0, 0, width, height});
  Imf::Header header(whole.width, whole.height);
  header.dataWindow() = {{whole.x, whole.y}, {whole.x + width - 1, whole.y + height - 1}};
  header.compression() = compression;
  if (metadata.world_to_camera) Imf::addWorldToCamera(header, imathOf(*metadata.world_to_camera));
  if (metadata.world_to_ndc) Imf::addWorldToNDC(header, imathOf(*metadata.world_to_ndc));
  if (metadata.panorama) Imf::addEnvmap(header, Imf::ENVMAP_LATLONG);
  for (const auto& [name, text] : metadata.text) header.insert(name, Imf::StringAttribute(text));
  return header;
}

}  // namespace kiln
