// Arrays of Python as foreign volumes.
//
// Method. NumPy arrays of a voxel type are read in place, without the interpreter's lock. Everything else is an array
// of chunks, which a Python function slices: each chunk is read once where the memory of decoded chunks allows.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ingest/source/volume_source.h"
#include "python/call.h"

namespace kiln::python {

/// The description of an array, made by Python (kiln/_arrays.py).
struct ArrayWords {
  std::string name;    // for messages and the manifest
  std::string number;  // NumPy's name of the type, in the machine's byte order: "uint16", "int64", "float16", "bool"
  std::vector<std::int64_t> shape, chunks;    // along all axes of the array
  std::vector<std::int64_t> fixed;            // the index along other axes than x, y and z; else 0
  std::array<int, 3> axis_of = {-1, -1, -1};  // the array's axis for x, y and z
  std::array<double, 16> affine{};            // row by row: world (x, y, z) from voxel (x, y, z)
  std::string unit;
  std::string frame;  // "RAS", "LPS" or empty
  bool labels = false;
  // Their state decides whether a conversion can be resumed. `known`: the name alone identifies the array.
  std::vector<std::filesystem::path> files, trees;
  bool known = false;

  bool hasState() const { return known || !files.empty() || !trees.empty(); }
};

/// The first exception that Python raised while an array was read.
struct RaisedByArray;

/// A source that is opened once.
class ArraySource {
 public:
  /// `buffer` has the axes z, y, x.
  static std::shared_ptr<ArraySource> inPlace(const ArrayWords& words, const py::buffer& buffer);
  /// `read(lo, hi)` returns a C-contiguous buffer of the numbers in a box.
  static std::shared_ptr<ArraySource> sliced(const ArrayWords& words, const py::function& read);

  /// throws: Error kUsage if the source was taken before.
  std::unique_ptr<VolumeSource> take();
  bool labels() const { return labels_; }
  /// Returns true if the array's state distinguishes the array from other arrays.
  bool hasState() const { return has_state_; }
  /// Runs work that reads the array; an exception of Python's replaces the error that it caused.
  void run(const py::object& on_progress, const std::function<void(Progress&)>& work) const;

 private:
  UnlockedPointer<VolumeSource> source_;
  std::shared_ptr<RaisedByArray> raised_;
  bool labels_ = false, has_state_ = false;
};

void bindArrays(py::module_& module);

}  // namespace kiln::python
