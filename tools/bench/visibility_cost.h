// What a test and an update cost, by method, image size and size of the area asked about: the structures alone, without
// a volume, beside the complexities of Lee and Ihm's Table 4.
#pragma once

#include <vector>

#include "base/progress.h"
#include "bench/suite.h"

namespace kiln {

/// Closing the pixels of a disc that grows from the image's middle, footprint by footprint.
struct UpdateCost {
  VisibilityMethod method;
  int size_px;           // along the image's edges
  std::uint64_t pixels;  // closed
  double ns_per_pixel;   // without what the loop itself costs
};

/// Asking about squares, the disc closed.
struct TestCost {
  VisibilityMethod method;
  int size_px, area_px;
  double hidden_ns;  // squares inside of the disc: nothing ends the search early. 0 where none fits
  double mixed_ns;   // squares anywhere in the image
};

struct VisibilityCosts {
  std::vector<UpdateCost> updates;
  std::vector<TestCost> tests;
};

/// Measures every method but kNone. The least of three runs counts: what is asked is the cost of the work, not of the
/// machine's other business. cost: seconds for images of 4096 pixels. throws: Error kCancelled.
VisibilityCosts measureVisibilityCosts(const std::vector<VisibilityMethod>& methods, const CostRequest& request,
                                       Progress& progress);

}  // namespace kiln
