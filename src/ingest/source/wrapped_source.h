// A source that reads another source. A derived class changes the description, or the voxels.
#pragma once

#include <memory>
#include <utility>

#include "ingest/source/volume_source.h"

namespace kiln {

class WrappedSource : public VolumeSource {
 public:
  explicit WrappedSource(std::unique_ptr<VolumeSource> source) : info_(source->info()), source_(std::move(source)) {}

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return source_->order(); }
  void read(const VoxelBox& box, std::span<std::byte> out) override { source_->read(box, out); }
  void finish() override {
    source_->finish();
    info_.notes = source_->info().notes;
  }
  std::uint64_t decodeBytes() const override { return source_->decodeBytes(); }
  std::uint64_t heldBytes() const override { return source_->heldBytes(); }
  Extent3 cheapBox() const override { return source_->cheapBox(); }
  std::optional<DecodedBlocks> decodedBlocks() const override { return source_->decodedBlocks(); }
  void willRead(const BrickOrder& order) override { source_->willRead(order); }
  void keepDecoded(std::uint64_t bytes) override { source_->keepDecoded(bytes); }

 protected:
  SourceInfo info_;

 private:
  std::unique_ptr<VolumeSource> source_;
};

}  // namespace kiln
