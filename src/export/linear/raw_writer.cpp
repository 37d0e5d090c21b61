// Voxels without a header. The command that reads the file again holds all that the file does not.
#include <fmt/format.h>

#include "base/shell_text.h"
#include "export/linear/linear_writer.h"

namespace kiln {
namespace {

std::string commandToRead(const std::filesystem::path& file, const ExportedVolume& volume) {
  const Extent3& dims = volume.geometry.dims;
  const glm::dvec3 spacing = volume.geometry.spacing();
  const std::string name = shellText(file.string());
  return fmt::format("kiln convert {0} {0}.kiln --dims {1},{2},{3} --type {4} --endian little --spacing {5},{6},{7}",
                     name, dims.x, dims.y, dims.z, nameOf(volume.type), spacing.x, spacing.y, spacing.z);
}

}  // namespace

std::unique_ptr<VolumeWriter> openRawWriter(const ExportTarget& target, const ExportedVolume& volume,
                                            ExportNotes& notes) {
  const VolumeGeometry& geometry = volume.geometry;
  if (!isPlacedBySpacing(geometry) || geometry.frame != PatientFrame::kUnknown || !geometry.unit.empty())
    notes.push_back("a raw file has no origin, directions, patient frame and unit");
  LinearLayout layout;
  layout.lines = {"to read it: " + commandToRead(target.out, volume)};
  return linearWriter(target, volume, std::move(layout));
}

}  // namespace kiln
