// An option is one row of a table: key in a job, flag on the command line, member, legal values, help. The parser, the
// JSON schema, the command line, the resolved job, the manual and the completion are made of the rows (job/README.md).
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "job/job_flags.h"
#include "job/json/job_json.h"

namespace kiln {

/// The legal values of an option, independent of its member.
struct OptionForm {
  nlohmann::ordered_json schema;
  // The rest describes the flag.
  JobFlag::Arguments arguments = JobFlag::Arguments::kOne;
  std::string value_name;                                   // "VOXELS", "pixel|voxel"
  std::string expected;                                     // the legal texts, for errors
  std::string limits;                                       // "0.25 to 1", for help
  std::vector<std::string> words;                           // for completion
  bool may_be_empty = false;                                // an empty text is a value
  nlohmann::json present = true;                            // the value of a flag without an argument
  bool number = false;                                      // text that is no number is refused before the job is read
  std::function<nlohmann::json(const std::string&)> parse;  // a text as a value of a job; null for illegal texts
  std::function<std::string(const std::string&)> wrong_part;  // of an illegal text, for errors; empty: the whole text
};

template <class Owner>
struct Option;
template <class Owner>
using Options = std::vector<Option<Owner>>;

/// A member of `Owner` and its legal values.
template <class Owner>
struct OptionValue {
  OptionForm form;
  /// Reads the key. requires: the object has the key. throws: Error kUsage naming the key or the flag.
  std::function<void(const JobObject&, std::string_view key, Owner&)> read;
  std::function<nlohmann::ordered_json(const Owner&)> write;  // null: no value
  /// Returns true if the option is part of the resolved job, which holds the options that change the picture. Empty:
  /// never.
  std::function<bool(const Owner&)> resolved;
  /// The options of an object, and its name in the schema.
  Options<Owner> inside;
  std::string_view name;

  OptionValue() = default;
  /// `member(owner)` is a reference to the member; `kind` is one of option_kinds.h.
  template <class Member, class Kind>
  OptionValue(Member member, Kind kind, std::function<bool(const Owner&)> is_resolved = {});
  template <class Read>
  static OptionValue custom(OptionForm form, Read read,
                            std::function<nlohmann::ordered_json(const Owner&)> write = {}) {
    OptionValue out;
    out.form = std::move(form);
    out.read = std::move(read);
    out.write = std::move(write);
    return out;
  }
  OptionValue resolvedIf(std::function<bool(const Owner&)> is_resolved) && {
    resolved = std::move(is_resolved);
    return std::move(*this);
  }
};

template <class Owner>
struct Option {
  std::string_view key;   // a key of the table's object; empty: the flag sets several keys of the table
  std::string_view flag;  // empty: no flag
  OptionGroup group = OptionGroup::kOutput;
  OptionValue<Owner> value;
  std::string_view help;     // sentences, without the range and the default
  std::string_view missing;  // if an object needs the key: ends the error "is missing; …"

