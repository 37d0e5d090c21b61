#include "python/arrays.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstring>
#include <mutex>
#include <utility>

#include "base/error.h"
#include "ingest/chunks/chunk_voxels.h"
#include "ingest/chunks/chunked_source.h"
#include "ingest/open_source.h"
#include "ingest/source/wrapped_source.h"

namespace kiln::python {

struct RaisedByArray {
  std::mutex mutex;
  std::optional<py::error_already_set> first;
  ~RaisedByArray() {
    const py::gil_scoped_acquire locked;
    first.reset();
  }
};

namespace {

// A Python object that is released with the interpreter's lock, by any thread.
template <class T>
class Kept {
 public:
  explicit Kept(T object) : object_(std::make_unique<T>(std::move(object))) {}
  Kept(Kept&&) = default;
  ~Kept() {
    if (!object_) return;
    const py::gil_scoped_acquire locked;
    object_.reset();
  }
  T& operator*() const { return *object_; }

 private:
  std::unique_ptr<T> object_;
};

VolumeGeometry geometryOf(const ArrayWords& words) {
  VolumeGeometry out;
  const auto length = [&](int axis) {
    const int of_array = words.axis_of[static_cast<std::size_t>(axis)];
    return of_array < 0 ? std::int64_t{1} : words.shape[static_cast<std::size_t>(of_array)];
  };
  out.dims = {length(0), length(1), length(2)};
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      out.world_from_index[column][row] = words.affine[static_cast<std::size_t>(4 * row + column)];
  }
  out.unit = words.unit;
  out.frame = words.frame == "RAS"   ? PatientFrame::kRas
              : words.frame == "LPS" ? PatientFrame::kLps
                                     : PatientFrame::kUnknown;
  return out;
}

VolumeClass classOf(const ArrayWords& words) { return words.labels ? VolumeClass::kLabels : VolumeClass::kUnknown; }

void requireVoxels(const ArrayWords& words) {
  if (std::any_of(words.shape.begin(), words.shape.end(), [](auto length) { return length < 1; }))
    throw Error(ErrorCode::kUsage, words.name, "shape",
                fmt::format("expected at least one voxel along each axis (found {}); name an array that holds voxels",
                            fmt::join(words.shape, " x ")));
}

// Names the array in the manifest, and the files whose state is that of the array.
class NamedArray final : public WrappedSource {
 public:
  NamedArray(const ArrayWords& words, std::unique_ptr<VolumeSource> source) : WrappedSource(std::move(source)) {
    info_.format = words.name;
    info_.files = words.files;
    info_.trees = words.trees;
  }
};

// Keeps the memory of a buffer while it is read.
class ArrayInPlace final : public WrappedSource {
 public:
  ArrayInPlace(std::unique_ptr<VolumeSource> source, py::buffer_info buffer)
      : WrappedSource(std::move(source)), buffer_(std::move(buffer)) {}

 private:
  const Kept<py::buffer_info> buffer_;
};

class SlicedArray final : public ChunkedArray {
 public:
  SlicedArray(ChunkLayout layout, std::string name, py::function read, std::shared_ptr<RaisedByArray> raised)
      : ChunkedArray(layout),
        layout_(std::move(layout)),
        name_(std::move(name)),
        read_(std::move(read)),
        raised_(std::move(raised)) {}

  const ChunkLayout& layout() const override { return layout_; }
  std::uint64_t decodeBytes() const override {
    const std::uint64_t count = productOf(layout_.chunk_shape);
    return count * (2 * layout_.number.bytes() + sizeOf(layout_.number.voxelType()));
  }
  std::uint64_t heldBytes() const override { return 0; }

 protected:
  BlockCache::Bytes decode(const AxisNumbers& index, std::int64_t, BlockCache::Bytes) override {
    AxisNumbers lo, hi, n;
    for (std::size_t axis = 0; axis < index.size(); ++axis) {
      lo.push_back(index[axis] * layout_.chunk_shape[axis]);
      hi.push_back(std::min(lo[axis] + layout_.chunk_shape[axis], layout_.shape[axis]));
      n.push_back(hi[axis] - lo[axis]);
    }
    std::vector<std::byte> part(productOf(n) * sizeOf(layout_.number.voxelType()));
    readVoxels(layout_.number, part, {name_, ""}, [&](std::span<std::byte> stored) { slice(lo, hi, stored); });
    return wholeChunk(layout_, part, n);
  }

