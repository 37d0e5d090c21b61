#include "python/job_words.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "base/error.h"
#include "base/nearest_word.h"
#include "base/text.h"
#include "job/job_options.h"
#include "job/json/job_json.h"
#include "job/transfer_function_json.h"

namespace kiln::python {
namespace {

std::int64_t wholeOf(const std::string& name, const std::string& text) {
  const std::optional<std::int64_t> value = decimalOf<std::int64_t>(text);
  if (!value || *value < 0)
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected a whole number from 0 on, found '{}'", name, text));
  return *value;
}

bool isOn(const std::string& name, const std::string& text) {
  if (text != "on" && text != "off")
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected on or off (found '{}'); give True or False", name, text));
  return text == "on";
}

// Returns the items of a list, "depth,normal", as the command line divides them.
std::vector<std::string> itemsOf(const std::vector<std::string>& texts) {
  std::vector<std::string> out;
  for (const std::string& text : texts) {
    for (const std::string_view item : splitAt(text, ',')) out.emplace_back(item);
  }
  return out;
}

}  // namespace

GivenFlags givenFlags(const Texts& texts) {
  GivenFlags out;
  std::size_t found = 0;
  for (const JobFlag& flag : jobFlags()) {
    if (const auto given = texts.find(nameOfFlag(flag.flag)); given != texts.end())
      out.add(flag, flag.arguments == JobFlag::Arguments::kList ? itemsOf(given->second) : given->second), ++found;
  }
  if (found == texts.size()) return out;
  std::vector<std::string> names;
  for (const JobFlag& flag : jobFlags()) names.push_back(nameOfFlag(flag.flag));
  const std::vector<std::string_view> known(names.begin(), names.end());
  for (const auto& [name, unused] : texts) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: is no option of a picture; the nearest is {}", name, nearestWord(name, known)));
  }
  return out;
}

TransferFunctionChoice functionOf(const std::string& text) {
  if (text.starts_with('{')) return transferFunctionFrom(JobObject::parse(text, "tf"));
  RenderJob job;
  givenFlags({{"--tf", {text}}}).apply(job);
  return job.picture.transfer_function;
}

RenderJob jobOf(const std::filesystem::path& volume, const JobWords& words, const AddedVolumes& more) {
  RenderJob job = words.json.empty() ? RenderJob() : parseJob(words.json, {});
  job.volume = volume;
  const GivenFlags flags = givenFlags(words.flags);
  applyGiven(flags, job);
  if (!words.function.empty()) job.picture.transfer_function = functionOf(words.function);
  addVolumes(more, flags, job);
  return job;
}

SourceWords sourceWords(const std::map<std::string, std::string>& texts) {
  SourceWords out;
  const std::map<std::string_view, std::function<void(const std::string&)>> members = {
      {"dims", [&](const std::string& text) { out.dims = text; }},
      {"type", [&](const std::string& text) { out.type = text; }},
      {"endian", [&](const std::string& text) { out.endian = text; }},
      {"spacing", [&](const std::string& text) { out.spacing = text; }},
      {"grid", [&](const std::string& text) { out.grid = text; }},
      {"series", [&](const std::string& text) { out.series = text; }},
      {"flip", [&](const std::string& text) { out.flip = text; }},
      {"orient", [&](const std::string& text) { out.orient = text; }},
      {"unit", [&](const std::string& text) { out.unit = text; }},
      {"up_axis", [&](const std::string& text) { out.up = text; }},
      {"channel", [&](const std::string& text) { out.channel = text; }},
      {"time", [&](const std::string& text) { out.time = wholeOf("time", text); }},
      {"scale", [&](const std::string& text) { out.scale = wholeOf("scale", text); }},
      {"skip", [&](const std::string& text) { out.skip = static_cast<std::uint64_t>(wholeOf("skip", text)); }},
      {"allow_irregular", [&](const std::string& text) { out.allow_irregular = isOn("allow_irregular", text); }},
      {"luminance", [&](const std::string& text) { out.luminance = isOn("luminance", text); }}};
  for (const auto& [name, text] : texts) {
    const auto member = members.find(name);
    if (member == members.end()) {
      std::vector<std::string_view> known;
      for (const auto& [word, unused] : members) known.push_back(word);
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: is no option of a volume file; the nearest is {}", name, nearestWord(name, known)));
    }
    member->second(text);
  }
  return out;
}

void bindWords(py::module_& module) {
  module.attr("job_format") = kJobFormat;
  py::class_<JobWords>(module, "JobWords").def(py::init([](std::string json, Texts flags, std::string function) {
    return JobWords{std::move(json), std::move(flags), std::move(function)};
  }));
  module.def("flags", [] {
    py::list out;
    for (const JobFlag& flag : jobFlags()) {
      const char* const kinds[] = {"none", "one", "several", "list"};
      out.append(py::make_tuple(nameOfFlag(flag.flag), kinds[static_cast<std::size_t>(flag.arguments)],
                                kOptionGroupNames[static_cast<std::size_t>(flag.group)], flag.value_name, flag.help));
    }
    return out;
  });
}

}  // namespace kiln::python
