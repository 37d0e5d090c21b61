// The kinds of option values. A kind reads a value from a job, parses the text of a flag, writes the value into a
// resolved job, and describes itself for the schema, help and errors.
#pragma once

#include <filesystem>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "image/pixel_rect.h"
#include "job/option.h"
#include "job/transfer_function_choice.h"
#include "scene/clip_region.h"
#include "scene/frame_rate.h"
#include "scene/render_options.h"

namespace kiln {

/// A number in a range. The unit, "voxels", is named in errors and help.
struct Number {
  NumberRange range;
  std::string_view unit = {};
  std::string_view ref = {};  // the name of the range in the schema, if several options share it
  OptionForm form() const;
  template <class T>
  void read(const JobObject& object, std::string_view key, T& out) const {
    out = static_cast<option_detail::ValueOf<T>>(*object.number(key, range, unit));
  }
  template <class T>
  nlohmann::ordered_json write(const T& value) const {
    const auto* const number = option_detail::ifThere(value);
    return number ? nlohmann::ordered_json(*number) : nlohmann::ordered_json();
  }
};

/// A whole number in a range.
struct Whole {
  std::int64_t least, most;
  std::string_view unit = {};
  OptionForm form() const;
  template <class T>
  void read(const JobObject& object, std::string_view key, T& out) const {
    out = static_cast<T>(*object.integer(key, least, most, unit));
  }
  template <class T>
  nlohmann::ordered_json write(const T& value) const {
    return value;
  }
};

/// One of a few whole numbers, or "auto", an empty std::optional.
struct WholeChoice {
  std::vector<int> numbers;
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, int& out) const;
  void read(const JobObject& object, std::string_view key, std::optional<int>& out) const;
  nlohmann::ordered_json write(int value) const { return value; }
  nlohmann::ordered_json write(const std::optional<int>& value) const;
  bool or_auto = false;
};

/// One of a few words: an enumerator, a bool (the second word is true), or the word itself.
struct Word {
  std::span<const std::string_view> names;
  /// The names behind the first `count` are aliases of the first, the second, ….
  std::size_t count = names.size();
  OptionForm form() const;
  template <class T>
  void read(const JobObject& object, std::string_view key, T& out) const {
    using Value = option_detail::ValueOf<T>;
    const std::size_t place = *object.choice(key, names);
    if constexpr (std::is_same_v<Value, std::string>)
      out = names[place];
    else
      out = static_cast<Value>(place % count);
  }
  template <class T>
  nlohmann::ordered_json write(const T& value) const {
    using Value = option_detail::ValueOf<T>;
    const Value* const there = option_detail::ifThere(value);
    if (!there) return {};
    if constexpr (std::is_same_v<Value, std::string>)
      return *there;
    else
      return names[static_cast<std::size_t>(*there)];
  }
};

/// A word that is a flag without an argument on the command line: the flag stands for `word`.
struct WordOfFlag {
  Word kind;
  std::string_view word;
  OptionForm form() const;
  template <class T>
  void read(const JobObject& object, std::string_view key, T& out) const {
    kind.read(object, key, out);
  }
  template <class T>
  nlohmann::ordered_json write(const T& value) const {
    return kind.write(value);
  }
};

/// true or false. On the command line a flag without an argument, or "on|off".
struct Switch {
  bool on_off = false;
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, bool& out) const;
  nlohmann::ordered_json write(bool value) const { return value; }
};

/// The planes beside a picture's colours: a list of words.
struct AovList {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, Aovs& out) const;
  nlohmann::ordered_json write(const Aovs& aovs) const;
};

/// A text that is not empty; only the command line may clear the text.
struct Text {
  std::string_view what;  // "a name"
  std::string_view value_name = "TEXT";
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, std::string& out) const;
  nlohmann::ordered_json write(const std::string& text) const { return text; }
};

/// A file, in a job relative to the job's folder; or a computed volume, "phantom:NAME:XxYxZ".
struct FileName {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, std::filesystem::path& out) const;
  nlohmann::ordered_json write(const std::filesystem::path& path) const { return path.generic_string(); }
};

/// A number of bytes, or a text such as "2G".
struct Bytes {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, std::uint64_t& out) const;
  nlohmann::ordered_json write(std::uint64_t bytes) const;
};

/// Frames a second.
struct Rate {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, FrameRate& out) const;
  nlohmann::ordered_json write(const FrameRate& rate) const { return rate.text(); }
};

/// A place or a direction in the world; a direction is not the zero vector.
struct WorldVector {
  bool direction = false;
  OptionForm form() const;
  glm::dvec3 readVector(const JobObject& object, std::string_view key) const;
  template <class T>
  void read(const JobObject& object, std::string_view key, T& out) const {
    out = readVector(object, key);
  }
  template <class T>
  nlohmann::ordered_json write(const T& value) const {
    const glm::dvec3* const v = option_detail::ifThere(value);
    return v ? nlohmann::ordered_json{v->x, v->y, v->z} : nlohmann::ordered_json();
  }
};

