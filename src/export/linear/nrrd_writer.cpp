// NRRD 4, attached. Keeps types, affine, frame and unit exactly. Source: teem.sourceforge.net/nrrd/format.html.
#include <fmt/format.h>

#include "export/linear/linear_writer.h"

namespace kiln {
namespace {

const char* nrrdTypeName(VoxelType type) {
  constexpr const char* kNames[] = {"uint8", "int8", "uint16", "int16", "uint32", "int32", "float", "double"};
  return kNames[static_cast<std::size_t>(type)];
}

// An unknown frame has directions in a space without a name.
const char* nrrdSpace(PatientFrame frame) {
  switch (frame) {
    case PatientFrame::kRas:
      return "space: right-anterior-superior\n";
    case PatientFrame::kLps:
      return "space: left-posterior-superior\n";
    case PatientFrame::kUnknown:
      break;
  }
  return "space dimension: 3\n";
}

std::string nrrdVector(const glm::dvec4& v) { return fmt::format("({},{},{})", v.x, v.y, v.z); }

std::string nrrdHeader(const ExportedVolume& volume, bool compressed) {
  const VolumeGeometry& geometry = volume.geometry;
  const glm::dmat4& affine = geometry.world_from_index;
  std::string out = fmt::format("NRRD0004\ntype: {}\ndimension: 3\n{}sizes: {} {} {}\n", nrrdTypeName(volume.type),
                                nrrdSpace(geometry.frame), geometry.dims.x, geometry.dims.y, geometry.dims.z);
  out += fmt::format("space directions: {} {} {}\nkinds: domain domain domain\n", nrrdVector(affine[0]),
                     nrrdVector(affine[1]), nrrdVector(affine[2]));
  if (sizeOf(volume.type) > 1) out += "endian: little\n";
  out += fmt::format("encoding: {}\n", compressed ? "gzip" : "raw");
  if (!geometry.unit.empty() && geometry.unit.find_first_of("\"\n\r") == std::string::npos)
    out += fmt::format("space units: \"{0}\" \"{0}\" \"{0}\"\n", geometry.unit);
  return out + fmt::format("space origin: {}\n\n", nrrdVector(affine[3]));
}

}  // namespace

std::unique_ptr<VolumeWriter> openNrrdWriter(const ExportTarget& target, const ExportedVolume& volume, ExportNotes&) {
  LinearLayout layout;
  const std::string header = nrrdHeader(volume, target.compress);
  layout.header.assign(bytesOf(header).begin(), bytesOf(header).end());
  layout.packing = target.compress ? Packing::kVoxels : Packing::kNone;
  return linearWriter(target, volume, std::move(layout));
}

}  // namespace kiln
