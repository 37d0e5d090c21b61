// Values from a part of a volume. Known because a small volume is counted whole, as a conversion counts, and because
// the values of the large volumes grow evenly along an axis.
#include "convert/volume_sample.h"

#include <gtest/gtest.h>

#include <cstring>

#include "base/progress.h"
#include "convert/convert.h"
#include "ingest/open_source.h"
#include "ingest/source/wrapped_source.h"
#include "store/manifest/read_manifest.h"
#include "support/files/foreign_files.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// A volume of bytes, too large to keep, whose value depends on the coordinate along one axis: sixteen equal steps.
class StepSource : public VolumeSource {
 public:
  StepSource(const Extent3& dims, int axis, ReadOrder order) : axis_(axis), order_(order) {
    info_.geometry.dims = dims;
    info_.files = {"steps.raw"};
  }
  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return order_; }
  void read(const VoxelBox& box, std::span<std::byte> out) override {
    read_bytes_ += out.size();
    const Extent3& dims = info_.geometry.dims;
    if (order_ == ReadOrder::kForward && (box.lo.z * dims.y + box.lo.y) * dims.x != next_) ADD_FAILURE() << "backwards";
    next_ += box.count();
    const auto row = static_cast<std::size_t>(box.extent().x);
    for (std::size_t i = 0; i * row < out.size(); ++i) {
      const auto y = static_cast<std::int64_t>(i) % box.extent().y, z = static_cast<std::int64_t>(i) / box.extent().y;
      const std::int64_t at = axis_ == 1 ? box.lo.y + y : box.lo.z + z;
      std::memset(&out[i * row], static_cast<int>(at * 16 / dims[axis_]), row);
    }
  }
  std::uint64_t readBytes() const { return read_bytes_; }

 private:
  SourceInfo info_;
  int axis_;
  ReadOrder order_;
  std::uint64_t read_bytes_ = 0;
  std::int64_t next_ = 0;
};

void expectEvenSteps(StepSource& source) {
  Progress silent;
  const VolumeSample sample = sampleOf(source, UINT64_MAX, silent);
  EXPECT_EQ(sample.voxels, source.readBytes());
  EXPECT_LE(sample.voxels, kSampleBytes);
  EXPECT_GE(sample.voxels, kSampleBytes / 2);
  EXPECT_FALSE(sample.from_begin);
  EXPECT_EQ(sample.manifest.range, (ValueRange{0, 15}));
  std::vector<std::uint64_t> steps;
  for (const std::uint64_t count : sample.manifest.histogram.counts)
    if (count > 0) steps.push_back(count);
  ASSERT_EQ(steps.size(), 16u);
  for (const std::uint64_t count : steps)
    EXPECT_NEAR(static_cast<double>(count), static_cast<double>(sample.voxels) / 16,
                0.35 * static_cast<double>(sample.voxels) / 16);
}

TEST(VolumeSample, OfALargeVolume_IsEvenlySpread) {
  StepSource along_z({512, 256, 4096}, 2, ReadOrder::kAnyBox);
  expectEvenSteps(along_z);
  // Slices of 64 MiB are sampled in bands, whose number divides the number of boxes.
  StepSource along_y({4096, 16384, 64}, 1, ReadOrder::kAnyBox);
  expectEvenSteps(along_y);
}

TEST(VolumeSample, OfALongStream_IsItsBegin) {
  StepSource stream({4096, 4096, 32}, 2, ReadOrder::kForward);
  Progress silent;
  const VolumeSample sample = sampleOf(stream, UINT64_MAX, silent);
  EXPECT_TRUE(sample.from_begin);
  EXPECT_EQ(sample.voxels, kStreamSampleBytes);
  EXPECT_EQ(sample.manifest.range, (ValueRange{0, 7}));
}

// A volume whose header states labels.
class LabelledSource : public WrappedSource {
 public:
  explicit LabelledSource(std::unique_ptr<VolumeSource> source) : WrappedSource(std::move(source)) {
    info_.volume_class = VolumeClass::kLabels;
  }
};

TEST(VolumeSample, OfLabels_HasABinForEachLabel) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({31, 17, 9}, VoxelType::u16, 6);
  SourceOptions described;
  described.dims = volume.dims, described.type = volume.type;
  LabelledSource source(openSource(files.write("v.raw", volume.stored(false)), described));
  Progress silent;
  const VolumeSample sample = sampleOf(source, UINT64_MAX, silent);
  convert(source, files.directory() / "v.kiln", {}, silent);
  const Manifest whole = readManifest(files.directory() / "v.kiln");
  EXPECT_EQ(sample.manifest.histogram.lo, whole.histogram.lo);
  EXPECT_EQ(sample.manifest.histogram.hi, whole.histogram.hi);
  EXPECT_EQ(sample.manifest.histogram.counts, whole.histogram.counts);
}

TEST(VolumeSample, OfASmallVolume_IsWhatAConversionCounts) {
  const ForeignFiles files;
  Progress silent;
  for (const VoxelType type : {VoxelType::u8, VoxelType::i16, VoxelType::f32}) {
    const ForeignVolume volume = randomVolume({31, 17, 9}, type, 5);
    const auto raw = files.write("v.raw", volume.stored(false));
    SourceOptions options;
    options.dims = volume.dims, options.type = type;
    const std::unique_ptr<VolumeSource> source = openSource(raw, options);
    const VolumeSample sample = sampleOf(*source, UINT64_MAX, silent);
    EXPECT_EQ(sample.voxels, 31u * 17 * 9);
    ConvertOptions convert_options;
    convert_options.overwrite = true;
    convert(*source, files.directory() / "v.kiln", convert_options, silent);
    const Manifest whole = readManifest(files.directory() / "v.kiln");
    EXPECT_EQ(sample.manifest.range, whole.range);
    EXPECT_EQ(sample.manifest.histogram.counts, whole.histogram.counts);
    EXPECT_EQ(sample.manifest.histogram.hi, whole.histogram.hi);
  }
}

TEST(VolumeSample, ThatDoesNotFitTheMemory_IsRefused) {
  StepSource source({4096, 4096, 4}, 2, ReadOrder::kAnyBox);
  Progress silent;
  expectError([&] { sampleOf(source, 1 << 17, silent); }, ErrorCode::kBudget,
              "steps.raw: --memory: 128.0 KiB is too little");
}

}  // namespace
}  // namespace kiln::test
