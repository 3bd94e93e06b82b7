#include "common/config/settings_text.h"

#include <cstddef>
#include <cstdio>

#include "common/base/check.h"

namespace powderkeg {
namespace {

constexpr int kDeepest = 8;  // sections in sections
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool IsLetterOrDigit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}
bool IsWordCharacter(char c) {
  return IsLetterOrDigit(c) || std::string_view(".+-/").find(c) != std::string_view::npos;
}

class Reader {
 public:
  Reader(std::string_view text, std::string_view place) : text_(text), place_(place) {
    if (text_.starts_with(kByteOrderMark)) text_.remove_prefix(kByteOrderMark.size());
  }

  // Up to the end of the text or, inside a section, its '}'.
  std::vector<TextField> Fields(int depth) {
    std::vector<TextField> fields;
    for (SkipSpace(",;"); !AtEnd() && !(depth > 0 && Peek() == '}'); SkipSpace(",;")) {
      fields.push_back(Field(depth));
    }
    return fields;
  }

 private:
  TextField Field(int depth) {
    TextField field{.name = {}, .value = {}, .fields = {}, .is_section = false, .place = Place()};
    field.name = Run(IsLetterOrDigit);
    if (field.name.empty()) Refuse("the name of a setting");
    SkipSpace();
    const bool colon = Accept(':');
    SkipSpace();
    if (Accept('{')) {
      if (depth == kDeepest) Refuse("fewer sections in each other");
      field.is_section = true;
      field.fields = Fields(depth + 1);
      if (!Accept('}')) Refuse("'}'");
    } else if (!colon) {
      Refuse("':' or '{'");
    } else {
      field.value = Value();
    }
    return field;
  }

  std::string Value() {
    if (!AtEnd() && (Peek() == '"' || Peek() == '\'')) return QuotedText(Next());
    std::string word = Run(IsWordCharacter);
    if (word.empty()) Refuse("a value");
    return word;
  }

  std::string QuotedText(char quote) {
    std::string value;
    while (!Accept(quote)) {
      if (AtEnd() || Peek() == '\n' || Peek() == '\r') Refuse("the quote at the end of a text");
      const char c = Next();
      value += c == '\\' ? Escaped() : c;
    }
    return value;
  }

  // What stands after a backslash.
  char Escaped() {
    constexpr std::string_view kLetters = "ntr\\\"'";
    constexpr std::string_view kMeanings = "\n\t\r\\\"'";
    if (AtEnd()) Refuse("an escape");
    if (Peek() >= '0' && Peek() <= '7') {
      int code = 0;
      for (int digits = 0; digits < 3 && !AtEnd() && Peek() >= '0' && Peek() <= '7'; ++digits) {
        code = code * 8 + (Next() - '0');
      }
      return static_cast<char>(code);
    }
    const std::size_t letter = kLetters.find(Peek());
    if (letter == std::string_view::npos) Refuse("one of \\n \\t \\r \\\\ \\\" \\' \\ooo");
    Next();
    return kMeanings[letter];
  }

  // Space, comments and any of `separators`.
  void SkipSpace(std::string_view separators = "") {
    while (!AtEnd()) {
      if (Peek() == '#') {
        while (!AtEnd() && Peek() != '\n' && Peek() != '\r') Next();
      } else if (std::string_view(" \t\r\n").find(Peek()) != std::string_view::npos ||
                 separators.find(Peek()) != std::string_view::npos) {
        Next();
      } else {
        return;
      }
    }
  }

  std::string Run(bool (*belongs)(char)) {
    std::string run;
    while (!AtEnd() && belongs(Peek())) run += Next();
    return run;
  }
  bool Accept(char c) {
    const bool there = !AtEnd() && Peek() == c;
    if (there) Next();
    return there;
  }
  [[nodiscard]] bool AtEnd() const { return position_ == text_.size(); }
  [[nodiscard]] char Peek() const { return text_[position_]; }
  char Next() {
    const char c = text_[position_++];
    const bool ends_line = c == '\n' || (c == '\r' && (AtEnd() || Peek() != '\n'));
    if (ends_line) {
      ++line_;
      line_start_ = position_;
    }
    return c;
  }
  [[nodiscard]] std::string Place() const {
    return StrCat(place_, ":", line_, ":", position_ - line_start_ + 1, ": ");
  }
  [[noreturn]] void Refuse(std::string_view expected) const {
    const std::string found = AtEnd() ? "the end" : Quoted(text_.substr(position_, 1));
    throw Error(StrCat(Place(), "found ", found, "; expected ", expected));
  }

  std::string_view text_;
  std::string_view place_;
  std::size_t position_ = 0;
  int line_ = 1;
  std::size_t line_start_ = 0;
};

}  // namespace

std::vector<TextField> ParseFields(std::string_view text, std::string_view place) {
  return Reader(text, place).Fields(/*depth=*/0);
}

std::string Quoted(std::string_view value) {
  bool is_word = !value.empty();
  std::string quoted = "\"";
  for (const char c : value) {
    is_word = is_word && IsWordCharacter(c);
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') {
      char octal[5];
      std::snprintf(octal, sizeof octal, "\\%03o", static_cast<unsigned>(c));
      quoted += octal;
    } else {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += c;
    }
  }
  return is_word ? std::string(value) : quoted + '"';
}

}  // namespace powderkeg
