// The views of a case: the case's camera in the middle, the others turned about its up by equal steps, at a constant
// distance and height, so that the pictures vary gradually and are all of one scale (Lee and Ihm §3.2).
#pragma once

#include <vector>

#include "bench/suite.h"

namespace kiln {

struct SuiteView {
  double turn_deg = 0;  // from the case's camera
  View view;
};

/// shape: suite.views of them, in order of angle. throws: Error kUsage where the camera cannot be used.
std::vector<SuiteView> suiteViews(const Suite& suite, const SuiteCase& c, const VolumeGeometry& volume,
                                  const ImageSize& size, Projection projection);

/// The place of the view that is the case's own camera, or the nearest to it.
inline std::size_t middleView(const Suite& suite) { return static_cast<std::size_t>(suite.views) / 2; }

}  // namespace kiln
