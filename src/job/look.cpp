#include "job/look.h"

namespace kiln {

void setLook(Look look, PictureOptions& picture) {
  const bool studio = look == Look::kStudio;
  picture.shading = studio ? studioShading() : Shading();
  picture.display.tone = studio ? Tone::kSoft : Tone::kClip;
}

}  // namespace kiln
