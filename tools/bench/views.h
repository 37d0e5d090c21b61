// The views of a case: the case's camera in the middle, and copies turned about its up axis in equal steps. Distance
// and height are constant, so that the pictures vary gradually at one scale (Lee and Ihm §3.2).
#pragma once

#include <vector>

#include "bench/suite.h"

namespace kiln {

struct SuiteView {
  double turn_deg = 0;  // relative to the case's camera
  View view;
};

/// shape: suite.views views, in order of angle. throws: Error kUsage if the camera cannot be used.
std::vector<SuiteView> suiteViews(const Suite& suite, const SuiteCase& c, const VolumeGeometry& volume,
                                  const ImageSize& size, Projection projection);

/// Index of the view of the case's own camera, or of the nearest view.
inline std::size_t middleView(const Suite& suite) { return static_cast<std::size_t>(suite.views) / 2; }

}  // namespace kiln
