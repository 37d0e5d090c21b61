#include "job/quality.h"

#include "job/job_facts.h"
#include "job/render_job.h"
#include "scene/sampling.h"

namespace kiln {
namespace {

int coarserOf(Quality quality, const PictureOptions& picture) {
  return quality == Quality::kDraft && engineOf(picture).capabilities().coarser_levels ? 1 : 0;
}

double sampleDistanceOf(Quality quality, const PictureOptions& picture) {
  if (quality == Quality::kGood || !engineOf(picture).capabilities().sample_distance) return kSampleDistance;
  return quality == Quality::kDraft ? kMostSampleDistance : kLeastSampleDistance;
}

}  // namespace

void setQuality(Quality quality, PictureOptions& picture) {
  picture.samples.reset();
  if (quality != Quality::kGood) picture.samples = quality == Quality::kDraft ? 1 : 16;
  picture.level.reset();
  picture.coarser = coarserOf(quality, picture);
  picture.sample_distance = sampleDistanceOf(quality, picture);
}

void followEngine(Quality quality, const PictureOptions& before, PictureOptions& picture) {
  if (picture.coarser == coarserOf(quality, before)) picture.coarser = coarserOf(quality, picture);
  if (picture.sample_distance == sampleDistanceOf(quality, before))
    picture.sample_distance = sampleDistanceOf(quality, picture);
}

}  // namespace kiln
