// Words and number formats of the report.
#pragma once

#include <string>
#include <string_view>

#include "job/render_job.h"
#include "scene/camera/camera.h"

namespace kiln {

/// "Octree/Range tree", as in the paper's tables.
std::string_view titleOf(VisibilityMethod method);
/// "range tree", for use inside a sentence.
std::string_view wordOf(VisibilityMethod method);
/// "m-range-tree": the CSS class that colours a method.
std::string classOf(VisibilityMethod method);
/// "Orthographic".
std::string_view titleOf(Projection projection);
/// "256×256".
std::string textOf(const ImageSize& size);
/// "1 041 109": groups of three digits, separated by narrow non-breaking spaces.
std::string counted(double number);
/// At least three significant digits: "0.412", "21.3", "1 204".
std::string measured(double number);

}  // namespace kiln
