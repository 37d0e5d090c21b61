// Headerless voxels. The user gives the dimensions and the type; the file's length must agree with them.
#include "base/error.h"
#include "base/file/file.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

std::string described(const Extent3& dims, VoxelType type, std::uint64_t skip_bytes) {
  std::string out = std::to_string(dims.x) + "x" + std::to_string(dims.y) + "x" + std::to_string(dims.z) + " " +
                    std::string(nameOf(type));
  if (skip_bytes > 0) out += " after " + std::to_string(skip_bytes) + " bytes";
  return out;
}

// Describes the user's options beyond dimensions and type. A store is recognised by this text (foreign_cache.cpp).
std::string formatOf(VoxelType type, const SourceOptions& options) {
  std::string out = "raw";
  if (options.big_endian.value_or(false) && sizeOf(type) > 1) out += ", big-endian";
  if (options.skip_bytes > 0) out += ", " + std::to_string(options.skip_bytes) + " bytes skipped";
  return out;
}

}  // namespace

std::unique_ptr<VolumeSource> openRaw(const std::filesystem::path& input, const SourceOptions& options) {
  if (!options.dims || !options.type) {
    throw Error(ErrorCode::kUsage, input, "",
                "headerless raw data need --dims and --type (for example --dims 256,256,113 --type u16)");
  }
  SourceInfo info;
  info.format = formatOf(*options.type, options);
  info.files = {input};
  info.type = *options.type;
  info.geometry.dims = *options.dims;
  info.geometry.world_from_index = axesAffine(options.spacing.value_or(glm::dvec3(1)), glm::dvec3(0));
  requireInvertible(info.geometry.world_from_index, input.string());

  const std::uint64_t bytes = checkedBytes(*options.dims, *options.type, input);
  const std::uint64_t found = File(input).size();
  const bool fits = options.skip_bytes <= found && bytes == found - options.skip_bytes;
  if (!fits) {
    const bool packed = input.extension() == ".gz";
    const bool longer = options.skip_bytes < found && bytes < found - options.skip_bytes;
    const std::uint64_t surplus = longer ? found - options.skip_bytes - bytes : 0;
    throw Error(ErrorCode::kFormat, input, "",
                "has " + std::to_string(found) + " bytes, but " +
                    described(*options.dims, *options.type, options.skip_bytes) + " takes " + std::to_string(bytes) +
                    (options.skip_bytes ? " + " + std::to_string(options.skip_bytes) : "") +
                    "; correct --dims or --type" +
                    (longer ? ", or give --skip " + std::to_string(options.skip_bytes + surplus) +
                                  " where a header precedes the voxels"
                            : "") +
                    (packed ? " (the name ends in .gz: decompress the file first)" : ""));
  }
  LinearData data;
  data.file = input;
  data.offset_bytes = options.skip_bytes;
  data.stored_type = *options.type;
  data.big_endian = options.big_endian.value_or(false);
  return openLinear(std::move(info), data);
}

}  // namespace kiln
