// Networks by name, or as text.

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/base/number.h"
#include "common/model/network_description.h"
#include "common/pommerman/types.h"

namespace powderkeg {
namespace {

constexpr int kMostRepeats = 64;

// One part of a network's text: a word, its numbers and how often it stands there.
struct Part {
  std::string_view text;
  std::string_view word;
  std::vector<int> numbers;
  int repeats = 1;
};

[[noreturn]] void Refuse(std::string_view part, std::string_view expected) {
  throw Error(StrCat("network part \"", part, "\": expected ", expected));
}

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> pieces;
  while (true) {
    const std::size_t end = text.find(separator);
    pieces.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return pieces;
    text.remove_prefix(end + 1);
  }
}

int NumberOf(std::string_view part, std::string_view digits) {
  const auto number = ParseNumber<int>(digits);
  if (!number || *number < 0) Refuse(part, "a word and whole numbers with '-' between them");
  return *number;
}

Part Read(std::string_view text) {
  Part part{.text = text, .word = text, .numbers = {}};
  const std::size_t first = text.find_first_of("0123456789");
  part.word = text.substr(0, first);
  if (first == std::string_view::npos) return part;
  std::string_view numbers = text.substr(first);
  if (const std::size_t times = numbers.find('x'); times != std::string_view::npos) {
    part.repeats = NumberOf(text, numbers.substr(times + 1));
    if (part.repeats < 1 || part.repeats > kMostRepeats) Refuse(text, "1 to 64 times");
    numbers = numbers.substr(0, times);
  }
  for (const std::string_view digits : Split(numbers, '-')) {
    part.numbers.push_back(NumberOf(text, digits));
  }
  return part;
}

// Its number `index`, or the default where it has fewer.
int Number(const Part& part, std::size_t index, int by_default) {
  return index < part.numbers.size() ? part.numbers[index] : by_default;
}

void AddBlocks(const Part& part, NetworkDescription& network) {
  const bool residual = part.word == "residual";
  const int first = part.numbers[0];
  const BlockDescription block =
      residual
          ? BlockDescription{BlockDescription::Kind::kResidual, first, first, Number(part, 1, 1)}
          : BlockDescription{BlockDescription::Kind::kInvertedResidual, first, Number(part, 1, 0),
                             Number(part, 2, 1)};
  network.blocks.insert(network.blocks.end(), static_cast<std::size_t>(part.repeats), block);
}

struct Word {
  std::string_view name;
  std::size_t fewest, most;  // numbers
  std::string_view form;
};
constexpr std::array kWords{
    Word{"stem", 1, 2, "stemCHANNELS or stemCHANNELS-STRIDE"},
    Word{"residual", 1, 2, "residualCHANNELS or residualCHANNELS-STRIDE"},
    Word{"inverted", 2, 3, "invertedEXPANDED-CHANNELS or invertedEXPANDED-CHANNELS-STRIDE"},
    Word{"value", 2, 2, "valueCHANNELS-HIDDEN"},
    Word{"policy", 1, 1, "policyCHANNELS"},
    Word{"own", 1, 1, "ownHIDDEN"},
    Word{"others", 1, 1, "othersHIDDEN"},
};

void CheckForm(const Part& part) {
  const auto word = std::ranges::find(kWords, part.word, &Word::name);
  if (word == kWords.end()) {
    Refuse(part.text, "stem, residual, inverted, value, policy, own or others, and its numbers");
  }
  const bool block = part.word == "residual" || part.word == "inverted";
  if (part.numbers.size() < word->fewest || part.numbers.size() > word->most ||
      (part.repeats > 1 && !block)) {
    Refuse(part.text, word->form);
  }
}

void Apply(const Part& part, NetworkDescription& network) {
  CheckForm(part);
  if (part.word == "stem") {
    network.stem_channels = part.numbers[0];
    network.stem_stride = Number(part, 1, 1);
  } else if (part.word == "value") {
    network.value_channels = part.numbers[0];
    network.value_hidden = part.numbers[1];
  } else if (part.word == "policy") {
    network.policy_channels = part.numbers[0];
  } else if (part.word == "own") {
    network.own_hidden = part.numbers[0];
  } else if (part.word == "others") {
    network.others_hidden = part.numbers[0];
  } else {
    AddBlocks(part, network);
  }
}

NetworkDescription NetworkFromText(std::string_view text) {
  NetworkDescription network = SmallNetwork();
  network.blocks.clear();
  bool heads_of_cells = false;
  for (const std::string_view piece : Split(text, '+')) {
    const Part part = Read(piece);
    heads_of_cells |= part.word == "own" || part.word == "others";
    Apply(part, network);
  }
  if (!heads_of_cells && TowerBoardSize(network) != kBoardSize) {
    network.own_hidden = network.others_hidden = 0;
  }
  Validate(network);
  return network;
}

}  // namespace

NetworkDescription NetworkByName(std::string_view name) {
  if (name == "paper") return PaperNetwork();
  if (name == "small") return SmallNetwork();
  if (!name.starts_with("stem")) {
    throw Error(StrCat("unknown network '", name,
                       "', expected small, paper or a text such as "
                       "stem32+residual32x4+value4-64+policy4+own64+others64"));
  }
  return NetworkFromText(name);
}

}  // namespace powderkeg
