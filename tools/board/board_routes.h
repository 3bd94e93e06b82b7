#pragma once

// Games in a browser: the page, and what it asks for.

#include <vector>

#include "common/http/http_server.h"
#include "tools/board/game_library.h"
#include "tools/board/play_room.h"

namespace powderkeg {

//   GET /                         the page (board.html), which needs nothing but these routes
//   GET /games.json               source, notes, games: [number, lineup, players, version, steps,
//                                 result, winners] each; play: who is to be played against, or null
//   GET /game.json?number=N       GameJson
// and where there is a room:
//   POST /begin                   PlayRoom::Begin
//   POST /move?game=G&step=S&action=A
//   POST /hint?game=G&step=S
// 400: a parameter is no number of its range; 404: no such game; 422: a stored game that cannot be
// shown. Either argument may be nullptr; both must outlive the routes.
[[nodiscard]] std::vector<HttpRoute> BoardRoutes(GameLibrary* library, PlayRoom* room);

}  // namespace powderkeg
