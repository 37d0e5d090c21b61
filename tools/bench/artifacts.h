// Compares the quadtree's pictures with the exact pictures, for several enlargements ε of the tested area. Finds the
// smallest ε with every pixel within 1, and its cost. Lee and Ihm §3.3 leave the choice of ε to future work.
#pragma once

#include "bench/case_drawing.h"
#include "bench/measurements.h"

namespace kiln {

/// Draws every view of the case at its first size: exactly, and with every ε of the suite. throws: the exceptions of
/// renderFrame and encodePng.
ArtifactStudy studyArtifacts(const Suite& suite, std::size_t case_index, CaseDrawing& drawing, Projection projection);

}  // namespace kiln
