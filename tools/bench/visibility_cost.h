// Costs of a test and of an update, by method, image size and tested area, for the visibility structures alone. Shown
// with the complexities of Lee and Ihm's Table 4.
#pragma once

#include <vector>

#include "base/progress.h"
#include "bench/suite.h"

namespace kiln {

/// Cost of closing the pixels of a disc that grows from the image's middle, footprint by footprint.
struct UpdateCost {
  VisibilityMethod method;
  int size_px;           // edge of the image
  std::uint64_t pixels;  // closed pixels
  double ns_per_pixel;   // without the cost of the loop itself
};

/// Cost of testing squares while the disc is closed.
struct TestCost {
  VisibilityMethod method;
  int size_px, area_px;
  double hidden_ns;  // squares inside the disc: the search never ends early; 0 if no square fits
  double mixed_ns;   // squares anywhere in the image
};

struct VisibilityCosts {
  std::vector<UpdateCost> updates;
  std::vector<TestCost> tests;
};

/// Measures every method except kNone. The fastest of three runs counts, to exclude the machine's other work. cost:
/// seconds for images of 4096 pixels. throws: Error kCancelled.
VisibilityCosts measureVisibilityCosts(const std::vector<VisibilityMethod>& methods, const CostRequest& request,
                                       Progress& progress);

}  // namespace kiln
