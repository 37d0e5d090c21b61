// Shows linear light in a PNG or a video: an exposure, then a tone curve that leaves room for highlights.
//
// The curve keeps colours up to the knee k = 0.7. Beyond the knee, the largest channel m of a colour becomes
// k + (1 - k)·s / (1 + s) with s = (m - k) / (1 - k): its slope at the knee is 1, and it stays below 1. The other
// channels keep their ratio to the largest, so that a highlight keeps its hue instead of clipping channel by channel.
// Source: the hyperbola of Reinhard et al. 2002, used beyond the knee alone.
#pragma once

#include "image/image.h"

namespace kiln {

inline constexpr double kToneKnee = 0.7;

/// Returns whether light is shown as it is drawn.
inline bool showsAsDrawn(const Display& display) { return display == Display(); }

/// Returns the largest channel of a shown colour. requires: light >= 0.
constexpr double softTone(double light) {
  if (!(light > kToneKnee)) return light;
  const double beyond = (light - kToneKnee) / (1 - kToneKnee);
  return kToneKnee + (1 - kToneKnee) * (beyond / (1 + beyond));
}

/// Replaces the colours by the shown ones. A colour is the light divided by alpha; alpha stays.
void show(const Display& display, Image& image);

}  // namespace kiln
