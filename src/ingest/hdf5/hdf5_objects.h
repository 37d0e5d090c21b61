// The groups and data sets of an HDF5 file with their attributes, as the HDF5 library describes them.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ingest/chunks/chunked_array.h"
#include "ingest/source/json_node.h"

namespace kiln {

/// Returns the path of the group that holds an object; empty for the root.
std::string parentOf(const std::string& path);

struct Hdf5Object {
  bool is_dataset = false;
  /// True for a further name, by a soft link.
  bool is_link = false;
  /// Lengths of a data set, the slowest axis first.
  AxisNumbers shape;
  /// "uint16"; empty for anything but numbers.
  std::string type;
  /// The numbers of a short list, such as the coordinates of an axis.
  std::vector<double> values;
  /// The paths of the dimension scales, one for each axis, empty for an axis without one; none for a data set without
  /// scales.
  std::vector<std::string> scales;
  JsonNode attributes;

  std::optional<std::string> text(const std::string& attribute) const;
  std::optional<double> number(const std::string& attribute) const;
  std::vector<double> numbers(const std::string& attribute) const;
  std::vector<std::string> texts(const std::string& attribute) const;
};

class Hdf5Objects {
 public:
  /// `json` is the answer to hdf5::Request::kDescribe. throws: Error kFormat, kBudget.
  Hdf5Objects(const std::filesystem::path& file, std::string json, std::uint64_t memory_bytes);

  const Hdf5Object* find(const std::string& path) const;
  bool hasDataset(const std::string& path) const;
  const std::map<std::string, Hdf5Object>& all() const { return all_; }
  /// True if groups of other files have objects that are not described.
  bool areOthersCut() const { return are_others_cut_; }
  /// Data sets that may be volumes: numbers along three axes of two entries and more.
  std::vector<std::string> volumes() const;

 private:
  std::map<std::string, Hdf5Object> all_;
  bool are_others_cut_ = false;
};

/// The end of errors and notes on a file of which `areOthersCut`.
inline constexpr const char* kOthersAreCut =
    "groups of other files that this file leads to have more objects than are listed; FILE:/PATH names a data set";

}  // namespace kiln
