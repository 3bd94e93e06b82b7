// Games in a browser: what the page is told, and what nonsense gets.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/base/check.h"
#include "common/segment/segment_file.h"
#include "tests/http/raw_socket.h"
#include "tests/learner/record_support.h"
#include "tools/board/board_routes.h"
#include "tools/board/game_story.h"

namespace powderkeg {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

constexpr const char* kRecorded = "tests/data/ffa.jsonl.gz";

PlaySettings SettingsAgainst(const std::string& opponent) {
  PlaySettings settings;
  settings.opponents.fill(ParseAgent(opponent));
  settings.adviser = ParseAgent("search:simulations=20");
  settings.loader = [](const std::string& file) -> Model { throw Error(file); };
  return settings;
}

struct Reply {
  int status;
  std::string body;

  [[nodiscard]] Json json() const { return Json::parse(body); }
};

// The library and a room, behind a server on a free port.
class BoardTest : public ::testing::Test {
 protected:
  [[nodiscard]] Reply Ask(const std::string& method, const std::string& target,
                          const std::string& headers = "") const {
    const std::string bytes =
        ExchangeBytes(server_.address().port,
                      StrCat(method, " ", target,
                             " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n",
                             headers, method == "POST" ? "Content-Length: 2\r\n\r\n{}" : "\r\n"));
    return {std::stoi(bytes.substr(bytes.find(' ') + 1)), bytes.substr(bytes.find("\r\n\r\n") + 4)};
  }
  [[nodiscard]] Reply Get(const std::string& target) const { return Ask("GET", target); }
  [[nodiscard]] Reply Post(const std::string& target) const { return Ask("POST", target); }

