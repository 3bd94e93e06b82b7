#pragma once

// Reads checked values out of JSON that a stranger wrote.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/check.h"

namespace powderkeg {

using Json = nlohmann::json;

// Keeps the first thing that is wrong. After that every call still returns something harmless (null
// or the minimum), so that code reads straight on and asks once at the end. One thread.
class JsonReader {
 public:
  // The first reason, or nullopt: everything read was right.
  [[nodiscard]] const std::optional<std::string>& refusal() const { return refusal_; }
  [[nodiscard]] bool ok() const { return !refusal_; }

  template <typename... Parts>
  void Refuse(const Parts&... parts) {
    if (!refusal_) refusal_ = StrCat(parts...);
  }
  template <typename... Parts>
  void Require(bool condition, const Parts&... parts) {
    if (!condition) Refuse(parts...);
  }

  // The JSON value in `text`, called `name` in reasons. Values nested deeper than `max_depth` are
  // dropped.
  [[nodiscard]] Json Parse(std::string_view text, std::string_view name, int max_depth);

  // object[key]; requires an object with this key.
  [[nodiscard]] const Json& Member(const Json& object, std::string_view key);

  // object[key], or nullptr if that is missing or null.
  [[nodiscard]] static const Json* Find(const Json& object, std::string_view key);

  // A list of `size` elements.
  [[nodiscard]] const Json& List(const Json& list, std::string_view name, std::size_t size);
  // The element, null if there is none.
  [[nodiscard]] static const Json& Element(const Json& list, std::size_t index);

  // A whole number in [minimum, maximum], written as an integer or a float.
  [[nodiscard]] int Integer(const Json& value, std::string_view name, int minimum, int maximum);
  // Any number: the whole one in [minimum, maximum] that is nearest.
  [[nodiscard]] int Nearest(const Json& value, std::string_view name, int minimum, int maximum);
  // true, false or a number, of which 0 is false.
  [[nodiscard]] bool Boolean(const Json& value, std::string_view name);
  [[nodiscard]] std::string Text(const Json& value, std::string_view name);

 private:
  std::optional<std::string> refusal_;
};

}  // namespace powderkeg
