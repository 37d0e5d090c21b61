// MRC, CCP4 and MAP files of electron microscopy and crystallography, raw or in gzip: a volume, a stack of images, or
// one volume of a stack. The order of axes goes into the affine, so voxels stay in the order of the file.
#include "base/error.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/mrc/mrc_header.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

VolumeGeometry mrcGeometry(const MrcHeader& header, const std::filesystem::path& path, const SourceOptions& options) {
  VolumeGeometry out;
  out.dims = {header.dims.x, header.dims.y, header.sections_of_volume};
  std::array<glm::dvec3, 3> step = header.step;
  glm::dvec3 origin = header.origin;
  if (options.spacing) {
    if (!header.right_angles) refuseSpacing(path);
    step = {glm::dvec3(options.spacing->x, 0, 0), glm::dvec3(0, options.spacing->y, 0),
            glm::dvec3(0, 0, options.spacing->z)};
    origin = glm::dvec3(0);
  } else if (header.has_cell) {
    out.unit = "angstrom";
  }
  const auto along = [&](std::size_t axis) { return step[static_cast<std::size_t>(header.cell_axis[axis])]; };
  out.world_from_index = directionsAffine({along(0), along(1), along(2)}, origin);
  requireInvertible(out.world_from_index, path.string());
  return out;
}

}  // namespace

std::unique_ptr<VolumeSource> openMrc(const std::filesystem::path& input, const SourceOptions& options) {
  const MrcHeader header = readMrcHeader(input);
  SourceInfo info;
  info.type = header.type.voxel();
  info.notes = header.notes;
  info.geometry = mrcGeometry(header, input, options);
  if (!header.has_cell && !options.spacing)
    info.notes.push_back("it has no size of a voxel, which is taken to be 1 x 1 x 1; --spacing sets another");
  LinearData data;
  data.file = input;
  data.beginAt(header.end_offset, header.in_gzip);
  data.stored_type = header.type;
  data.big_endian = header.big_endian;
  data.parts = header.dims.z / header.sections_of_volume;
  data.part = chosenTime(options, data.parts, input);
  info.format = "MRC" + partOf("time", data.part, data.parts);
  return openDescribed(input, std::move(info), data);
}

}  // namespace kiln
