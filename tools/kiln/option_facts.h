// Facts about options for which an option of CLI11 has no place.
#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace kiln::tool {

class OptionFacts {
 public:
  /// Offers words for completion of the option's value.
  void offer(const CLI::Option* option, std::vector<std::string> words) { facts_[option].words = std::move(words); }
  /// Takes an empty argument for a value.
  void allowEmpty(const CLI::Option* option) { facts_[option].may_be_empty = true; }

  std::vector<std::string> wordsOf(const CLI::Option& option) const { return factsOf(option).words; }
  bool mayBeEmpty(const CLI::Option& option) const { return factsOf(option).may_be_empty; }

 private:
  struct Facts {
    std::vector<std::string> words;
    bool may_be_empty = false;
  };
  Facts factsOf(const CLI::Option& option) const {
    const auto found = facts_.find(&option);
    return found == facts_.end() ? Facts() : found->second;
  }
  std::map<const CLI::Option*, Facts> facts_;
};

}  // namespace kiln::tool
