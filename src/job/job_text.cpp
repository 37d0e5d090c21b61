// Writes a job with every choice made. Leaves out speed and names of outputs, so that equal pictures have equal EXR
// headers.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "job/job_options.h"
#include "store/manifest/json_text.h"

namespace kiln {
namespace {

using nlohmann::ordered_json;

// Returns the camera as a job that sets every key.
CameraSpec specOf(const Camera& camera) {
  CameraSpec out;
  out.projection = camera.projection;
  if (camera.projection == Projection::kPerspective) out.fov_deg = camera.fov_deg;
  if (camera.projection == Projection::kOrthographic) out.height = camera.height;
  out.eye = camera.eye;
  out.target = camera.target;
  out.up = camera.up;
  return out;
}

bool isPoint(const ordered_json& value) {
  const auto is_number = [](const ordered_json& number) { return number.is_number(); };
  return value.is_array() && value.size() <= 4 && std::all_of(value.begin(), value.end(), is_number);
}

// "[0.5, 1, -3]", with digits for people.
std::string pointText(const ordered_json& point) {
  return fmt::format("[{:g}]", fmt::join(point.get<std::vector<double>>(), ", "));
}

// Collects the differences between two values at the same place of two jobs.
void addDifferences(const ordered_json& there, const ordered_json& here, const std::string& place,
                    std::vector<std::string>& out) {
  if (there == here || there.is_discarded() || here.is_discarded()) return;
  // A moved store is the same volume.
  const auto is_name = [](const std::string& key, const ordered_json& value) {
    return key == "volume" && value.is_string();
  };
  const auto at = [&](const std::string& key) { return place.empty() ? key : place + "." + key; };
  if (there.is_object() && here.is_object()) {
    for (const auto& [key, value] : there.items()) {
      if (is_name(key, value)) continue;
      if (here.contains(key))
        addDifferences(value, here[key], at(key), out);
      else
        out.push_back(at(key) + " is there and not here");
    }
    for (const auto& [key, value] : here.items())
      if (!there.contains(key) && !is_name(key, value)) out.push_back(at(key) + " is here and not there");
  } else if (isPoint(there) && isPoint(here) && there.size() == here.size()) {
    const bool differ = pointText(there) != pointText(here);
    out.push_back(fmt::format("{} is {} there and {} here", place, differ ? pointText(there) : there.dump(),
                              differ ? pointText(here) : here.dump()));
  } else if (there.is_array() && here.is_array() && there.size() == here.size()) {
    std::vector<std::string> of_entries;
    std::size_t entries = 0;
    for (std::size_t i = 0; i < there.size(); ++i) {
      const std::size_t before = of_entries.size();
      addDifferences(there[i], here[i], fmt::format("{}[{}]", place, i), of_entries);
      entries += of_entries.size() > before ? 1 : 0;
    }
    if (entries > 1) of_entries = {fmt::format("{} differs in {} of {} entries", place, entries, there.size())};
    out.insert(out.end(), of_entries.begin(), of_entries.end());
  } else if (there.is_structured() || here.is_structured()) {
    out.push_back(place + " is another");
  } else {
    out.push_back(fmt::format("{} is {} there and {} here", place, there.dump(), here.dump()));
  }
}

// The format of a resolved job; 0 for other texts.
double formatOf(const ordered_json& job) {
  const auto format = job.is_object() ? job.find("kiln") : job.end();
  return format != job.end() && format->is_number() ? format->get<double>() : 0;
}

}  // namespace

std::string resolvedJobText(const RenderJob& job, const Camera& camera, const TransferFunction& transfer_function) {
  RenderJob resolved = job;
  resolved.picture.camera = specOf(camera);
  resolved.picture.transfer_function = transfer_function;
  return jsonText(resolvedJson(jobOptions(), resolved), 2) + "\n";
}

std::string jobDifference(const std::string& text_there, const std::string& text_here) {
  constexpr std::size_t kMostSaid = 3;
  const auto parsed = [](const std::string& text) { return ordered_json::parse(text, nullptr, false); };
  const ordered_json there = parsed(text_there), here = parsed(text_here);
  // Keys of different formats are not comparable.
  if (const double format = formatOf(there); format != formatOf(here))
    return fmt::format("it was drawn by {} Kiln, whose jobs have format {} instead of {}",
                       format < formatOf(here) ? "an earlier" : "a later", format, formatOf(here));
  std::vector<std::string> differences;
  addDifferences(there, here, "", differences);
  // A camera that is not given follows the shown part of the volume, which other options choose.
  std::ranges::stable_partition(differences, [](const std::string& each) { return !each.starts_with("camera"); });
  std::string out;
  for (std::size_t i = 0; i < std::min(differences.size(), kMostSaid); ++i) out += (i > 0 ? ", " : "") + differences[i];
  if (differences.size() > kMostSaid) out += fmt::format(", and {} more", differences.size() - kMostSaid);
  return out;
}

}  // namespace kiln
