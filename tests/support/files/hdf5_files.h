// HDF5 files written by the HDF5 library, for the tests of the reader. Chunks of filters that the library lacks are
// written as bytes, encoded by the test.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "support/files/foreign_files.h"

namespace kiln::test {

struct Hdf5Filter {
  int id = 0;
  std::vector<unsigned> values;
};

struct Hdf5Dataset {
  /// Shape of the data set, the slowest axis first; the volume's dims by default.
  std::vector<std::uint64_t> shape{};
  /// Empty for a contiguous data set.
  std::vector<std::uint64_t> chunk{};
  bool big_endian = false, compact = false;
  /// The library's own filters.
  bool shuffle = false, fletcher32 = false, scale_offset = false;
  /// Chunks beyond the shape are stored without filters.
  bool raw_border = false;
  std::optional<int> deflate{};
  /// A filter that the library need not have. `encode` makes the bytes of each chunk.
  std::optional<Hdf5Filter> foreign{};
  std::function<std::string(const std::string&)> encode{};
  std::optional<double> fill{};
  /// False leaves all chunks unwritten.
  bool written = true;
};

class Hdf5File {
 public:
  /// throws: std::runtime_error, as all members do.
  explicit Hdf5File(const std::filesystem::path& path, std::uint64_t user_block_bytes = 0);
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  /// Groups of the path are made.
  void add(const std::string& path, const ForeignVolume& volume, const Hdf5Dataset& dataset = {});
  void addNumbers(const std::string& path, const std::vector<double>& numbers,
                  const std::vector<std::uint64_t>& shape = {});
  /// A virtual data set over `source` of another file.
  void addVirtual(const std::string& path, const Extent3& dims, const std::string& file, const std::string& source);
  void addGroup(const std::string& path);
  /// A soft link, which may lead nowhere.
  void link(const std::string& path, const std::string& target);
  void linkOutside(const std::string& path, const std::string& file, const std::string& target);
  /// Makes `scales` the dimension scales of a data set, as NetCDF does; an empty path is none.
  void setScales(const std::string& dataset, const std::vector<std::string>& scales);
  void setText(const std::string& object, const std::string& name, const std::string& text);
  void setTexts(const std::string& object, const std::string& name, const std::vector<std::string>& texts);
  /// Texts of one length, padded with spaces, as Fortran writes them.
  void setPaddedTexts(const std::string& object, const std::string& name, const std::vector<std::string>& texts);
  /// One letter an element, as Imaris writes texts.
  void setLetters(const std::string& object, const std::string& name, const std::string& text);
  void setNumbers(const std::string& object, const std::string& name, const std::vector<double>& numbers);

 private:
  std::int64_t file_ = -1;
};

}  // namespace kiln::test
