// The XML file beside an HDF5 file of BigDataViewer: names of the setups, sizes of voxels, and their places.
#pragma once

#include <filesystem>
#include <glm/mat4x4.hpp>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace kiln {

struct BdvDescription {
  struct Setup {
    std::string name, unit;
    std::optional<glm::dvec3> voxel_size;
  };
  std::map<std::int64_t, Setup> setups;
  /// By time and setup.
  std::map<std::pair<std::int64_t, std::int64_t>, glm::dmat4> affines;

  std::string setupName(std::int64_t setup) const;
  std::string unit(std::int64_t setup) const;
  /// By the registration, else by the size of a voxel; nothing if the file has neither.
  std::optional<glm::dmat4> worldFromIndex(std::int64_t time, std::int64_t setup) const;
};

/// Returns nothing if there is no file at `xml`. throws: Error kFormat if the file is no XML, kIo.
std::optional<BdvDescription> readBdvXml(const std::filesystem::path& xml);

/// The XML file beside an HDF5 file of BigDataViewer, read once, when the description is first used.
class BdvXmlBeside {
 public:
  explicit BdvXmlBeside(const std::filesystem::path& image);
  const std::filesystem::path& path() const { return path_; }
  /// Returns nothing if there is no such file. throws: as readBdvXml.
  const std::optional<BdvDescription>& description();

 private:
  std::filesystem::path path_;
  bool is_read_ = false;
  std::optional<BdvDescription> description_;
};

/// Returns the HDF5 file beside a description, which has the name of the description. throws: Error kNotFound.
std::filesystem::path imageOfBdv(const std::filesystem::path& xml);

}  // namespace kiln