  GameLibrary library_{kRecorded};
  PlayRoom room_{SettingsAgainst("idle")};
  HttpServer server_{BoardRoutes(&library_, &room_), HttpServerSettings{}};
};

// --- Looking ------------------------------------------------------------------------------------

TEST_F(BoardTest, EveryListedGameIsToldAsItWasRecorded) {
  const Json list = Get("/games.json").json();
  EXPECT_EQ(list["source"], kRecorded);
  EXPECT_EQ(list["play"], Json({"idle", "idle", "idle"}));
  RecordedGameReader reader(kRecorded);
  RecordedGame recorded;
  for (std::size_t i = 0; i < list["games"].size(); ++i) {
    ASSERT_TRUE(reader.Next(recorded));
    if (i % 10 != 3) continue;
    const Json game = Get(StrCat("/game.json?number=", list["games"][i][0])).json();
    EXPECT_EQ(game["frames"].size(), recorded.steps.size() + 1);
    EXPECT_EQ(game["moves"].size(), recorded.steps.size());
    const Json& agents = game["frames"].back()[2];
    for (AgentId id = 0; id < kAgentCount; ++id) {
      const AgentState& agent = recorded.steps.back().state.agents[id];
      EXPECT_EQ(agents[5 * id], agent.cell);
      EXPECT_EQ(agents[5 * id + 1], agent.ammo);
      EXPECT_EQ(agents[5 * id + 4], int{agent.alive});
    }
  }
  EXPECT_FALSE(reader.Next(recorded));
}

TEST_F(BoardTest, EarlierGamesAreFoundAfterLaterOnes) {
  const std::string first = Get("/game.json?number=0").body;
  EXPECT_NE(Get("/game.json?number=7").body, first);
  EXPECT_EQ(Get("/game.json?number=0").body, first);
}

TEST_F(BoardTest, NonsenseGetsAReason) {
  const auto refused = [&](const Reply& reply, int status, const std::string& reason) {
    EXPECT_EQ(reply.status, status) << reply.body;
    EXPECT_THAT(reply.json()["error"].get<std::string>(), HasSubstr(reason));
  };
  refused(Get("/game.json"), 400, "number is ''");
  refused(Get("/game.json?number=two"), 400, "number is 'two', expected a number from 0");
  refused(Get("/game.json?number=-1"), 400, "number is '-1'");
  refused(Get("/game.json?number=100000"), 404, "game 100000: not in tests/data/ffa.jsonl.gz");
  refused(Get("/nothing"), 404, "no such route");
  refused(Get("/begin"), 405, "POST");
  refused(Post("/move?game=1&step=0&action=1"), 404, "game 1: never begun");
  const std::string game = Post("/begin").json()["game"].dump();
  refused(Post("/move?game=" + game + "&step=0&action=6"), 400, "action is '6', expected a number");
  refused(Post("/move?game=" + game + "&step=3&action=0"), 409, "step 3: expected 0");
  refused(Post("/hint?game=" + game + "&step=1"), 409, "step 1: expected 0");
}

TEST_F(BoardTest, PagesOfOthersGetNothing) {
  EXPECT_EQ(Ask("POST", "/begin", "Origin: http://example.com\r\n").status, 403);
  EXPECT_EQ(Ask("POST", "/begin", "Origin: http://localhost\r\n").status, 200);
  const std::string rebound = ExchangeBytes(
      server_.address().port, "GET /games.json HTTP/1.1\r\nHost: example.com\r\n\r\n");
  EXPECT_THAT(rebound, HasSubstr("403"));
}

// --- The library --------------------------------------------------------------------------------

std::string ReasonAgainst(const std::string& source) {
  try {
    GameLibrary library(source);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// A game of rule-based seats, one of which is said to be measured.
GameRecord RecordOf(std::uint64_t ticket) {
  GameRecord record;
  record.ticket = ticket;
  record.setup.seed = ticket;
  for (Seat& seat : record.setup.seats) seat.policy = PolicyKind::kIdle;
  record.actions.assign(800, JointAction{});
  record.outcome = {
      .done = true, .result = Result::kTie, .winners = 0, .rewards = {-1, -1, -1, -1}};
  return record;
}

void Write(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

TEST(GameLibraryTest, WhatCannotBeReadIsNamed) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "x.h5").string();
  EXPECT_THAT(ReasonAgainst("no/such.jsonl.gz"), HasSubstr("no/such.jsonl.gz"));
  EXPECT_THAT(ReasonAgainst("no/such.h5"), HasSubstr("no/such.h5"));
  EXPECT_THAT(ReasonAgainst("tests/data"), AllOf(HasSubstr("tests/data"), HasSubstr("replay/")));
  EXPECT_THAT(ReasonAgainst("tests/data/ci.textproto"), HasSubstr("tests/data/ci.textproto:1"));
  Write(path, std::vector<std::uint8_t>(1000, 'x'));
  EXPECT_THAT(ReasonAgainst(path), HasSubstr(path));
}

TEST(GameLibraryTest, ARunIsListedAsItGrows) {
  const TemporaryFolder folder;
  const std::filesystem::path replay = folder.path() / "replay";
  std::filesystem::create_directory(replay);
  Write(replay / "segment-00000001.h5", EncodeSegment(std::vector{RecordOf(5)}));
  GameLibrary library(folder.path().string());
  EXPECT_EQ(library.List().games.size(), 1);
  EXPECT_FALSE(library.Find(6));
  Write(replay / "segment-00000002.h5", EncodeSegment(std::vector{RecordOf(6), RecordOf(7)}));
  ASSERT_TRUE(library.Find(6));
  std::filesystem::remove(replay / "segment-00000001.h5");
  EXPECT_FALSE(library.Find(5));
  const GameList list = library.List();
  ASSERT_EQ(list.games.size(), 2);
  EXPECT_EQ(list.games[0].number, 7);
  EXPECT_EQ(list.games[0].players[2], "idle");
}

TEST(GameLibraryTest, AForgedGameIsListedAndNotShown) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "forged.h5").string();
  GameRecord forged = RecordOf(1);
  forged.outcome.winners = 1;
  Write(path, EncodeSegment(std::vector{forged}));
  GameLibrary library(path);
  const HttpServer server(BoardRoutes(&library, nullptr), HttpServerSettings{});
  const std::string reply = ExchangeBytes(
      server.address().port, "GET /game.json?number=1 HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(reply, AllOf(HasSubstr(" 422 "), HasSubstr("the outcome is not the true one")));
}

// --- Playing ------------------------------------------------------------------------------------

// The reply to the last move of a person who lays a bomb and stays on it.
Json PlayToTheEnd(PlayRoom& room) {
  Json told = Json::parse(room.Begin().body);
  const std::uint64_t game = told["game"];
  std::size_t frames = told["frames"].size();
  while (!told["over"]) {
    const HttpReply reply = room.Move(game, told["step"], Action::kBomb);
    EXPECT_EQ(reply.status, 200) << reply.body;
    told = Json::parse(reply.body);
    frames += told["frames"].size();
    EXPECT_EQ(frames, told["step"].get<std::size_t>() + 1);
  }
  EXPECT_EQ(room.Move(game, told["step"], Action::kStop).status, 409);
  EXPECT_EQ(room.Hint(game, told["step"]).status, 409);
  return told;
}

TEST(PlayRoomTest, AGameGoesOnToItsEndWithoutThePerson) {
  PlayRoom room(SettingsAgainst("simple_unbiased"));
  EXPECT_NE(PlayToTheEnd(room)["result"], "incomplete");
}

TEST(PlayRoomTest, SearchesOfOthersAreTold) {
  PlaySettings settings = SettingsAgainst("search:simulations=10");
  settings.game = GameSettingsFor("OneVsOne-v0").value();
  PlayRoom room(settings);
  const Json told = Json::parse(room.Begin().body);
  const Json moved = Json::parse(room.Move(told["game"], 0, Action::kStop).body);
  ASSERT_EQ(moved["searches"][1].size(), 1);
  EXPECT_EQ(moved["searches"][1][0][0], 0);
  EXPECT_TRUE(moved["searches"][0].empty());
}

TEST(PlayRoomTest, AHintIsTheSameHoweverOftenItIsAsked) {
  PlayRoom room(SettingsAgainst("idle"));
  const std::uint64_t game = Json::parse(room.Begin().body)["game"];
  ASSERT_EQ(room.Move(game, 0, Action::kStop).status, 200);
  const HttpReply hint = room.Hint(game, 1);
  EXPECT_EQ(hint.status, 200);
  EXPECT_EQ(room.Hint(game, 1).body, hint.body);
  EXPECT_EQ(room.Move(game, 1, Action::kStop).status, 200);
  EXPECT_EQ(room.Hint(game, 2).status, 200);
}

TEST(PlayRoomTest, GamesThatWereLeftAreForgotten) {
  PlayRoom room(SettingsAgainst("idle"));
  const std::uint64_t first = Json::parse(room.Begin().body)["game"];
  const std::uint64_t second = Json::parse(room.Begin().body)["game"];
  for (int i = 0; i < 15; ++i) {
    ASSERT_EQ(room.Begin().status, 200);
    EXPECT_EQ(room.Move(second, i, Action::kStop).status, 200);
  }
  EXPECT_EQ(room.Move(first, 0, Action::kStop).status, 404);
}

}  // namespace
}  // namespace powderkeg