 private:
  void slice(const AxisNumbers& lo, const AxisNumbers& hi, std::span<std::byte> out) const {
    const py::gil_scoped_acquire locked;
    try {
      const py::buffer piece = (*read_)(py::tuple(py::cast(lo)), py::tuple(py::cast(hi)));
      const py::buffer_info info = piece.request();
      if (static_cast<std::size_t>(info.size * info.itemsize) != out.size())
        throw py::value_error(
            fmt::format("the array returned {} bytes of a box of {}", info.size * info.itemsize, out.size()));
      std::memcpy(out.data(), info.ptr, out.size());
    } catch (py::error_already_set& error) {
      keep(error);
    } catch (const py::builtin_exception& error) {
      error.set_error();
      py::error_already_set raised;
      keep(raised);
    }
  }
  [[noreturn]] void keep(const py::error_already_set& error) const {
    const std::string text = textOf(error);
    const std::lock_guard lock(raised_->mutex);
    if (!raised_->first) raised_->first = error;
    throw CausedError(Error(ErrorCode::kIo, name_, "", "the array raised " + text), error);
  }

  // Returns type and message, without the lines of the traceback. Another exception may be raised on the way.
  static std::string textOf(const py::error_already_set& error) {
    try {
      return fmt::format("{}: {}", std::string(py::str(error.type().attr("__name__"))),
                         std::string(py::str(error.value())));
    } catch (const py::error_already_set&) {
      return "an exception without a text";
    }
  }

  const ChunkLayout layout_;
  const std::string name_;
  const Kept<py::function> read_;
  const std::shared_ptr<RaisedByArray> raised_;
};

}  // namespace

std::shared_ptr<ArraySource> ArraySource::inPlace(const ArrayWords& words, const py::buffer& buffer) {
  requireVoxels(words);
  py::buffer_info info = buffer.request();
  VoxelArray array;
  array.voxels = info.ptr;
  array.type = storedNumberNamed(words.number)->voxelType();
  array.geometry = geometryOf(words);
  array.volume_class = classOf(words);
  array.strides = {info.strides[2], info.strides[1], info.strides[0]};
  auto kept = std::make_unique<ArrayInPlace>(arraySource(array), std::move(info));
  auto out = std::make_shared<ArraySource>();
  out->source_.reset(new NamedArray(words, std::move(kept)));
  out->labels_ = words.labels;
  out->has_state_ = words.hasState();
  return out;
}

std::shared_ptr<ArraySource> ArraySource::sliced(const ArrayWords& words, const py::function& read) {
  const std::optional<StoredNumber> number = storedNumberNamed(words.number);
  if (!number)
    throw Error(
        ErrorCode::kUnsupported, words.name, "dtype",
        fmt::format("expected whole numbers or floats of 8 to 64 bits (found {}); convert the array", words.number));
  requireVoxels(words);
  ChunkLayout layout;
  layout.number = *number;
  layout.shape = words.shape;
  layout.chunk_shape = words.chunks;
  for (std::size_t axis = 0; axis < words.shape.size(); ++axis) layout.stored_axes.push_back(static_cast<int>(axis));
  ArrayVolume volume;
  volume.geometry = geometryOf(words);
  volume.axis_of = words.axis_of;
  volume.fixed = words.fixed;
  volume.volume_class = classOf(words);
  SourceInfo info;
  info.files = {words.name};  // names the array in errors
  auto out = std::make_shared<ArraySource>();
  out->raised_ = std::make_shared<RaisedByArray>();
  auto array = std::make_unique<SlicedArray>(layout, words.name, read, out->raised_);
  out->source_.reset(new NamedArray(words, openChunked(std::move(info), volume, std::move(array))));
  out->labels_ = words.labels;
  out->has_state_ = words.hasState();
  return out;
}

std::unique_ptr<VolumeSource> ArraySource::take() {
  if (!source_) throw Error(ErrorCode::kUsage, "array: was opened before; open the array again");
  return std::unique_ptr<VolumeSource>(source_.release());
}

void ArraySource::run(const py::object& on_progress, const std::function<void(Progress&)>& work) const {
  try {
    runForCall(on_progress, work);
  } catch (const Error&) {
    if (raised_ && raised_->first) throw py::error_already_set(*raised_->first);
    throw;
  }
}

void bindArrays(py::module_& module) {
  py::class_<ArrayWords>(module, "ArrayWords")
      .def(py::init<>())
      .def_readwrite("name", &ArrayWords::name)
      .def_readwrite("number", &ArrayWords::number)
      .def_readwrite("shape", &ArrayWords::shape)
      .def_readwrite("chunks", &ArrayWords::chunks)
      .def_readwrite("fixed", &ArrayWords::fixed)
      .def_readwrite("axis_of", &ArrayWords::axis_of)
      .def_readwrite("affine", &ArrayWords::affine)
      .def_readwrite("unit", &ArrayWords::unit)
      .def_readwrite("frame", &ArrayWords::frame)
      .def_readwrite("labels", &ArrayWords::labels)
      .def_readwrite("known", &ArrayWords::known)
      .def_readwrite("files", &ArrayWords::files)
      .def_readwrite("trees", &ArrayWords::trees);
  py::class_<ArraySource, std::shared_ptr<ArraySource>>(module, "ArraySource")
      .def_static("in_place", &ArraySource::inPlace)
      .def_static("sliced", &ArraySource::sliced);
}

}  // namespace kiln::python
