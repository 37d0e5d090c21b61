#include "support/volumes/conversions.h"

#include <gtest/gtest.h>

#include "convert/plan.h"
#include "support/volumes/test_store.h"

namespace kiln::test {

std::map<std::string, std::vector<std::byte>> storeFiles(const std::filesystem::path& store) {
  auto out = filesOf(store);
  out.erase("manifest.json");
  return out;
}

ConvertOptions smallBricks() {
  ConvertOptions out;
  out.brick_size = 32;
  out.overwrite = true;
  return out;
}

std::map<std::string, std::vector<std::byte>> convertedInOneLane(VolumeSource& source) {
  const std::filesystem::path out = freshDirectory("store") / "volume.kiln";
  ConvertOptions options = smallBricks();
  const ConversionPlan ample = planConversion(source, options);
  options.memory_bytes = ample.source_bytes + ample.lane_bytes + ample.index_bytes;
  Progress silent;
  EXPECT_LE(convert(source, out, options, silent).buffer_bytes, options.memory_bytes);
  return storeFiles(out);
}

ChangingSource::ChangingSource(std::unique_ptr<VolumeSource> source, int at_read, std::function<void()> change)
    : WrappedSource(std::move(source)), at_read_(at_read), change_(std::move(change)) {}

void ChangingSource::read(const VoxelBox& box, std::span<std::byte> out) {
  if (++reads_ == at_read_) change_();
  WrappedSource::read(box, out);
}

}  // namespace kiln::test
