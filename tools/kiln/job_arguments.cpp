#include "job_arguments.h"

#include <algorithm>

namespace kiln::tool {

void JobArguments::addTo(CLI::App& command, OptionFacts& facts, OptionGroup group, std::string_view left_out) {
  for (const JobFlag& flag : jobFlags()) {
    if (flag.group != group || flag.flag == left_out) continue;
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
    if (!flag.words.empty()) facts.offer(option, flag.words);
    if (flag.may_be_empty) facts.allowEmpty(option);
    arguments_.push_back({&flag, option});
  }
  std::sort(arguments_.begin(), arguments_.end(), [](const Argument& a, const Argument& b) { return a.flag < b.flag; });
}

GivenFlags JobArguments::given() const {
  GivenFlags out;
  for (const auto& [flag, option] : arguments_) {
    if (option->count() > 0) out.add(*flag, option->results());
  }
  return out;
}

}  // namespace kiln::tool