  Option(std::string_view row_key, std::string_view row_flag, OptionGroup row_group, OptionValue<Owner> row_value,
         std::string_view row_help, std::string_view row_missing = {})
      : key(row_key),
        flag(row_flag),
        group(row_group),
        value(std::move(row_value)),
        help(row_help),
        missing(row_missing) {}
  /// An option of jobs alone.
  Option(std::string_view row_key, OptionValue<Owner> row_value, std::string_view row_help = {},
         std::string_view row_missing = {})
      : Option(row_key, {}, OptionGroup::kOutput, std::move(row_value), row_help, row_missing) {}
};

/// For OptionValue::resolved.
inline constexpr auto kAlways = [](const auto&) { return true; };

/// The member of an option: KILN_MEMBER(size.width) of a picture.
#define KILN_MEMBER(path) \
  [](auto& owner) -> auto& { return owner.path; }

template <class Owner>
std::vector<std::string_view> keysOf(const Options<Owner>& options) {
  std::vector<std::string_view> out;
  for (const Option<Owner>& option : options) {
    if (!option.key.empty()) out.push_back(option.key);
  }
  return out;
}

/// Reads the keys of the table from the object and ignores other keys.
template <class Owner>
void readKnown(const Options<Owner>& options, const JobObject& object, Owner& owner) {
  for (const Option<Owner>& option : options) {
    if (!option.key.empty() && object.has(option.key)) option.value.read(object, option.key, owner);
  }
}
/// Reads an object. throws: Error kUsage for an unknown, a missing or an illegal key.
template <class Owner>
void readOptions(const Options<Owner>& options, const JobObject& object, Owner& owner) {
  object.requireOneOf(keysOf(options));
  for (const Option<Owner>& option : options) {
    if (!option.missing.empty() && !object.has(option.key))
      object.complain(option.key, "is missing; " + std::string(option.missing));
  }
  readKnown(options, object, owner);
}

/// Returns the options' part of the resolved job.
template <class Owner>
nlohmann::ordered_json resolvedJson(const Options<Owner>& options, const Owner& owner) {
  auto out = nlohmann::ordered_json::object();
  // Growth copies every value, as keys of an ordered_json are constant; a function's table is large.
  out.get_ref<nlohmann::ordered_json::object_t&>().reserve(options.size());
  for (const Option<Owner>& option : options) {
    nlohmann::ordered_json value;
    if (!option.value.inside.empty())
      value = resolvedJson(option.value.inside, owner);
    else if (option.value.resolved && option.value.resolved(owner))
      value = option.value.write(owner);
    if (!value.is_null() && !(value.is_object() && value.empty())) out[std::string(option.key)] = std::move(value);
  }
  return out;
}

namespace option_detail {
template <class T>
struct Value {
  using Type = T;
};
template <class T>
struct Value<std::optional<T>> {
  using Type = T;
};
template <class T>
using ValueOf = typename Value<T>::Type;

template <class T>
T& made(T& value) {
  return value;
}
template <class T>
T& made(std::optional<T>& value) {
  if (!value) value.emplace();
  return *value;
}
template <class T>
const T* ifThere(const T& value) {
  return &value;
}
template <class T>
const T* ifThere(const std::optional<T>& value) {
  return value ? &*value : nullptr;
}
}  // namespace option_detail

/// Returns the options of a member as options of its owner. Reading makes a std::optional member.
template <class Owner, class Inner, class Member>
Options<Owner> optionsIn(const Options<Inner>& inner, Member member) {
  using option_detail::ifThere;
  Options<Owner> out;
  for (const Option<Inner>& option : inner) {
    Option<Owner> row(option.key, option.flag, option.group, {}, option.help, option.missing);
    row.value.form = option.value.form;
    row.value.read = [read = option.value.read, member](const JobObject& object, std::string_view key, Owner& owner) {
      read(object, key, option_detail::made(member(owner)));
    };
    if (option.value.write)
      row.value.write = [write = option.value.write, member](const Owner& owner) {
        const Inner* const value = ifThere(member(owner));
        return value ? write(*value) : nlohmann::ordered_json();
      };
    if (option.value.resolved)
      row.value.resolved = [resolved = option.value.resolved, member](const Owner& owner) {
        const Inner* const value = ifThere(member(owner));
        return value && resolved(*value);
      };
    row.value.inside = optionsIn<Owner>(option.value.inside, member);
    row.value.name = option.value.name;
    out.push_back(std::move(row));
  }
  return out;
}

/// The value of a key that is an object with these options.
template <class Owner>
OptionValue<Owner> objectValue(std::string_view name, const Options<Owner>& inside) {
  OptionForm form;
  form.schema = {{"$ref", name}};
  auto out = OptionValue<Owner>::custom(std::move(form),
                                        [inside](const JobObject& object, std::string_view key, Owner& owner) {
                                          readOptions(inside, *object.object(key), owner);
                                        });
  out.inside = inside;
  out.name = name;
  return out;
}

template <class Owner>
template <class Member, class Kind>
OptionValue<Owner>::OptionValue(Member member, Kind kind, std::function<bool(const Owner&)> is_resolved)
    : form(kind.form()), resolved(std::move(is_resolved)) {
  read = [member, kind](const JobObject& object, std::string_view key, Owner& owner) {
    kind.read(object, key, member(owner));
  };
  write = [member, kind](const Owner& owner) { return kind.write(member(owner)); };
}

}  // namespace kiln
