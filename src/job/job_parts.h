// Objects of a job in other documents: a suite of measurements has cameras, materials and transfer functions under the
// same keys.
#pragma once

#include "job/json/job_json.h"
#include "job/render_job.h"

namespace kiln {

/// Each reads an object. throws: Error kUsage naming the key.
CameraSpec cameraFrom(const JobObject& object);
Shading shadingFrom(const JobObject& object);
Light lightFrom(const JobObject& object);

/// Reads a transfer function from a key of `owner`: a preset, points (job/json/points_text.h), a file beside the
/// document, or the function itself; nothing where the key is absent. throws: Error kUsage for other values.
std::optional<TransferFunctionChoice> transferFunctionChoiceFrom(const JobObject& owner,
                                                                 std::string_view key = "transferFunction");

/// Replaces the planes by `clip`, except faces of a box of the world.
void replaceClipPlanes(const JobObject& owner, Clipping& clipping);
/// Reads `true`, `false`, or a section.
void readSection(const JobObject& owner, std::string_view key, std::optional<Section>& out);
void readPart(const JobObject& root, PictureOptions& picture);
void readVolumes(const JobObject& root, RenderJob& job);

}  // namespace kiln
