#include "job_arguments.h"

#include <algorithm>

#include "job/render_job.h"

namespace kiln::tool {

void JobArguments::addTo(CLI::App& command, OptionGroup group) {
  for (const JobFlag& flag : jobFlags()) {
    if (flag.group != group) continue;
    CLI::Option* option = nullptr;
    if (flag.arguments == JobFlag::Arguments::kNone) {
      option = command.add_flag(flag.flag);
    } else {
      option = command.add_option(flag.flag)->type_name(flag.value_name);
      if (flag.arguments != JobFlag::Arguments::kOne)
        option->expected(1, CLI::detail::expected_max_vector_size)->allow_extra_args(false);
      if (flag.arguments == JobFlag::Arguments::kList) option->delimiter(',');
    }
    if (flag.refusal) option->check(CLI::Validator([&flag](std::string& text) { return flag.refusal(text); }, ""));
    option->description(flag.help)->group(nameOf(group));
    arguments_.push_back({&flag, option});
  }
  std::sort(arguments_.begin(), arguments_.end(), [](const Argument& a, const Argument& b) { return a.flag < b.flag; });
}

std::optional<std::string> JobArguments::text(std::string_view flag) const {
  for (const auto& [row, option] : arguments_) {
    if (option->count() > 0 && option->check_name(std::string(flag))) return option->results().front();
  }
  return std::nullopt;
}

bool JobArguments::has(std::string_view flag) const { return text(flag).has_value(); }

bool JobArguments::hasAny(std::initializer_list<std::string_view> flags) const {
  return std::any_of(flags.begin(), flags.end(), [&](std::string_view flag) { return has(flag); });
}

void JobArguments::apply(RenderJob& job) const {
  for (const auto& [flag, option] : arguments_) {
    if (option->count() > 0) flag->apply(option->results(), job);
  }
}

}  // namespace kiln::tool
