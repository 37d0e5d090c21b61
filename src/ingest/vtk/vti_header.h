// The XML of a VTK image file (.vti): the grid, and the places of its arrays.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ingest/codec/unpack_block.h"
#include "ingest/vtk/vtk_types.h"

namespace kiln {

enum class VtiFormat { kAscii, kBase64, kAppended };

struct VtiArray : VtkArray {
  VtiFormat format = VtiFormat::kAscii;
  /// Begin of the array's text in the file, or of its bytes in the appended data. unit: bytes.
  std::uint64_t begin = 0;
};

struct VtiHeader {
  /// First and last point along x, y and z.
  std::array<std::int64_t, 6> extent{};
  glm::dvec3 origin{0}, spacing{1};
  /// Column a is the direction of axis a.
  glm::dmat3 direction{1.0};
  bool big_endian = false;
  /// True if lengths have 64 bits, false for 32.
  bool wide_lengths = false;
  BlockCodec codec = BlockCodec::kNone;
  std::vector<VtiArray> arrays;
  /// Begin of the appended bytes, behind the underscore.
  std::optional<std::uint64_t> appended;
  bool appended_in_base64 = false;
};

/// Reads the file up to the appended data. cost: inline arrays are passed over once.
/// throws: Error kFormat if the XML is not well-formed, cut short, or not VTK's; kUnsupported for other data than one
/// image in one piece.
VtiHeader readVtiHeader(const std::filesystem::path& path);

}  // namespace kiln
