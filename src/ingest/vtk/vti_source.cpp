// Images of VTK in XML (.vti): one array of one value a point or a cell. A raw appended array without compression is
// read as a raw file is; numbers as text are read forwards; base64 and compressed blocks are read row by row, and
// decoded blocks are cached for neighbouring boxes.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>

#include "base/error.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/bytes/value_map.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "ingest/vtk/vti_bytes.h"
#include "ingest/vtk/vti_header.h"
#include "ingest/vtk/vtk_types.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr VtkTypeName kVtiTypes[] = {
    {"UInt8", VoxelType::u8},   {"Int8", VoxelType::i8},   {"UInt16", VoxelType::u16},  {"Int16", VoxelType::i16},
    {"UInt32", VoxelType::u32}, {"Int32", VoxelType::i32}, {"Float32", VoxelType::f32}, {"Float64", VoxelType::f64}};

/// Voxels x fastest in the bytes of an array.
class VtiSource : public VolumeSource {
 public:
  VtiSource(SourceInfo info, std::unique_ptr<VtiArrayBytes> bytes, bool swapped)
      : info_(std::move(info)), bytes_(std::move(bytes)), swapped_(swapped) {}

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  std::uint64_t decodeBytes() const override { return bytes_->decodeBytes(); }
  std::uint64_t heldBytes() const override { return bytes_->heldBytes(); }
  void keepDecoded(std::uint64_t bytes) override { bytes_->setCache(bytes); }

 private:
  SourceInfo info_;
  std::unique_ptr<VtiArrayBytes> bytes_;
  bool swapped_;
};

void VtiSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  if (box.empty()) return;
  const Extent3 dims = info_.geometry.dims, n = box.extent();
  const std::size_t size = sizeOf(info_.type);
  // Rows and slices that follow each other in the file are one run.
  const std::int64_t rows = n.x == dims.x ? n.y : 1, slices = rows == dims.y ? n.z : 1;
  const std::size_t run = static_cast<std::size_t>(n.x * rows * slices) * size;
  std::byte* to = out.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; z += slices) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; y += rows, to += run) {
      const std::int64_t first = (z * dims.y + y) * dims.x + box.lo.x;
      bytes_->read(static_cast<std::uint64_t>(first) * size, {to, run});
    }
  }
  if (swapped_ && size > 1) swapBytes(out.data(), static_cast<std::size_t>(box.count()), size);
}

bool isReadable(const VtiArray& array) { return array.components == 1 && vtkTypeNamed(kVtiTypes, array.type); }

std::string described(const std::vector<VtiArray>& arrays) {
  constexpr std::size_t kMost = 8;
  std::string out;
  for (std::size_t i = 0; i < std::min(arrays.size(), kMost); ++i)
    out += fmt::format("{}{} of {} x {}", i == 0 ? "" : ", ", inQuotes(arrays[i].name), arrays[i].components,
                       inQuotes(arrays[i].type));
  return out.empty() ? "none" : arrays.size() > kMost ? out + " and more" : out;
}

// Returns the array that the user chose, else the active scalars, else the only array of one value a point or cell.
const VtiArray& chosenArray(const VtiHeader& header, const SourceOptions& options, const fs::path& path,
                            std::string& choice) {
  std::vector<const VtiArray*> readable;
  std::vector<std::string> names;
  for (const VtiArray& array : header.arrays) {
    if (!isReadable(array)) continue;
    readable.push_back(&array);
    names.push_back(array.name);
  }
  if (readable.empty())
    throw Error(ErrorCode::kUnsupported, path, "",
                "holds no array of one number of 8 to 32 bits or float a point or cell (found " +
                    described(header.arrays) + ")");
  if (!options.channel) {
    const auto isActive = [](const VtiArray* array, bool of_cells, const std::string& name) {
      return array->of_cells == of_cells && !name.empty() && array->name == name;
    };
    for (const VtiArray* array : readable)
      if (isActive(array, false, header.point_scalars)) return *array;
    for (const VtiArray* array : readable)
      if (isActive(array, true, header.cell_scalars)) return *array;
  }
  const std::int64_t channel = chosenChannel(options, names, path);
  choice = partOf("channel", channel, static_cast<std::int64_t>(readable.size()));
  return *readable[static_cast<std::size_t>(channel)];
}

VtiText textOf(const VtiHeader& header, const VtiArray& array, const fs::path& path) {
  File file(path);
  const auto refuse = [&](const std::string& what) { throw Error(ErrorCode::kFormat, path, array.name, what); };
  if (array.format == VtiFormat::kAppended) {
    if (!header.appended) refuse("its data are said to be appended, but the file has no appended data");
    if (array.begin > file.size() || *header.appended > file.size() - array.begin)
      refuse(
          fmt::format("its data should begin at byte {} of the appended data, beyond the end of the file; it is cut "
                      "short",
                      array.begin));
    return {std::move(file), *header.appended + array.begin, header.appended_in_base64};
  }
  std::uint64_t begin = array.begin;
  std::byte next{};
  while (file.readSomeAt(begin, {&next, 1}) == 1 && std::isspace(std::to_integer<int>(next)) != 0) ++begin;
  return {std::move(file), begin, true};
}

}  // namespace

std::unique_ptr<VolumeSource> openVti(const fs::path& input, const SourceOptions& options) {
  const VtiHeader header = readVtiHeader(input);
  std::string choice;
  const VtiArray& array = chosenArray(header, options, input, choice);
  SourceInfo info;
  info.format = "VTK image" + choice;
  info.files = {input};
  info.type = *vtkTypeNamed(kVtiTypes, array.type);
  info.geometry =
      vtkGeometry(input, header.extent, array.of_cells, header.origin, header.spacing, header.direction, options);
  LinearData data;
  data.file = input;
  data.stored_type = info.type;
  data.big_endian = header.big_endian;
  data.has_trailer = true;
  if (array.format == VtiFormat::kAscii) {
    data.encoding = DataEncoding::kDecimal;
    data.offset_bytes = array.begin;
    return openDescribed(input, std::move(info), data);
  }
  auto bytes = std::make_unique<VtiArrayBytes>(
      textOf(header, array, input), VtiLengths{header.wide_lengths, header.big_endian}, header.codec,
      checkedBytes(info.geometry.dims, info.type, input), options.memory_bytes);
  const bool raw = array.format == VtiFormat::kAppended && !header.appended_in_base64;
  if (raw && header.codec == BlockCodec::kNone) {
    data.offset_bytes = bytes->begin();
    return openDescribed(input, std::move(info), data);
  }
  const bool swapped = header.big_endian != (std::endian::native == std::endian::big);
  return std::make_unique<VtiSource>(std::move(info), std::move(bytes), swapped);
}

}  // namespace kiln
