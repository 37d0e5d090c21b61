// NIfTI-1; NIfTI-2 for extents beyond 16 bits. The world is RAS, so an LPS volume is turned. A volume without a frame
// has an affine only where spacings alone do not place it. Sources: nifti1.h and nifti2.h, https://nifti.nimh.nih.gov.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "export/linear/linear_writer.h"

namespace kiln {
namespace {

constexpr std::int16_t kLabelIntent = 1002, kScannerWorld = 1, kAlignedWorld = 2;

std::int16_t niftiDatatype(VoxelType type) {
  constexpr std::int16_t kCodes[] = {2, 256, 512, 4, 768, 8, 16, 64};  // in the order of VoxelType
  return kCodes[static_cast<std::size_t>(type)];
}

std::uint8_t niftiUnit(const std::string& unit) { return unit == "m" ? 1 : unit == "mm" ? 2 : unit == "um" ? 3 : 0; }

struct NiftiPlace {
  glm::dmat4 ras_from_index{1.0};
  glm::dvec3 spacing{1};
  std::string unit;
  /// 0 without an affine.
  std::int16_t world_code = 0;
};

NiftiPlace niftiPlaceOf(const VolumeGeometry& given, ExportNotes& notes) {
  const VolumeGeometry geometry = withUnitOf({"mm", "um", "m"}, given, notes);
  NiftiPlace out;
  out.unit = geometry.unit;
  out.ras_from_index = affineIn(PatientFrame::kRas, geometry);
  out.spacing = geometry.spacing();
  const bool known = geometry.frame != PatientFrame::kUnknown;
  out.world_code = known ? kScannerWorld : isPlacedBySpacing(geometry) ? std::int16_t{0} : kAlignedWorld;
  if (out.world_code == kAlignedWorld)
    notes.push_back(
        "NIfTI has no affine without a patient frame; programs take the axes of the world as right, "
        "anterior and superior (RAS)");
  return out;
}

// Writes numbers at the offsets of the format's headers.
class HeaderPutter {
 public:
  explicit HeaderPutter(std::size_t bytes) : bytes_(bytes) {}
  template <class T>
  void put(std::size_t offset, T value) {
    std::memcpy(bytes_.data() + offset, &value, sizeof value);
  }
  void putText(std::size_t offset, std::string_view text) { std::memcpy(&bytes_[offset], text.data(), text.size()); }
  /// Puts the three rows of an affine.
  template <class T>
  void putRows(std::size_t offset, const glm::dmat4& affine) {
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        put(offset + static_cast<std::size_t>(4 * row + column) * sizeof(T), static_cast<T>(affine[column][row]));
  }
  /// Puts dim[] or pixdim[]: a first number, three for the axes, and four of further axes.
  template <class T, class Vector>
  void putAxes(std::size_t offset, T first, const Vector& axes) {
    const std::array<T, 8> all = {
        first, static_cast<T>(axes.x), static_cast<T>(axes.y), static_cast<T>(axes.z), 1, 1, 1, 1};
    std::memcpy(bytes_.data() + offset, all.data(), sizeof all);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

// The header, and four zeros: no extensions follow.
constexpr std::size_t kNifti1Bytes = 348 + 4, kNifti2Bytes = 540 + 4;

std::vector<std::byte> nifti1Header(const ExportedVolume& volume, const NiftiPlace& place) {
  HeaderPutter header(kNifti1Bytes);
  header.put<std::int32_t>(0, 348);
  header.putAxes<std::int16_t>(40, 3, volume.geometry.dims);
  if (volume.volume_class == VolumeClass::kLabels) header.put(68, kLabelIntent);
  header.put(70, niftiDatatype(volume.type));
  header.put(72, static_cast<std::int16_t>(8 * sizeOf(volume.type)));
  header.putAxes<float>(76, 1, place.spacing);
  header.put(108, static_cast<float>(kNifti1Bytes));
  header.put(112, 1.0f);  // scl_slope
  header.put(123, niftiUnit(place.unit));
  header.put(254, place.world_code);
  if (place.world_code > 0) header.putRows<float>(280, place.ras_from_index);
  header.putText(344, "n+1");
  return header.take();
}

std::vector<std::byte> nifti2Header(const ExportedVolume& volume, const NiftiPlace& place) {
  HeaderPutter header(kNifti2Bytes);
  header.put<std::int32_t>(0, 540);
  header.putText(4, {"n+2\0\r\n\032\n", 8});
  header.put(12, niftiDatatype(volume.type));
  header.put(14, static_cast<std::int16_t>(8 * sizeOf(volume.type)));
  header.putAxes<std::int64_t>(16, 3, volume.geometry.dims);
  header.putAxes<double>(104, 1, place.spacing);
  header.put(168, static_cast<std::int64_t>(kNifti2Bytes));
  header.put(176, 1.0);  // scl_slope
  header.put(348, static_cast<std::int32_t>(place.world_code));
  if (place.world_code > 0) header.putRows<double>(400, place.ras_from_index);
  header.put(500, static_cast<std::int32_t>(niftiUnit(place.unit)));
  if (volume.volume_class == VolumeClass::kLabels) header.put(504, static_cast<std::int32_t>(kLabelIntent));
  return header.take();
}

// The farthest that a corner of the volume moves where the affine is rounded to floats. unit: world.
double shiftInFloats(const ExportedVolume& volume, const NiftiPlace& place) {
  VolumeGeometry shift = volume.geometry;
  shift.world_from_index = glm::dmat4(glm::mat4(place.ras_from_index)) - place.ras_from_index;
  double most = 0;
  for (const glm::dvec3& corner : shift.corners()) most = std::max(most, glm::length(corner));
  return most;
}

// Returns whether the 32-bit floats of NIfTI-1 hold the lengths; NIfTI-2 has doubles.
bool fitsFloats(const glm::dvec3& lengths) {
  const double least = std::min({lengths.x, lengths.y, lengths.z}), most = std::max({lengths.x, lengths.y, lengths.z});
  return least >= std::numeric_limits<float>::min() && most <= std::numeric_limits<float>::max();
}

std::unique_ptr<VolumeWriter> niftiWriter(const ExportTarget& target, const ExportedVolume& volume, Packing packing,
                                          ExportNotes& notes) {
  const NiftiPlace place = niftiPlaceOf(volume.geometry, notes);
  const Extent3& dims = volume.geometry.dims;
  const bool fits =
      std::max({dims.x, dims.y, dims.z}) <= std::numeric_limits<std::int16_t>::max() && fitsFloats(place.spacing);
  const double shift = fits ? shiftInFloats(volume, place) : 0;
  if (shift > 0)
    notes.push_back(fmt::format("NIfTI-1 rounds positions to 32-bit floats, by at most {:.2g} {}", shift,
                                place.unit.empty() ? "units" : place.unit));
  LinearLayout layout;
  layout.header = fits ? nifti1Header(volume, place) : nifti2Header(volume, place);
  layout.packing = packing;
  return linearWriter(target, volume, std::move(layout));
}

}  // namespace

std::unique_ptr<VolumeWriter> openNiftiWriter(const ExportTarget& target, const ExportedVolume& volume,
                                              ExportNotes& notes) {
  return niftiWriter(target, volume, Packing::kNone, notes);
}

std::unique_ptr<VolumeWriter> openGzipNiftiWriter(const ExportTarget& target, const ExportedVolume& volume,
                                                  ExportNotes& notes) {
  return niftiWriter(target, volume, Packing::kAll, notes);
}

}  // namespace kiln