/// A movement of the picture.
struct PictureShift {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, std::optional<glm::dvec2>& out) const;
  nlohmann::ordered_json write(const std::optional<glm::dvec2>& shift) const;
};

/// A colour: numbers, in linear light where their object has no other space, or a text (image/named_color.h).
struct ColorValue {
  NumberRange range;
  std::string_view ref;
  OptionForm form() const;
  glm::dvec3 readColor(const JobObject& object, std::string_view key) const;
  template <class T>
  void read(const JobObject& object, std::string_view key, T& out) const {
    out = readColor(object, key);
  }
  template <class T>
  nlohmann::ordered_json write(const T& value) const {
    const glm::dvec3* const c = option_detail::ifThere(value);
    return c ? nlohmann::ordered_json{c->r, c->g, c->b} : nlohmann::ordered_json();
  }
};

/// One colour behind the volume, or two. A colour is [red, green, blue, alpha], a text, or "transparent".
struct BackgroundColors {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, std::optional<Background>& out) const;
  nlohmann::ordered_json write(const std::optional<Background>& background) const;
};

/// The rectangle of drawn pixels.
struct PixelBox {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, std::optional<PixelRect>& out) const;
  nlohmann::ordered_json write(const std::optional<PixelRect>& rect) const;
};

/// A half-open box of voxels.
struct VoxelBounds {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, std::optional<VoxelBox>& out) const;
  nlohmann::ordered_json write(const std::optional<VoxelBox>& box) const;
};

/// A box of the world. The resolved job has the faces of the box among the clip planes.
struct WorldBounds {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, Clipping& out) const;
  nlohmann::ordered_json write(const Clipping&) const { return {}; }
};

/// A window of the volume's values.
struct ValueWindow {
  OptionForm form() const;
  void read(const JobObject& object, std::string_view key, std::optional<Window>& out) const;
  nlohmann::ordered_json write(const std::optional<Window>& window) const;
};

/// A list of objects.
template <class Item>
struct ListOf {
  const Options<Item>& options;
  std::string_view name;  // name of the object in the schema
  ListLimit limit;
  std::string_view expected;
  std::size_t least = 0;
  void (*check)(const JobObject& item, const std::vector<Item>& so_far) = nullptr;
  Item (*item_from)(const JobObject& object) = nullptr;
  /// For a flag that adds an item: reads the text as a list of one item.
  std::string_view value_name = {}, flag_expected = {};
  nlohmann::json (*parse)(const std::string& text) = nullptr;
  std::string (*wrong_part)(const std::string& text) = nullptr;

  OptionForm form() const {
    OptionForm out;
    out.schema = {{"type", "array"}, {"items", {{"$ref", name}}}};
    if (least > 0) out.schema["minItems"] = least;
    out.schema["maxItems"] = limit.most;
    out.arguments = JobFlag::Arguments::kSeveral;
    out.value_name = value_name;
    out.expected = flag_expected;
    out.parse = parse;
    out.wrong_part = wrong_part;
    return out;
  }
  void read(const JobObject& object, std::string_view key, std::vector<Item>& out) const {
    const auto objects = object.objects(key, expected, limit);
    if (objects->size() < least) object.refuse(key, expected);
    out.clear();
    for (const JobObject& item : *objects) {
      if (item_from) {
        out.push_back(item_from(item));
      } else {
        out.emplace_back();
        readOptions(options, item, out.back());
      }
      if (check) check(item, out);
    }
  }
  nlohmann::ordered_json write(const std::vector<Item>& items) const {
    auto out = nlohmann::ordered_json::array();
    for (const Item& item : items) out.push_back(resolvedJson(options, item));
    return out;
  }
};

/// Returns the numbers of "a,b,c" as a list; null for other texts.
nlohmann::json numbersOfText(std::string_view text, char separator = ',');
/// The three numbers of "r,g,b" as a list, or a colour's name as it stands; null where the text is no colour.
nlohmann::json colorOfText(std::string_view text);

/// Returns "expected …, found …" for a text without legal form, else an empty text.
std::string refusalOfText(const OptionForm& form, const std::string& text);
/// Quotes the texts of a flag for an error, or the part that is wrong: "'skyblu' in 'navy:skyblu'".
std::string quotedWrongText(const OptionForm& form, const std::vector<std::string>& texts);
/// The text of a flag as a value of a job. throws: Error kUsage naming the flag.
nlohmann::json valueOfText(const OptionForm& form, const std::string& text, std::string_view flag);

/// Reads the value of a flag of a command without a job. throws: Error kUsage naming the flag.
template <class T, class Kind>
T valueOfFlag(const Kind& kind, const std::string& text, const std::string& flag) {
  const OptionForm form = kind.form();
  T out{};
  kind.read(JobObject::ofFlag({{"value", valueOfText(form, text, flag)}},
                              {flag, quotedWrongText(form, {text}), form.expected}),
            "value", out);
  return out;
}

}  // namespace kiln
