// A finished picture in memory: linear light, premultiplied alpha, and further numbers per pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/memory/zero_pages.h"

namespace kiln {

class DeepSamples;

/// Bound of the samples of a deep picture (image/deep_samples.h).
struct DeepBound {
  static constexpr int kMostSamples = 1024;
  int samples = 24;  // upper bound per pixel; from 1 to kMostSamples
  /// Neighbours are merged while a cut at any depth of the pixel changes the composite in front of the cut by at most
  /// this value in every channel. Exceeded only if a pixel has more than `samples` layers.
  float error = 0;
};

/// One further number per pixel. shape: height rows of width floats, row 0 at the top.
struct Plane {
  std::string name;  // name of the EXR channel
  ZeroPages<float> values;
};

/// shape: height rows of width pixels of 4 floats R G B A, row 0 at the top; empty if the picture has planes only.
/// unit: linear, premultiplied.
struct Image {
  int width = 0, height = 0;
  ZeroPages<float> rgba;
  std::vector<Plane> planes;
  std::shared_ptr<DeepSamples> deep;  // per pixel, in coordinates of the whole picture; null unless requested

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgba(static_cast<std::size_t>(w) * h * 4) {}
  float* pixel(int x, int y) { return rgba.data() + (static_cast<std::size_t>(y) * width + x) * 4; }
  /// The memory of colours and planes. unit: bytes.
  std::uint64_t bytes() const {
    std::uint64_t floats = rgba.size();
    for (const Plane& plane : planes) floats += plane.values.size();
    return floats * sizeof(float);
  }
  const float* pixel(int x, int y) const { return rgba.data() + (static_cast<std::size_t>(y) * width + x) * 4; }
};

/// The colours of a file: linear light as in an EXR, or colours to look at, as in a PNG and a video.
enum class Medium { kLight, kDisplay };

/// - kClip: light beyond 1 is shown as 1, channel by channel.
/// - kSoft: light beyond a knee approaches 1 (image/display.h).
enum class Tone { kClip, kSoft };

/// Mapping of linear light to shown light.
struct Display {
  double exposure = 0;  // unit: stops; each doubles the light
  Tone tone = Tone::kClip;
  bool operator==(const Display&) const = default;
};

}  // namespace kiln
