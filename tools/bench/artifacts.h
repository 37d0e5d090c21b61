// How far the quadtree's pictures are from the exact ones, by the enlargement ε of its area, and what an ε costs that
// keeps every pixel within 1 (Lee and Ihm §3.3, which leaves choosing it to the future).
#pragma once

#include "bench/case_drawing.h"
#include "bench/measurements.h"

namespace kiln {

/// Draws every view of the case at its first size: exactly, and with every ε of the suite. throws: what renderFrame and
/// encodePng throw.
ArtifactStudy studyArtifacts(const Suite& suite, std::size_t case_index, CaseDrawing& drawing, Projection projection);

}  // namespace kiln
