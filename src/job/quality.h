// Options that `--quality` stands for.
#pragma once

namespace kiln {

struct PictureOptions;

enum class Quality { kDraft, kGood, kBest };

/// Sets the options that a quality stands for. An engine without an option keeps its default.
void setQuality(Quality quality, PictureOptions& picture);

/// Moves the options of a quality from the engine of `before` to the engine of the picture. Other values are the user's
/// and stay.
void followEngine(Quality quality, const PictureOptions& before, PictureOptions& picture);

}  // namespace kiln
