#include "support/reference/reference_labels.h"

#include <algorithm>

#include "scene/transfer/label_styles.h"

namespace kiln::test {
namespace {

// Returns the volume of `of` applied to each voxel's label.
template <class Of>
DenseVolume voxelByVoxel(const DenseVolume& volume, const Of& of) {
  return fill({volume.geometry.dims, VoxelType::f64, volume.geometry.world_from_index},
              [&](auto x, auto y, auto z) { return of(volume.valueAt(x, y, z)); });
}

// (1/4, 1/2, 1/4) along each axis, so many times.
DenseVolume smoothed(DenseVolume volume, int times) {
  for (int i = 0; i < 3 * times; ++i) {
    const DenseVolume before = volume;
    const std::int64_t dx = i % 3 == 0, dy = i % 3 == 1, dz = i % 3 == 2;
    volume = fill({before.geometry.dims, before.type, before.geometry.world_from_index}, [&](auto x, auto y, auto z) {
      return (before.valueAt(x - dx, y - dy, z - dz) + 2 * before.valueAt(x, y, z) +
              before.valueAt(x + dx, y + dy, z + dz)) /
             4;
    });
  }
  return volume;
}

}  // namespace

ReferenceLabels::ReferenceLabels(const DenseVolume& volume, const TransferFunction& function,
                                 Interpolation interpolation, int smoothing)
    : opacity_(smoothed(voxelByVoxel(volume, [&](double label) { return function.at(label).opacity; }), smoothing),
               Interpolation::kCubic) {
  for (const LabelStyle& look : function.labels) {
    if (!(look.opacity > 0)) continue;
    const DenseVolume is = voxelByVoxel(volume, [&](double label) { return label == look.label ? 1.0 : 0.0; });
    labels_.push_back({{look.color, look.opacity}, ReferenceField(is, interpolation)});
  }
}

ReferenceLabels::There ReferenceLabels::at(const glm::dvec3& index) const {
  There out{{glm::dvec3(0), 0}, 0};
  double shown = 0, most = 0;
  for (const Label& label : labels_) {
    const double share = label.share.at(index);
    shown += share;
    if (share > most) most = share, out.look = label.look;
  }
  out.solid = std::clamp(0.5 + static_cast<double>(kLabelRise) * (shown - 0.5), 0.0, 1.0);
  return out;
}

}  // namespace kiln::test
