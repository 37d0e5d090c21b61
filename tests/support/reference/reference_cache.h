// Reference pictures take minutes: they are kept on disk under a hash of all their inputs.
#pragma once

#include <filesystem>
#include <optional>

#include "support/reference/reference_renderer.h"

namespace kiln::test {

/// The pictures of a volume, and the volume's hash.
class ReferencePictures {
 public:
  /// Without a `folder` every picture is drawn again. requires: `volume` outlives the object.
  ReferencePictures(const DenseVolume& volume, std::optional<std::filesystem::path> folder);

  /// Returns referenceImage over a clear background, from the folder if stored. throws: Error if the folder cannot be
  /// written.
  Image draw(const View& view, const TransferFunction& transfer_function, const Shading& shading,
             const ReferenceSettings& settings) const;

 private:
  const DenseVolume& volume_;
  std::optional<std::filesystem::path> folder_;
  std::string volume_key_;
};

}  // namespace kiln::test
