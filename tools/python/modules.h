// The parts of the extension module that share no types.
#pragma once

#include "python/call.h"

namespace kiln::python {

void bindConvert(py::module_& module);
void bindFrames(py::module_& module);
void bindViewer(py::module_& module);

}  // namespace kiln::python
