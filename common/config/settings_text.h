#pragma once

// The syntax of settings files:
//
//   # a comment
//   section { name: value  name: "text with spaces" }
//
// A value is a word of letters, digits and _ . + - / or a text in quotes with the escapes
// \n \t \r \\ \" \' and \ooo (octal). Values and sections may be separated by ',' or ';'. Lines end
// with LF, CR or CR LF; a byte-order mark at the start is skipped.

#include <string>
#include <string_view>
#include <vector>

namespace powderkeg {

// One `name: value` or `name { ... }`.
struct TextField {
  std::string name;
  std::string value;              // of a value, without quotes and escapes
  std::vector<TextField> fields;  // of a section, in order
  bool is_section = false;
  std::string place;  // "FILE:LINE:COLUMN: " for errors, may be empty
};

// Throws Error with file, line and column (both from 1) where the text is not of this syntax;
// `place` names the file.
[[nodiscard]] std::vector<TextField> ParseFields(std::string_view text, std::string_view place);

// The value as ParseFields reads it: a word as it is, everything else in quotes.
[[nodiscard]] std::string Quoted(std::string_view value);

}  // namespace powderkeg
