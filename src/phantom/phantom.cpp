// At the sizes of the published volumes voxels are nearly cubic: body 587 × 341 × 1878, head 256 × 256 × 225, engine
// 256 × 256 × 110. The brain, 256 × 256 × 167, has voxels of 1.125 × 1.125 × 1.52 mm: slices thicker than wide, as in
// MR.
#include "phantom/phantom.h"

#include <algorithm>

#include "phantom/models/body.h"
#include "phantom/models/engine.h"

namespace kiln::phantom {
namespace {

constexpr std::uint64_t kSeed = 0x6b696c6e;  // "kiln"

// From above the vertex to below the chin.
const glm::dvec3 kHeadExtent{288, 288, 253.125}, kHeadCorner{-144, -144, 1607};

const PhantomKind kKinds[] = {
    {"body",
     {-0.5 * kBodyBoxMm[0], -0.5 * kBodyBoxMm[1], 0},
     {kBodyBoxMm[0], kBodyBoxMm[1], kBodyBoxMm[2]},
     {587, 341, 1878},
     VoxelType::u16,
     PatientFrame::kLps,
     ctValues,
     bodyParts},
    {"head", kHeadCorner, kHeadExtent, {256, 256, 225}, VoxelType::u16, PatientFrame::kLps, ctValues, bodyParts},
    {"brain", kHeadCorner, kHeadExtent, {256, 256, 167}, VoxelType::u16, PatientFrame::kLps, mrValues, bodyParts},
    {"engine",
     {-0.5 * kEngineBoxMm[0], -0.5 * kEngineBoxMm[1], -0.5 * kEngineBoxMm[2]},
     {kEngineBoxMm[0], kEngineBoxMm[1], kEngineBoxMm[2]},
     {256, 256, 110},
     VoxelType::u8,
     PatientFrame::kUnknown,
     castingValues,
     engineParts},
};

Lattice latticeOf(const PhantomKind& kind, const Extent3& dims) {
  return {dims, kind.corner_mm, kind.extent_mm / glm::dvec3(dims.x, dims.y, dims.z)};
}

}  // namespace

std::span<const PhantomKind> phantomKinds() { return kKinds; }

const PhantomKind* findPhantom(std::string_view name) {
  const auto it =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const PhantomKind& k) { return k.name == name; });
  return it == std::end(kKinds) ? nullptr : it;
}

Phantom::Phantom(const PhantomKind& kind, const Extent3& dims)
    : kind_(kind), figure_(kind.parts()), lattice_(latticeOf(kind, dims)) {}

VolumeGeometry Phantom::geometry() const {
  VolumeGeometry out;
  out.dims = lattice_.dims;
  out.frame = kind_.frame;
  out.unit = "mm";
  for (int axis = 0; axis < 3; ++axis) {
    out.world_from_index[axis][axis] = lattice_.spacing_mm[axis];
    out.world_from_index[3][axis] = lattice_.corner_mm[axis] + 0.5 * lattice_.spacing_mm[axis];
  }
  return out;
}

void Phantom::read(const VoxelBox& box, std::span<std::byte> out) const {
  const Sampler sampler(figure_, lattice_, values(), kSeed);
  if (kind_.type == VoxelType::u8) {
    sampler.sample(box, reinterpret_cast<std::uint8_t*>(out.data()));
  } else {
    sampler.sample(box, reinterpret_cast<std::uint16_t*>(out.data()));
  }
}

}  // namespace kiln::phantom
