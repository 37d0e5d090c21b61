// HDF5 files. The library describes a file in a separate process; Kiln reads most voxels without the library.
#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/file/path_status.h"
#include "base/text.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/chunks/chunked_source.h"
#include "ingest/hdf5/hdf5_chunks.h"
#include "ingest/hdf5/hdf5_image.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// A contiguous data set whose last axes are z, y, x is a raw file at an offset. Returns null for any other.
std::unique_ptr<VolumeSource> openContiguous(SourceInfo info, const Hdf5Layout& layout, const ArrayVolume& volume,
                                             const Hdf5Image& image, const fs::path& file) {
  const auto axes = static_cast<int>(layout.shape.size());
  if (!layout.offset || axes < 3 || !image.used_shape.empty() ||
      volume.axis_of != std::array{axes - 1, axes - 2, axes - 3})
    return nullptr;
  const auto leading = [&](const AxisNumbers& numbers) { return AxisNumbers(numbers.begin(), numbers.end() - 3); };
  const std::int64_t before = placeIn(leading(layout.shape), leading(volume.fixed));
  LinearData data;
  data.file = file;
  data.offset_bytes =
      *layout.offset + static_cast<std::uint64_t>(before * volume.geometry.dims.count()) * layout.number.bytes();
  data.stored_type = layout.number.type;
  data.big_endian = layout.number.big_endian;
  data.has_trailer = true;
  describe(volume, layout.number.voxelType(), info);
  return openLinear(std::move(info), data);
}

ArrayVolume placed(const fs::path& file, const Hdf5Image& image, const Hdf5Layout& layout, SourceOptions options) {
  if (image.path_chooses) {
    options.channel.reset();
    options.time.reset();
  }
  const AxisNumbers& shape = image.used_shape.empty() ? layout.shape : image.used_shape;
  ArrayVolume out = volumeOf({file, file, shape}, image.axes, image.has_scale, {}, options);
  if (image.world_from_index && !options.spacing) out.geometry.world_from_index = *image.world_from_index;
  requireInvertible(out.geometry.world_from_index, file.string());
  if (image.frame != PatientFrame::kUnknown) out.geometry.frame = image.frame;
  out.choice = image.choice + ", " + shown(image.path) + out.choice;
  out.notes.insert(out.notes.end(), image.notes.begin(), image.notes.end());
  return out;
}

// Sets extents and type of one channel and time, and the reason why the data set is not read.
void describeListed(const fs::path& file, const Hdf5Objects& objects, BdvXmlBeside& beside, ListedVolume& volume) {
  const Hdf5Object& dataset = *objects.find(volume.name);
  const std::optional<StoredNumber> number = storedNumberNamed(dataset.type);
  if (number) volume.type = number->voxelType();
  SourceOptions first;
  first.channel = "0";
  first.time = 0;
  try {
    const Hdf5Image image = hdf5ImageAt(file, volume.name, objects, beside);
    const AxisNumbers& shape = image.used_shape.empty() ? dataset.shape : image.used_shape;
    volume.dims = volumeOf({file, file, shape}, image.axes, image.has_scale, {}, first).geometry.dims;
    if (number && image.is_unsigned) volume.type = number->withoutSign().voxelType();
    if (!image.scales.slices.empty()) volume.type = VoxelType::f32;
  } catch (const Error& error) {
    volume.refusal = error.what();
  }
}

}  // namespace

std::vector<ListedVolume> listHdf5(const fs::path& file, const SourceOptions& options) {
  Hdf5Reader reader(file, kReaderAddressBytes);
  const Hdf5Objects objects(file, reader.text(hdf5::Request::kDescribe, "", options.memory_bytes),
                            options.memory_bytes);
  BdvXmlBeside beside(file);
  std::vector<ListedVolume> out;
  for (const std::string& path : objects.volumes()) {
    const Hdf5Object& dataset = *objects.find(path);
    ListedVolume& volume = out.emplace_back();
    volume.name = path;
    volume.kind = dataset.shape.size() == 3 ? "HDF5" : fmt::format("HDF5 of {} axes", dataset.shape.size());
    describeListed(file, objects, beside, volume);
    volume.option = file.string() + ":" + path;
  }
  if (objects.areOthersCut()) {
    ListedVolume& more = out.emplace_back();
    more.name = "...";
    more.kind = "HDF5";
    more.refusal = kOthersAreCut;
  }
  return out;
}

std::unique_ptr<VolumeSource> openHdf5(const fs::path& file, const std::string& path, const SourceOptions& options) {
  Hdf5Reader reader(file, kReaderAddressBytes);
  const auto describe = [&](const std::string& first) {
    return Hdf5Objects(file, reader.text(hdf5::Request::kDescribe, first, options.memory_bytes), options.memory_bytes);
  };
  const Hdf5Image image = findHdf5Image(file, path, describe, options);
  Hdf5Layout layout = readHdf5Layout(reader, file, image.path, options.memory_bytes);
  if (image.is_unsigned) {
    layout.number = layout.number.withoutSign();
    layout.served = layout.served.withoutSign();
  }
  const ArrayVolume volume = placed(file, image, layout, options);
  SourceInfo info;
  info.format = "HDF5";
  info.files = {file};
  info.files.insert(info.files.end(), image.headers.begin(), image.headers.end());
  info.files.insert(info.files.end(), layout.files.begin(), layout.files.end());
  std::unique_ptr<VolumeSource> source = openContiguous(info, layout, volume, image, file);
  if (!source) source = openChunked(std::move(info), volume, openHdf5Chunks(file, std::move(layout)));
  return image.scales.slices.empty() ? std::move(source) : scaledSlices(std::move(source), image.scales);
}

}  // namespace kiln
