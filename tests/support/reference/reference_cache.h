// Reference pictures take minutes: they are kept on disk under the hash of everything that they depend on.
#pragma once

#include <filesystem>
#include <optional>

#include "support/reference/reference_renderer.h"

namespace kiln::test {

/// The pictures of one volume and the hash of it.
class ReferencePictures {
 public:
  /// Without a `folder` every picture is made anew. requires: `volume` outlives this.
  ReferencePictures(const DenseVolume& volume, std::optional<std::filesystem::path> folder);

  /// referenceImage over nothing, from the folder where it is there. throws: Error where the folder cannot be written.
  Image draw(const View& view, const TransferFunction& transfer_function, const Shading& shading,
             const ReferenceSettings& settings) const;

 private:
  const DenseVolume& volume_;
  std::optional<std::filesystem::path> folder_;
  std::string volume_key_;
};

}  // namespace kiln::test
