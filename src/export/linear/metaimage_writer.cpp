// MetaImage, in one file (.mha) or two (.mhd, .raw). The world is LPS, so an RAS volume is turned. Row i of
// TransformMatrix is the direction of axis i. Source: MetaIO's documentation (itk.org/Wiki/MetaIO) and itkMetaImageIO.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "export/linear/linear_writer.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

const char* metaTypeName(VoxelType type) {
  constexpr const char* kNames[] = {"MET_UCHAR", "MET_CHAR", "MET_USHORT", "MET_SHORT",
                                    "MET_UINT",  "MET_INT",  "MET_FLOAT",  "MET_DOUBLE"};
  return kNames[static_cast<std::size_t>(type)];
}

// Returns the number that times `factor` is `product`: the quotient, or a neighbour where the quotient was rounded.
double exactQuotient(double product, double factor) {
  const double quotient = product / factor;
  constexpr double kEnd = std::numeric_limits<double>::infinity();
  for (const double candidate : {quotient, std::nextafter(quotient, kEnd), std::nextafter(quotient, -kEnd)})
    if (candidate * factor == product) return candidate;
  return quotient;
}

// The side of the patient from which each axis comes, as MetaIO names orientations.
std::string orientationFrom(const glm::dmat4& lps_from_index) {
  constexpr const char* kSides[] = {"RL", "AP", "IS"};
  std::string out;
  for (int column = 0; column < 3; ++column) {
    const glm::dvec3 axis(lps_from_index[column]), size = glm::abs(axis);
    const int row = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    out += kSides[row][axis[row] < 0 ? 1 : 0];
  }
  return out;
}

std::string metaHeader(const ExportedVolume& volume, const std::string& data_file, ExportNotes& notes) {
  const VolumeGeometry geometry = withUnitOf({"mm", "um", "cm"}, volume.geometry, notes);
  const glm::dmat4 affine = affineIn(PatientFrame::kLps, geometry);
  const glm::dvec3 spacing = geometry.spacing();
  std::string matrix;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) matrix += fmt::format(" {}", exactQuotient(affine[column][row], spacing[column]));
  std::string out = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n";
  out += fmt::format("CompressedData = False\nTransformMatrix ={}\nOffset = {} {} {}\nCenterOfRotation = 0 0 0\n",
                     matrix, affine[3].x, affine[3].y, affine[3].z);
  if (geometry.frame != PatientFrame::kUnknown)
    out += fmt::format("AnatomicalOrientation = {}\n", orientationFrom(affine));
  if (!geometry.unit.empty()) out += fmt::format("DistanceUnits = {}\n", geometry.unit);
  out += fmt::format("ElementSpacing = {} {} {}\nDimSize = {} {} {}\n", spacing.x, spacing.y, spacing.z,
                     geometry.dims.x, geometry.dims.y, geometry.dims.z);
  return out + fmt::format("ElementType = {}\nElementDataFile = {}\n", metaTypeName(volume.type), data_file);
}

LinearLayout metaLayout(const ExportedVolume& volume, const std::string& data_file, ExportNotes& notes) {
  LinearLayout out;
  const std::string header = metaHeader(volume, data_file, notes);
  out.header.assign(bytesOf(header).begin(), bytesOf(header).end());
  return out;
}

}  // namespace

std::unique_ptr<VolumeWriter> openMetaImageWriter(const ExportTarget& target, const ExportedVolume& volume,
                                                  ExportNotes& notes) {
  return linearWriter(target, volume, metaLayout(volume, "LOCAL", notes));
}

std::unique_ptr<VolumeWriter> openMetaImagePairWriter(const ExportTarget& target, const ExportedVolume& volume,
                                                      ExportNotes& notes) {
  const std::filesystem::path voxels = std::filesystem::path(target.out).replace_extension(".raw");
  const std::string name = voxels.filename().string();
  if (trimmed(name) != name || name.find_first_of("%\r\n") != std::string::npos)
    throw Error(ErrorCode::kUsage, target.out, "",
                "a name with %, a line end or outer blanks cannot stand in a header; choose another, or write a .mha");
  LinearLayout layout = metaLayout(volume, name, notes);
  layout.voxels_file = voxels;
  layout.lines = {fmt::format("{}: holds the voxels, keep both files together", voxels.string())};
  return linearWriter(target, volume, std::move(layout));
}

}  // namespace kiln
