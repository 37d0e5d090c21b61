#include "frame/pass/channels_pass.h"

#include <algorithm>
#include <utility>

#include "base/thread/parallel.h"
#include "image/image.h"

namespace kiln {
namespace {

FrameRequest requestOfChannel(const FrameRequest& request, const VolumeRequest& volume) {
  FrameRequest out = request;
  out.transfer_function = volume.transfer_function;
  out.clipping = volume.clipping;
  out.volumes.clear();
  return out;
}

// Adds the light of a channel to the picture.
void addLight(const Image& channel, const TilePixels& to) {
  parallelFor(static_cast<std::size_t>(channel.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    const float* from = channel.pixel(0, y);
    float* pixel = to.rgba + 4 * to.placeOf(to.rect.x0, to.rect.y0 + y);
    for (int x = 0; x < channel.width; ++x, from += 4, pixel += 4) {
      for (int c = 0; c < 3; ++c) pixel[c] += from[c];
      pixel[3] = std::max(pixel[3], from[3]);
    }
  });
}

}  // namespace

ChannelsPass::ChannelsPass(const std::vector<const BrickedVolume*>& stores, const FrameRequest& request,
                           MakePass make) {
  for (std::size_t i = 0; i < request.volumes.size(); ++i) {
    Channel channel;
    channel.request = std::make_unique<const FrameRequest>(requestOfChannel(request, request.volumes[i]));
    channel.pass = make(*stores.at(i), *channel.request, static_cast<int>(i));
    channels_.push_back(std::move(channel));
  }
}

std::vector<BrickOfFrame> ChannelsPass::inView(const PixelRect& pixels, BrickWalkCounts& counts) const {
  std::vector<BrickOfFrame> out;
  counts = {};
  for (const Channel& channel : channels_) {
    BrickWalkCounts walked;
    const std::vector<BrickOfFrame> bricks = channel.pass->inView(pixels, walked);
    out.insert(out.end(), bricks.begin(), bricks.end());
    counts.add(walked);
  }
  return out;
}

std::uint64_t ChannelsPass::steps(const PixelRect& pixels) const {
  std::uint64_t out = 0;
  for (const Channel& channel : channels_) out += channel.pass->steps(pixels);
  return out;
}

PixelRect ChannelsPass::draw(const PassTarget& target, PassContext& context) {
  const PixelRect& rect = target.pixels.rect;
  for (Channel& channel : channels_) {
    Image picture(rect.width(), rect.height());
    const TilePixels pixels{rect, picture.pixel(0, 0), std::ptrdiff_t{4} * picture.width, {}};
    std::swap(context.costs.walked, channel.walked);
    channel.pass->draw({pixels, target.visibility, target.opacity_threshold}, context);
    std::swap(context.costs.walked, channel.walked);
    addLight(picture, target.pixels);
  }
  context.costs.walked = {};
  for (const Channel& channel : channels_) context.costs.walked.add(channel.walked);
  return rect;
}

std::uint64_t ChannelsPass::scratchBytes() const {
  std::uint64_t out = 0;
  for (const Channel& channel : channels_) out = std::max(out, channel.pass->scratchBytes());
  return out;
}

}  // namespace kiln
