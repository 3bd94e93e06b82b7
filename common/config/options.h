#pragma once

// One declaration for every setting: name, what it accepts and what it means, beside the member
// that holds it. Files, --set, agents' texts, --help-options, the stored settings and the digest
// all read these tables.

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

#include "common/base/check.h"
#include "common/base/number.h"
#include "common/config/settings_text.h"

namespace powderkeg {

using Names = std::span<const std::string_view>;
[[nodiscard]] std::string Joined(Names names, std::string_view separator);

// What a setting accepts, besides what its type says.
struct Allowed {
  double low = std::numeric_limits<double>::lowest();
  double high = std::numeric_limits<double>::max();
  bool above = false;           // `low` itself is not allowed
  Names names{};                // of a text; none: any text
  std::string_view no_value{};  // of an optional: the word for none

  [[nodiscard]] constexpr Allowed Or(std::string_view word) const {
    Allowed allowed = *this;
    allowed.no_value = word;
    return allowed;
  }
};
inline constexpr Allowed kAnything;
[[nodiscard]] constexpr Allowed Between(double low, double high) {
  return {.low = low, .high = high};
}
[[nodiscard]] constexpr Allowed Above(double low, double high) {
  return {.low = low, .high = high, .above = true};
}
[[nodiscard]] constexpr Allowed OneOf(Names names) { return {.names = names}; }

// --- Values as text: three functions per type ----------------------------------------------------
// ReadValue returns whether the text is allowed, and changes the value only then. WriteValue gives
// what ReadValue reads, exactly. Expected says in words what is allowed.

[[nodiscard]] bool ReadValue(std::string_view text, const Allowed& allowed, std::string& value);
[[nodiscard]] std::string WriteValue(const std::string& value, const Allowed& allowed);
[[nodiscard]] std::string Expected(const Allowed& allowed, const std::string* type);
// Words, separated by spaces or commas.
using Words = std::vector<std::string>;
[[nodiscard]] bool ReadValue(std::string_view text, const Allowed& allowed, Words& value);
[[nodiscard]] std::string WriteValue(const Words& value, const Allowed& allowed);
[[nodiscard]] std::string Expected(const Allowed& allowed, const Words* type);

// int, std::uint64_t or double.
template <typename Type>
concept NumberType = std::is_arithmetic_v<Type> && !std::is_same_v<Type, bool>;

template <NumberType Type>
[[nodiscard]] bool ReadValue(std::string_view text, const Allowed& allowed, Type& value) {
  const auto number = ParseNumber<Type>(text);
  if (!number) return false;
  const auto real = static_cast<double>(*number);
  const bool inside = real >= allowed.low && real <= allowed.high;
  if (!inside || (allowed.above && real == allowed.low)) return false;
  value = *number;
  return true;
}
template <NumberType Type>
[[nodiscard]] std::string WriteValue(Type value, const Allowed& /*allowed*/) {
  std::array<char, 32> text;
  if constexpr (std::is_floating_point_v<Type>) {
    return {text.data(), std::to_chars(text.begin(), text.end(), value,  //
                                       std::chars_format::general)
                             .ptr};
  } else {
    return {text.data(), std::to_chars(text.begin(), text.end(), value).ptr};
  }
}
template <NumberType Type>
[[nodiscard]] std::string Expected(const Allowed& allowed, const Type* /*type*/) {
  using Limits = std::numeric_limits<Type>;
  const auto bound = [&](double value) {
    if (value <= static_cast<double>(Limits::lowest()))
      return WriteValue(Limits::lowest(), allowed);
    if (value >= static_cast<double>(Limits::max())) return WriteValue(Limits::max(), allowed);
    return WriteValue(static_cast<Type>(value), allowed);
  };
  return StrCat(Limits::is_integer ? "a whole number " : "a number ",
                allowed.above ? "above " : "from ", bound(allowed.low), " to ",
                bound(allowed.high));
}

// A type whose values have names, in their order: bool, or an enumeration with a function
// NamesOf(Enum) beside it.
[[nodiscard]] Names NamesOf(bool);
template <typename Type>
concept NamedType = std::is_enum_v<Type> || std::is_same_v<Type, bool>;

template <NamedType Type>
[[nodiscard]] bool ReadValue(std::string_view text, const Allowed& /*allowed*/, Type& value) {
  const Names names = NamesOf(Type{});
  const auto found = std::ranges::find(names, text);
  if (found != names.end()) value = static_cast<Type>(found - names.begin());
  return found != names.end();
}
template <NamedType Type>
[[nodiscard]] std::string WriteValue(Type value, const Allowed& /*allowed*/) {
  return std::string(NamesOf(value)[static_cast<std::size_t>(value)]);
}
template <NamedType Type>
[[nodiscard]] std::string Expected(const Allowed& /*allowed*/, const Type* /*type*/) {
  return "one of " + Joined(NamesOf(Type{}), ", ");
}

// A value, or the word Allowed::no_value.
template <typename Value>
[[nodiscard]] bool ReadValue(std::string_view text, const Allowed& allowed,
                             std::optional<Value>& value) {
  Value read{};
  if (text == allowed.no_value) {
    value.reset();
  } else if (ReadValue(text, allowed, read)) {
    value = std::move(read);
  } else {
    return false;
  }
  return true;
}
template <typename Value>
[[nodiscard]] std::string WriteValue(const std::optional<Value>& value, const Allowed& allowed) {
  return value ? WriteValue(*value, allowed) : std::string(allowed.no_value);
}
template <typename Value>
[[nodiscard]] std::string Expected(const Allowed& allowed, const std::optional<Value>* /*type*/) {
  return StrCat(allowed.no_value, " or ", Expected(allowed, static_cast<const Value*>(nullptr)));
}

// One for all, or `size` of them separated by '/'.
template <typename Value, std::size_t size>
[[nodiscard]] bool ReadValue(std::string_view text, const Allowed& allowed,
                             std::array<Value, size>& value) {
  const bool one = text.find('/') == std::string_view::npos;
  std::array<Value, size> read{};
  for (std::size_t i = 0; i < size; ++i) {
    const std::string_view part = i + 1 == size || one ? text : text.substr(0, text.find('/'));
    if (!ReadValue(part, allowed, read[i])) return false;
    if (!one) text.remove_prefix(std::min(text.size(), part.size() + 1));
  }
  value = read;
  return true;
}
template <typename Value, std::size_t size>
[[nodiscard]] std::string WriteValue(const std::array<Value, size>& value, const Allowed& allowed) {
  const bool equal = std::ranges::count(value, value[0]) == static_cast<std::ptrdiff_t>(size);
  std::string text = WriteValue(value[0], allowed);
  for (std::size_t i = 1; i < size && !equal; ++i) text += "/" + WriteValue(value[i], allowed);
  return text;
}
template <typename Value, std::size_t size>
[[nodiscard]] std::string Expected(const Allowed& allowed,
                                   const std::array<Value, size>* /*type*/) {
  return StrCat(Expected(allowed, static_cast<const Value*>(nullptr)), ", or ", size,
                " separated by '/'");
}

// --- Tables --------------------------------------------------------------------------------------

template <typename Settings>
struct Option {
  std::string_view name;
  Allowed allowed;
  std::string_view help;
  bool (*read)(std::string_view text, const Allowed& allowed, Settings& settings);
  std::string (*write)(const Settings& settings, const Allowed& allowed);  // "": nothing to say
  std::string (*expected)(const Allowed& allowed);
  bool is_list = false;  // may be given several times; the words are joined
};
template <typename Settings>
using OptionTable = std::span<const Option<Settings>>;

template <auto>
struct MemberOf;
template <typename S, typename V, V S::*member>
struct MemberOf<member> {
  using Settings = S;
  using Value = V;
};

// The option of a member.
template <auto member>
[[nodiscard]] auto OptionOf(std::string_view name, const Allowed& allowed, std::string_view help) {
  using Settings = typename MemberOf<member>::Settings;
  using Value = typename MemberOf<member>::Value;
  return Option<Settings>{
      name,
      allowed,
      help,
      [](std::string_view text, const Allowed& allowed_values, Settings& settings) {
        return ReadValue(text, allowed_values, settings.*member);
      },
      [](const Settings& settings, const Allowed& allowed_values) {
        return WriteValue(settings.*member, allowed_values);
      },
      [](const Allowed& allowed_values) {
        return Expected(allowed_values, static_cast<const Value*>(nullptr));
      },
      std::is_same_v<Value, Words>};
}

// Throws Error unless the fields are all named in `options` or are `sections`, and are what they
// are named: a value or a section.
void CheckNames(std::span<const TextField> fields, std::string_view path,
                const std::vector<std::string_view>& options, Names sections);
// The value of the fields of this name, or nullopt. Throws Error if there are several of what is no
// list.
struct GivenValue {
  const TextField* field;  // the first
  std::string text;
};
[[nodiscard]] std::optional<GivenValue> ValueOf(std::span<const TextField> fields,
                                                std::string_view path, std::string_view name,
                                                bool is_list);

// Changes the settings by the fields, in the order of the table. `path` stands before their names
// in errors, "training."; fields named in `sections` are left to the caller. Throws Error.
template <typename Settings>
void ReadOptions(std::span<const TextField> fields, std::string_view path,
                 OptionTable<Settings> table, Settings& settings, Names sections = {}) {
  std::vector<std::string_view> names;
  for (const Option<Settings>& option : table) names.push_back(option.name);
  CheckNames(fields, path, names, sections);
  for (const Option<Settings>& option : table) {
    const auto value = ValueOf(fields, path, option.name, option.is_list);
    if (!value || option.read(value->text, option.allowed, settings)) continue;
    throw Error(StrCat(value->field->place, path, option.name, " is ", Quoted(value->text),
                       "; expected ", option.expected(option.allowed)));
  }
}

// Every option as the fields of a section, one a line.
template <typename Settings>
[[nodiscard]] std::string WriteOptions(OptionTable<Settings> table, const Settings& settings,
                                       std::string_view indent) {
  std::string text;
  for (const Option<Settings>& option : table) {
    const std::string value = option.write(settings, option.allowed);
    if (!value.empty()) text += StrCat(indent, option.name, ": ", Quoted(value), "\n");
  }
  return text;
}

// For users: name and default, meaning and what is allowed.
template <typename Settings>
[[nodiscard]] std::string DescribeOptions(OptionTable<Settings> table, std::string_view path) {
  std::string text;
  for (const Option<Settings>& option : table) {
    const std::string value = option.write(Settings{}, option.allowed);
    text += StrCat("  ", path, option.name, value.empty() ? "" : " = " + value, "\n      ",
                   option.help, "\n      ", option.expected(option.allowed), "\n");
  }
  return text;
}

}  // namespace powderkeg
