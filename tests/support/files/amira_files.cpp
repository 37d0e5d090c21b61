#include "support/files/amira_files.h"

#include <fmt/format.h>

namespace kiln::test {

std::string amiraHeader(const Extent3& dims, const std::string& encoding, const std::string& type,
                        const std::string& mark) {
  return fmt::format(
      "# AmiraMesh {} 2.1\n\n\ndefine Lattice {} {} {}\n\nParameters {{\n    Units {{\n        Coordinates \"mm\"\n    "
      "}}\n"
      "    Content \"{}x{}x{} {}, uniform coordinates\",\n    BoundingBox 1 5 2 8 -3 3,\n    CoordType "
      "\"uniform\"\n}}\n\n"
      "Lattice {{ {} Data }} {}\n\n# Data section follows\n@1\n",
      encoding, dims.x, dims.y, dims.z, dims.x, dims.y, dims.z, type, type, mark);
}

const char* amiraName(VoxelType type) {
  switch (type) {
    case VoxelType::u8:
      return "byte";
    case VoxelType::i16:
      return "short";
    case VoxelType::u16:
      return "ushort";
    case VoxelType::i32:
      return "int";
    case VoxelType::f32:
      return "float";
    default:
      return "double";
  }
}

std::string amiraFile(const ForeignVolume& volume) {
  return amiraHeader(volume.dims, "BINARY-LITTLE-ENDIAN", amiraName(volume.type)) + volume.stored(false) + "\n";
}

}  // namespace kiln::test
