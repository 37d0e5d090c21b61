// Conversions of small volumes. Stores are compared file by file.
#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "convert/convert.h"
#include "ingest/source/wrapped_source.h"

namespace kiln::test {

/// All files of a store by name, except the manifest, which names the source.
std::map<std::string, std::vector<std::byte>> storeFiles(const std::filesystem::path& store);

/// Bricks of 32³ voxels; an older store is replaced.
ConvertOptions smallBricks();

/// Converts to small bricks, with the memory of one lane, and returns the store's files as `storeFiles` does.
std::map<std::string, std::vector<std::byte>> convertedInOneLane(VolumeSource& source);

/// A source that is changed while it is read.
class ChangingSource : public WrappedSource {
 public:
  /// `change` is called once, before read number `at_read`, from 1 on.
  ChangingSource(std::unique_ptr<VolumeSource> source, int at_read, std::function<void()> change);
  void read(const VoxelBox& box, std::span<std::byte> out) override;

 private:
  const int at_read_;
  const std::function<void()> change_;
  std::atomic<int> reads_ = 0;
};

}  // namespace kiln::test
