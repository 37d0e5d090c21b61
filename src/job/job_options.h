// The tables of options, one for each object of a job. job/README.md says how to add a row.
#pragma once

#include "job/option_kinds.h"
#include "job/render_job.h"

namespace kiln {

/// The newest version of the language of jobs and transfer function files; earlier versions are read, too. Since 2,
/// colours of transfer functions are sRGB by default.
inline constexpr int kJobFormat = 2;

/// The key "kiln" of a document. JobObject::format holds the number for all of the document.
template <class Owner>
OptionValue<Owner> formatValue() {
  const WholeChoice kind{.numbers = {1, kJobFormat}};
  return OptionValue<Owner>::custom(
      kind.form(),
      [kind](const JobObject& object, std::string_view key, Owner&) {
        int format = 0;
        kind.read(object, key, format);
      },
      [](const Owner&) { return kJobFormat; });
}

/// The job itself, with the objects that it holds once.
const Options<RenderJob>& jobOptions();

/// The camera of a job, with its path.
const Options<RenderJob>& cameraObjectOptions();

/// Objects that a job may hold several times, or that other documents hold too.
const Options<CameraSpec>& cameraOptions();
const Options<Turntable>& turntableOptions();
const Options<Stereo>& stereoOptions();
const Options<Lens>& lensOptions();
const Options<Shading>& shadingOptions();
const Options<Shadow>& shadowOptions();
const Options<AmbientOcclusion>& occlusionOptions();
const Options<Light>& lightOptions();
const Options<ClipPlane>& clipPlaneOptions();
const Options<Section>& sectionOptions();
/// The legal values of a section, and their text.
OptionForm sectionForm();
const Options<Annotations>& annotationOptions();
const ListOf<VolumeOptions>& volumeList();
const ListOf<Light>& lightList();
const ListOf<ClipPlane>& clipPlaneList();
const Options<TransferFunction>& transferFunctionOptions();
const Options<TransferPoint>& pointOptions();
const Options<IsoSurface>& surfaceOptions();
const Options<GradientPoint>& gradientPointOptions();
const Options<GradientRegion>& gradientRegionOptions();
const Options<GradientTable>& gradientTableOptions();
const Options<Scattering>& scatteringOptions();
const Options<LabelStyle>& labelOptions();
const Options<VolumeOptions>& volumeOptions();
const Options<MaskChoice>& maskOptions();
const Options<ColorByChoice>& colorByOptions();
const Options<OutputFile>& outputFileOptions();

/// Ends an error.
inline constexpr std::string_view kMissingInterocular = "it is the distance between both eyes";

/// The ranges with a name in the schema.
std::vector<SharedRange> sharedRanges();

/// Keyframes, and the schema of a list of keyframes.
nlohmann::ordered_json keyframesSchema(std::string_view key);
const Options<Key<CameraSpec>>& cameraKeyOptions();
const Options<Key<Stereo>>& stereoKeyOptions();
const Options<Key<TransferFunctionChoice>>& functionKeyOptions();
const Options<Key<std::vector<Light>>>& lightsKeyOptions();
const Options<Key<std::vector<ClipPlane>>>& clipKeyOptions();

}  // namespace kiln
