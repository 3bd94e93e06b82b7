#include "tools/board/board_routes.h"

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/base/check.h"
#include "common/base/number.h"
#include "tools/board/game_story.h"

namespace powderkeg {

extern const char* const kBoardPage;  // the text of board.html

namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMostSteps = 1'000'000;
constexpr std::uint64_t kMostNumber = std::uint64_t{1} << 53;  // what a page can count to

// The parameters of a request as numbers; what is wrong with the first wrong one.
class Numbers {
 public:
  explicit Numbers(const HttpRequest& request) : request_(request) {}

  [[nodiscard]] std::uint64_t Of(const std::string& name, std::uint64_t most) {
    const auto found = request_.parameters.find(name);
    const std::string text = found == request_.parameters.end() ? "" : found->second;
    const auto number = ParseNumber<std::uint64_t>(text);
    if ((!number || *number > most) && reason_.empty()) {
      reason_ = StrCat(name, " is '", text, "', expected a number from 0 to ", most);
    }
    return number.value_or(0);
  }
  // Empty: nothing.
  [[nodiscard]] const std::string& reason() const { return reason_; }

 private:
  const HttpRequest& request_;
  std::string reason_;
};

Json ListJson(const GameList& list) {
  Json games = Json::array();
  for (const ListedGame& game : list.games) {
    games.push_back({game.number, game.lineup, game.players, game.version, game.steps,
                     ResultName(game.result), game.winners});
  }
  return {{"source", list.source}, {"notes", list.notes}, {"games", std::move(games)}};
}

Json OpponentsJson(const PlaySettings& settings) {
  Json opponents = Json::array();
  for (int i = 0; i + 1 < SeatCount(settings.game.mode); ++i) {
    opponents.push_back(settings.opponents[i].text);
  }
  return opponents;
}

HttpReply GamesReply(GameLibrary* library, const PlayRoom* room) {
  Json json = ListJson(library == nullptr ? GameList() : library->List());
  json["play"] = room == nullptr ? Json() : OpponentsJson(room->settings());
  return {.body = json.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

HttpReply GameReply(GameLibrary& library, const HttpRequest& request) {
  Numbers numbers(request);
  const std::uint64_t number = numbers.Of("number", kMostNumber);
  if (!numbers.reason().empty()) return HttpError(400, numbers.reason());
  try {
    const std::optional<StoredGame> stored = library.Find(number);
    if (!stored) return HttpError(404, StrCat("game ", number, ": not in ", library.source()));
    return {.body = GameJson(*stored)};
  } catch (const Error& error) {
    return HttpError(422, error.what());
  }
}

HttpReply MoveReply(PlayRoom& room, const HttpRequest& request) {
  Numbers numbers(request);
  const std::uint64_t game = numbers.Of("game", kMostNumber);
  const auto step = static_cast<int>(numbers.Of("step", kMostSteps));
  const auto action = static_cast<Action>(numbers.Of("action", kActionCount - 1));
  if (!numbers.reason().empty()) return HttpError(400, numbers.reason());
  return room.Move(game, step, action);
}

HttpReply HintReply(PlayRoom& room, const HttpRequest& request) {
  Numbers numbers(request);
  const std::uint64_t game = numbers.Of("game", kMostNumber);
  const auto step = static_cast<int>(numbers.Of("step", kMostSteps));
  if (!numbers.reason().empty()) return HttpError(400, numbers.reason());
  return room.Hint(game, step);
}

}  // namespace

std::vector<HttpRoute> BoardRoutes(GameLibrary* library, PlayRoom* room) {
  std::vector<HttpRoute> routes = {
      {"GET", "/",
       [](const HttpRequest&) {
         return HttpReply{.body = kBoardPage, .type = "text/html; charset=utf-8"};
       }},
      {"GET", "/games.json", [=](const HttpRequest&) { return GamesReply(library, room); }},
  };
  if (library != nullptr) {
    routes.push_back({"GET", "/game.json",
                      [=](const HttpRequest& request) { return GameReply(*library, request); }});
  }
  if (room != nullptr) {
    routes.push_back({"POST", "/begin", [=](const HttpRequest&) { return room->Begin(); }});
    routes.push_back(
        {"POST", "/move", [=](const HttpRequest& request) { return MoveReply(*room, request); }});
    routes.push_back(
        {"POST", "/hint", [=](const HttpRequest& request) { return HintReply(*room, request); }});
  }
  return routes;
}

}  // namespace powderkeg
