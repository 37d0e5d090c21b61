// How the report writes methods, projections and numbers.
#pragma once

#include <string>
#include <string_view>

#include "job/render_job.h"
#include "scene/camera/camera.h"

namespace kiln {

/// "Octree/Range tree", as the paper's tables say it.
std::string_view titleOf(VisibilityMethod method);
/// "range tree": inside of a sentence.
std::string_view wordOf(VisibilityMethod method);
/// "m-range-tree": the class that colours a method in drawings.
std::string classOf(VisibilityMethod method);
/// "Orthographic".
std::string_view titleOf(Projection projection);
/// "256×256".
std::string textOf(const ImageSize& size);
/// "1 041 109": groups of three, narrow spaces that do not break.
std::string counted(double number);
/// Three significant digits or more: "0.412", "21.3", "1 204".
std::string measured(double number);

}  // namespace kiln
