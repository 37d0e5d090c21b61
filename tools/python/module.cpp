// The extension module kiln._kiln. The functions that users call are written in Python, in the folder kiln.
#include "python/arrays.h"
#include "python/call.h"
#include "python/job_words.h"
#include "python/modules.h"
#include "python/picture.h"
#include "python/volume.h"

PYBIND11_MODULE(_kiln, module) {
  module.attr("version") = KILN_VERSION;
  kiln::python::bindErrors(module);
  kiln::python::bindWords(module);
  kiln::python::bindPicture(module);
  kiln::python::bindArrays(module);
  kiln::python::bindVolume(module);
  kiln::python::bindConvert(module);
  kiln::python::bindFrames(module);
  kiln::python::bindViewer(module);
}
