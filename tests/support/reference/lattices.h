// The renderer's lattices, for tests that hold for each lattice.
#pragma once

#include "frame/render_frame.h"
#include "job/job_names.h"

namespace kiln::test {

inline constexpr Lattice kLattices[] = {Lattice::kPixel, Lattice::kVoxel};

inline void setLattice(FrameRequest& request, Lattice lattice) { request.lattice = lattice; }

inline const char* nameOf(Lattice lattice) { return nameIn(kLatticeNames, lattice).data(); }

}  // namespace kiln::test
