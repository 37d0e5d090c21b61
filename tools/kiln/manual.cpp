#include "manual.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace kiln::tool {
namespace {

// Escapes characters that troff interprets.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
      out += std::string("\\&") + c;
    else
      out += c;
  }
  return out;
}

std::vector<const CLI::App*> commandsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

std::string header(const std::string& title, const std::string& name, const std::string& what) {
  return fmt::format(".TH {} 1 \"\" \"kiln {}\"\n.SH NAME\n{} \\- {}\n", roff(title), KILN_VERSION, roff(name),
                     roff(what));
}

std::string namesOf(const CLI::Option& option) {
  std::string out;
  const auto add = [&](const char* dashes, const std::string& name) {
    out += fmt::format("{}\\fB{}\\fR", out.empty() ? "" : ", ", roff(dashes + name));
  };
  for (const std::string& name : option.get_snames()) add("-", name);
  for (const std::string& name : option.get_lnames()) add("--", name);
  if (!option.get_type_name().empty()) out += fmt::format(" \\fI{}\\fR", roff(option.get_type_name()));
  if (!option.get_default_str().empty()) out += roff("=" + option.get_default_str());
  return out;
}

std::string optionsOf(const CLI::App& command) {
  std::string arguments, options;
  for (const std::string& group : command.get_groups()) {
    std::string of_group;
    for (const CLI::Option* option :
         command.get_options([&](const CLI::Option* option) { return option->get_group() == group; })) {
      const bool positional = option->get_positional();
      const std::string names = positional ? fmt::format("\\fI{}\\fR", roff(option->get_name(true))) : namesOf(*option);
      (positional ? arguments : of_group) += fmt::format(".TP\n{}\n{}\n", names, roff(option->get_description()));
    }
    if (group != "Options" && !of_group.empty()) options += fmt::format(".SS {}\n", roff(group));
    options += of_group;
  }
  return (arguments.empty() ? "" : ".SH ARGUMENTS\n" + arguments) + ".SH OPTIONS\n" + options;
}

constexpr const char* kExitStatus =
    ".SH EXIT STATUS\n0 where all is done, 1 for data, disk and memory, 2 for what was asked: the command line, or a "
    "job's key or value.\n";

// Returns the section of the examples that end a command's help.
std::string examplesOf(const CLI::App& command) {
  const std::string text = command.get_footer();
  const std::size_t lines = text.find('\n');
  if (lines == std::string::npos) return {};
  return fmt::format(".SH {}\n.nf\n{}\n.fi\n", roff(text.substr(0, lines)), roff(text.substr(lines + 1)));
}

std::string optionWords(const CLI::App& command) {
  std::string out;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) out += (out.empty() ? "--" : " --") + name;
  }
  return out;
}

// Returns the cases of a command's options with words, for "COMMAND --option".
std::string wordCases(const CLI::App& command, const OptionFacts& facts) {
  std::string out;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_lnames().empty()) continue;
    const std::vector<std::string> words = facts.wordsOf(*option);
    if (words.empty()) continue;
    out += fmt::format("    \"{} --{}\") words=\"{}\" ;;\n", command.get_name(), option->get_lnames().front(),
                       fmt::join(words, " "));
  }
  return out;
}

}  // namespace

std::string manualPage(const CLI::App& app, const CLI::App& command) {
  const std::string name = app.get_name() + "-" + command.get_name();
  std::string synopsis =
      fmt::format(".SH SYNOPSIS\n\\fB{} {}\\fR [\\fIOPTIONS\\fR]", app.get_name(), command.get_name());
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) synopsis += fmt::format(" \\fI{}\\fR", roff(option->get_name(true)));
  }
  return header(name, name, command.get_description()) + synopsis + "\n" + optionsOf(command) + examplesOf(command) +
         kExitStatus + ".SH SEE ALSO\n\\fBkiln\\fR(1), \\fBkiln\\-job\\fR(5), \\fBkiln\\-transfer\\-functions\\fR(5)\n";
}

std::string manualPage(const CLI::App& app) {
  std::string out = header(app.get_name(), app.get_name(), app.get_description());
  out += fmt::format(".SH SYNOPSIS\n\\fB{}\\fR \\fICOMMAND\\fR [\\fIOPTIONS\\fR] ...\n.SH COMMANDS\n", app.get_name());
  for (const CLI::App* command : commandsOf(app))
    out += fmt::format(".TP\n\\fB{}\\-{}\\fR(1)\n{}\n", app.get_name(), command->get_name(),
                       roff(command->get_description()));
  return out + optionsOf(app) + kExitStatus;
}

std::string bashCompletion(const CLI::App& app, const OptionFacts& facts) {
  std::string commands, cases;
  for (const CLI::App* command : commandsOf(app)) {
    commands += (commands.empty() ? "" : " ") + command->get_name();
    cases += fmt::format("    {}) words=\"{}\" ;;\n", command->get_name(), optionWords(*command));
  }
  std::string out =
      "# Completes the commands and options of kiln in bash.\n"
      "_kiln() {\n"
      "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} words=\"\"\n"
      "  COMPREPLY=()\n";
  out += fmt::format(
      "  if ((COMP_CWORD == 1)); then\n    COMPREPLY=($(compgen -W \"{} {}\" -- \"$current\"))\n    return\n  fi\n",
      commands, optionWords(app));
  out += "  case \"${COMP_WORDS[1]} $before\" in\n";
  for (const CLI::App* command : commandsOf(app)) out += wordCases(*command, facts);
  out += "  esac\n  [[ -n $words ]] || [[ $current != -* ]] || case ${COMP_WORDS[1]} in\n" + cases + "  esac\n";
  out +=
      "  [[ -z $words ]] || COMPREPLY=($(compgen -W \"$words\" -- \"$current\"))\n}\ncomplete -o default -F _kiln "
      "kiln\n";
  return out;
}

}  // namespace kiln::tool
