// MGH and MGZ, the volumes of FreeSurfer: a big-endian header of 284 bytes, voxels x fastest, frame by frame, then
// optional parameters of the scan. The header gives directions and the world place of the middle voxel, in RAS.
// Source: surfer.nmr.mgh.harvard.edu/fswiki/FsTutorial/MghFormat.
#include <fmt/format.h>

#include <array>

#include "base/error.h"
#include "ingest/bytes/header_bytes.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

constexpr std::size_t kMghHeaderBytes = 284;
// Offsets of the fields. unit: bytes.
constexpr std::size_t kMghVersion = 0, kMghDims = 4, kMghFrames = 16, kMghType = 20, kHasDirections = 28,
                      kMghSpacing = 30, kMghDirections = 42, kCentre = 78;

VoxelType mghType(const HeaderBytes& bytes) {
  switch (const auto type = bytes.get<std::int32_t>(kMghType)) {
    case 0:
      return VoxelType::u8;
    case 1:
      return VoxelType::i32;
    case 3:
      return VoxelType::f32;
    case 4:
      return VoxelType::i16;
    case 10:
      return VoxelType::u16;
    case 2:
      bytes.refuse("holds long integers (type 2), whose size is unknown; save it as int");
    case 5:
      bytes.refuse("holds single bits (type 5), which Kiln does not read; save it as uchar");
    case 6:
      bytes.refuse("holds tensors (type 6), not one value a voxel");
    case 7:
    case 8:
      bytes.refuse(fmt::format("holds complex numbers (type {}); save the magnitude", type));
    case 9:
      bytes.refuse("holds RGB colours (type 9), not one value a voxel");
    default:
      bytes.fail("byte 20", fmt::format("type {} is not one of MGH's", type));
  }
}

std::int64_t countAt(const HeaderBytes& bytes, std::size_t at) {
  const auto count = bytes.get<std::int32_t>(at);
  if (count < 1) bytes.fail(fmt::format("byte {}", at), fmt::format("{} voxels or frames; 1 or more are legal", count));
  return count;
}

// A header without directions stands for coronal slices of 1 mm around the origin. Source: MGHread of FreeSurfer.
VolumeGeometry mghGeometry(const HeaderBytes& bytes, const SourceOptions& options, std::vector<std::string>& notes) {
  VolumeGeometry out;
  out.dims = {countAt(bytes, kMghDims), countAt(bytes, kMghDims + 4), countAt(bytes, kMghDims + 8)};
  out.frame = PatientFrame::kRas;
  out.unit = "mm";
  std::array<glm::dvec3, 3> step = {glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, -1), glm::dvec3(0, 1, 0)};
  glm::dvec3 centre(0), spacing(1);
  if (bytes.get<std::int16_t>(kHasDirections) == 1) {
    if (options.spacing) refuseSpacing(bytes.path());
    spacing = bytes.vector(kMghSpacing);
    for (std::size_t axis = 0; axis < 3; ++axis) step[axis] = bytes.vector(kMghDirections + 12 * axis);
    centre = bytes.vector(kCentre);
  } else {
    notes.push_back("it has no directions and sizes of voxels; coronal slices of 1 mm are taken");
    spacing = options.spacing.value_or(spacing);
  }
  for (int axis = 0; axis < 3; ++axis) step[static_cast<std::size_t>(axis)] *= spacing[axis];
  glm::dvec3 origin = centre;
  for (int axis = 0; axis < 3; ++axis)
    origin -= static_cast<double>(out.dims[axis]) / 2 * step[static_cast<std::size_t>(axis)];
  out.world_from_index = directionsAffine(step, origin);
  requireInvertible(out.world_from_index, bytes.path().string());
  return out;
}

}  // namespace

std::unique_ptr<VolumeSource> openMgh(const std::filesystem::path& input, const SourceOptions& options) {
  HeaderBytes bytes = readHeaderBytes(input, kMghHeaderBytes);
  bytes.setBigEndian(true);
  if (const auto version = bytes.get<std::int32_t>(kMghVersion); version != 1)
    bytes.fail("byte 0", fmt::format("the version is {}, not 1; not an MGH file", version));
  SourceInfo info;
  info.type = mghType(bytes);
  info.geometry = mghGeometry(bytes, options, info.notes);
  LinearData data;
  data.file = input;
  data.beginAt(kMghHeaderBytes, bytes.inGzip());
  data.stored_type = info.type;
  data.big_endian = true;
  data.has_trailer = true;
  data.parts = countAt(bytes, kMghFrames);
  data.part = chosenTime(options, data.parts, input);
  info.format = "MGH" + partOf("time", data.part, data.parts);
  return openDescribed(input, std::move(info), data);
}

}  // namespace kiln
