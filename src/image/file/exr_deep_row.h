// A row of deep samples in OpenEXR's layout: values channel by channel, and a pointer per pixel. Not installed: the
// header names OpenEXR.
#pragma once

#include <ImfDeepFrameBuffer.h>
#include <ImfPixelType.h>
#include <half.h>

#include <cstddef>
#include <deque>
#include <numeric>
#include <string>
#include <vector>

namespace kiln {

class DeepRow {
 public:
  explicit DeepRow(int width) : counts_(static_cast<std::size_t>(width)) {}

  /// Adds a HALF or FLOAT channel. requires: called before frameBuffer.
  void addChannel(std::string name, Imf::PixelType type) {
    channels_.push_back({std::move(name), type, {}, std::vector<char*>(counts_.size())});
  }
  /// The frame buffer for all rows of a file; every row uses the same memory. `first_x` is that of the data window.
  Imf::DeepFrameBuffer frameBuffer(int first_x) {
    Imf::DeepFrameBuffer out;
    const auto before = static_cast<std::ptrdiff_t>(first_x);
    out.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts_.data() - before), sizeof(unsigned), 0));
    for (Channel& channel : channels_)
      out.insert(channel.name, Imf::DeepSlice(channel.type, reinterpret_cast<char*>(channel.at.data() - before),
                                              sizeof(char*), 0, bytesOf(channel.type)));
    return out;
  }
  std::vector<unsigned>& counts() { return counts_; }
  std::size_t samples() const { return std::accumulate(counts_.begin(), counts_.end(), std::size_t{0}); }
  /// Allocates the samples counted in `counts`.
  void layOut() {
    const std::size_t all = samples();
    for (Channel& channel : channels_) {
      const std::size_t bytes = bytesOf(channel.type);
      channel.bytes.resize(all * bytes);
      char* place = channel.bytes.data();
      for (std::size_t x = 0; x < counts_.size(); ++x, place += bytes * counts_[x - 1]) channel.at[x] = place;
    }
  }
  /// Values of all samples of the row. requires: T is the channel's type, half or float.
  template <class T>
  T* values(std::size_t channel) {
    return reinterpret_cast<T*>(channels_[channel].bytes.data());
  }

 private:
  struct Channel {
    std::string name;
    Imf::PixelType type;
    std::vector<char> bytes;
    std::vector<char*> at;
  };
  static std::size_t bytesOf(Imf::PixelType type) { return type == Imf::HALF ? sizeof(half) : sizeof(float); }

  std::vector<unsigned> counts_;
  std::deque<Channel> channels_;
};

}  // namespace kiln
