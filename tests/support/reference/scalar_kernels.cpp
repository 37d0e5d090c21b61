#include "support/reference/scalar_kernels.h"

#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

namespace kiln::test {

void onEveryInstructionSet(const std::function<void(std::int64_t target)>& f) {
  // The lowest bit is the best set. A set without kernels dispatches to another set, which is called only once.
  std::vector<std::int64_t> targets;
  for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) targets.push_back(rest & -rest);
  std::set<std::string> done;
  for (auto target = targets.rbegin(); target != targets.rend(); ++target) {
    hwy::SetSupportedTargetsForTest(*target);
    if (done.insert(instructionSet()).second) f(*target);
  }
  hwy::SetSupportedTargetsForTest(0);
}

SampledRange loadPatchScalar(const BrickBlock& block, const SampleLattice& lattice, double offset, const VoxelCoord& lo,
                             float* values) {
  SampledRange out;
  const int rim = lattice.interpolation == Interpolation::kLinear ? kPatchMargin - 1 : 0;
  const auto inner = [&](int i) { return i >= rim - kPatchMargin && i < kPatchVoxels + kPatchMargin - rim; };
  withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const T* const voxels = reinterpret_cast<const T*>(block.voxels.data());
    for (int z = -kPatchMargin; z < kPatchVoxels + kPatchMargin; ++z) {
      for (int y = -kPatchMargin; y < kPatchVoxels + kPatchMargin; ++y, values += kPatchStride) {
        for (int x = -kPatchMargin; x < kPatchVoxels + kPatchMargin; ++x) {
          VoxelCoord at = {lo.x + x, lo.y + y, lo.z + z};
          for (int a = 0; a < 3; ++a) at[a] = std::clamp(at[a], block.extent.lo[a], block.extent.hi[a] - 1);
          const auto value = static_cast<double>(voxels[block.offsetOf(at)]);
          values[x + kPatchMargin] = static_cast<float>(value - offset);
          if (std::abs(value - offset) > 1e37)
            values[x + kPatchMargin] = std::copysign(1e37f, values[x + kPatchMargin]);
          if (!inner(x) || !inner(y) || !inner(z)) continue;
          out.values.include(value);
          out.gaps = out.gaps || std::isnan(value);
        }
      }
    }
  });
  return out;
}

}  // namespace kiln::test
