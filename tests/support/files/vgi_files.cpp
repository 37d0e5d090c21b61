#include "support/files/vgi_files.h"

#include <fmt/format.h>

namespace kiln::test {

std::string vgiHeader(const Extent3& dims, const std::string& type, int bits) {
  return fmt::format(
      "{{volume1}}\n[representation]\nsize = {0} {1} {2}\ndatatype = {3}\nbitsperelement = {4}\n[file1]\n"
      "RegionOfInterestStart = 0 0 0\nFileFormat = raw\nSize = {0} {1} {2}\nName = a.vol\nDatatype = {3}\n"
      "BitsPerElement = {4}\n{{volumeprimitive12}}\n[geometry]\nresolution = 0.5 0.75 2\nunit = mm\n[volume]\n"
      "volume = volume1\n",
      dims.x, dims.y, dims.z, type, bits);
}

}  // namespace kiln::test
