#include "actors/http/observation_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "actors/runner/runner_json.h"
#include "common/pommerman/step.h"
#include "common/recorded/json_lines.h"
#include "common/recorded/recorded_game.h"

namespace powderkeg {
namespace {

using OrderedJson = nlohmann::ordered_json;
using ::testing::HasSubstr;

template <typename Value>
std::string ReasonOf(const Parsed<Value>& parsed) {
  const auto* refusal = std::get_if<Refusal>(&parsed);
  return refusal == nullptr ? "" : refusal->reason;
}

// --- Recorded observations ----------------------------------------------------------------------

// Base-36 digits as rows of a square.
template <typename Number>
OrderedJson RowsOf(const std::string& digits) {
  OrderedJson rows = OrderedJson::array();
  const std::size_t size = digits.size() == kCellCount ? 11 : 8;
  for (std::size_t row = 0; row < size; ++row) {
    OrderedJson values = OrderedJson::array();
    for (const char digit : digits.substr(row * size, size)) {
      values.push_back(static_cast<Number>(std::stoi(std::string(1, digit), nullptr, 36)));
    }
    rows.push_back(values);
  }
  return rows;
}

// A recorded observation as the runner sends it.
OrderedJson Sent(OrderedJson observation) {
  observation["board"] = RowsOf<int>(observation["board"]);
  for (const char* key :
       {"bomb_blast_strength", "bomb_life", "bomb_moving_direction", "flame_life"}) {
    observation[key] = RowsOf<double>(observation[key]);
  }
  return observation;
}

bool Lives(std::size_t agent, const OrderedJson& observation) {
  const auto alive = observation["alive"].get<std::vector<std::size_t>>();
  return std::ranges::find(alive, agent + 10) != alive.end();
}

// Every observation of a living agent in a file, up to `limit`.
std::vector<OrderedJson> RecordedObservations(const std::string& path, std::size_t limit) {
  std::vector<OrderedJson> observations;
  LineReader lines(path);
  std::string line;
  while (observations.size() < limit && lines.Next(line)) {
    const OrderedJson record = OrderedJson::parse(line);
    for (const char* key : {"obs", "o"}) {
      const OrderedJson seen = record.value(key, OrderedJson::array());
      for (std::size_t agent = 0; agent < seen.size(); ++agent) {
        if (Lives(agent, seen[agent])) observations.push_back(Sent(seen[agent]));
      }
    }
  }
  return observations;
}

class RecordedObservationTest : public ::testing::TestWithParam<std::string> {};

TEST_P(RecordedObservationTest, IsReadWithoutLoss) {
  const auto observations = RecordedObservations(StrCat("tests/data/", GetParam()), 1500);
  ASSERT_GT(observations.size(), 500U);
  for (const OrderedJson& sent : observations) {
    const auto parsed = ParseActionRequest(ActionBody(sent));
    ASSERT_EQ(ReasonOf(parsed), "") << sent;
    const auto& request = std::get<ActionRequest>(parsed);
    ASSERT_EQ(ObservationObject(request.settings, request.observation).dump(), sent.dump());
  }
}

// The `obs` of the bodies in which this program, as the runner, shows the state to the living.
std::vector<OrderedJson> SentFor(const GameSettings& settings, const State& state) {
  std::vector<OrderedJson> sent;
  for (AgentId agent = 0; agent < kAgentCount; ++agent) {
    if (!state.agents[agent].alive) continue;
    const OrderedJson body =
        OrderedJson::parse(ActionBody(settings, Observe(settings, state, agent)));
    sent.push_back(OrderedJson::parse(body["obs"].get<std::string>()));
  }
  return sent;
}

// The same of the states of a file that were recorded with observations, up to `limit`.
std::vector<OrderedJson> SentForStatesOf(const std::string& path, std::size_t limit) {
  std::vector<OrderedJson> sent;
  const auto add = [&](const RecordedGame& game, const State& state) {
    for (OrderedJson& each : SentFor(game.settings, state)) sent.push_back(std::move(each));
  };
  RecordedGameReader reader(path);
  for (RecordedGame game; reader.Next(game) && sent.size() < limit;) {
    if (game.observations) add(game, game.start);
    State state = game.start;
    for (const RecordedStep& step : game.steps) {
      Step(game.settings, step.actions, step.messages, state);
      if (step.observations) add(game, state);
      state = step.state;
    }
  }
  return sent;
}

TEST_P(RecordedObservationTest, IsWhatThisRunnerSendsForTheState) {
  constexpr std::size_t kLimit = 1500;
  const std::string path = StrCat("tests/data/", GetParam());
  const std::vector<OrderedJson> recorded = RecordedObservations(path, kLimit);
  const std::vector<OrderedJson> sent = SentForStatesOf(path, recorded.size());
  ASSERT_GE(sent.size(), recorded.size());
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    ASSERT_EQ(sent[i].dump(), recorded[i].dump()) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Files, RecordedObservationTest,
                         ::testing::Values("team.jsonl.gz", "radio.jsonl.gz",
                                           "one_vs_one.jsonl.gz"),
                         [](const auto& file) { return file.param.substr(0, 3); });

// --- Which environment --------------------------------------------------------------------------

// An empty free-for-all board with the agents in their corners, seen by agent 0.
Observation EmptyBoard() {
  Observation observation{};
  observation.board[CellAt(1, 1)] = CellValue::kAgent0;
  observation.board[CellAt(9, 1)] = static_cast<CellValue>(11);
  observation.board[CellAt(9, 9)] = static_cast<CellValue>(12);
  observation.board[CellAt(1, 9)] = static_cast<CellValue>(13);
  observation.alive = {true, true, true, true};
  observation.position = CellAt(1, 1);
  observation.blast_strength = 2;
  observation.ammo = 1;
  return observation;
}

OrderedJson FreeForAll() { return ObservationObject(GameSettings{}, EmptyBoard()); }

TEST(ActionRequestTest, SettingsFollowFromTheObservation) {
  for (const char* id : {"PommeFFACompetition-v0", "PommeFFA-v1", "PommeTeam-v0"}) {
    const GameSettings settings = GameSettingsFor(id).value();
    const auto parsed = ParseActionRequest(ActionBody(settings, EmptyBoard()));
    ASSERT_EQ(ReasonOf(parsed), "") << id;
    EXPECT_EQ(std::get<ActionRequest>(parsed).settings, settings) << id;
    EXPECT_EQ(std::get<ActionRequest>(parsed).observation, EmptyBoard()) << id;
  }
}

TEST(ActionRequestTest, SmallBoardLiesInTheTopLeftOfRigidWalls) {
  const GameSettings settings = GameSettingsFor("OneVsOne-v0").value();
  Observation observation{};
  observation.board.fill(CellValue::kRigid);
  observation.board[CellAt(1, 1)] = CellValue::kAgent0;
  observation.board[CellAt(6, 6)] = static_cast<CellValue>(11);
  observation.alive = {true, true, false, false};
  observation.self = 1;
  observation.position = CellAt(6, 6);
  observation.blast_strength = 2;
  const auto parsed = ParseActionRequest(ActionBody(settings, observation));
  ASSERT_EQ(ReasonOf(parsed), "");
  EXPECT_EQ(std::get<ActionRequest>(parsed).settings, settings);
  EXPECT_EQ(std::get<ActionRequest>(parsed).observation, observation);
}

TEST(ActionRequestTest, TakesIntegersForFloats) {
  OrderedJson object = FreeForAll();
  for (const char* key : {"bomb_life", "bomb_blast_strength"}) object[key][3][4] = 7;
  object["board"][3][4] = 3.0;
  object["ammo"] = 2.0;
  const auto parsed = ParseActionRequest(ActionBody(object));
  ASSERT_EQ(ReasonOf(parsed), "");
  EXPECT_EQ(std::get<ActionRequest>(parsed).observation.bomb_life[CellAt(3, 4)], 7);
  EXPECT_EQ(std::get<ActionRequest>(parsed).observation.ammo, 2);
}

// --- Other versions of the environment ----------------------------------------------------------

ActionRequest Accepted(const OrderedJson& object) {
  const auto parsed = ParseActionRequest(ActionBody(object));
  EXPECT_EQ(ReasonOf(parsed), "") << object;
  return std::get<ActionRequest>(parsed);
}

TEST(ActionRequestTest, NumbersOutOfRangeBecomeTheNearestInRange) {
  OrderedJson object = FreeForAll();
  object["can_kick"] = 1;
  object["blast_strength"] = 12;
  object["ammo"] = 11;
  object["board"][2][3] = 3;
  object["bomb_life"][2][3] = 25.0;
  object["bomb_blast_strength"][2][3] = 12.0;
  object["board"][5][5] = 4;
  object["flame_life"][5][5] = 7;
  const Observation observation = Accepted(object).observation;
  EXPECT_TRUE(observation.can_kick);
  EXPECT_EQ(observation.blast_strength, 10);
  EXPECT_EQ(observation.ammo, 10);
  EXPECT_EQ(observation.bomb_life[CellAt(2, 3)], 9);
  EXPECT_EQ(observation.bomb_blast_strength[CellAt(2, 3)], 10);
  EXPECT_EQ(observation.flame_life[CellAt(5, 5)], 3);
}

TEST(ActionRequestTest, AGameThatGoesOnHasNoLastStep) {
  OrderedJson object = FreeForAll();
  object["step_count"] = 801;
  EXPECT_EQ(Accepted(object).observation.step, 801);
  EXPECT_GT(Accepted(object).settings.max_steps, 10'000);
  object["step_count"] = 1e9;
  EXPECT_LT(Accepted(object).observation.step, Accepted(object).settings.max_steps);
}

TEST(ActionRequestTest, WhatIsMissingIsBelievedAndNamed) {
  OrderedJson object = FreeForAll();
  object["board"][2][3] = 3;
  object["board"][5][5] = 4;
  for (const char* key : {"alive", "flame_life", "bomb_moving_direction", "bomb_life", "game_env",
                          "step_count", "teammate", "enemies"}) {
    object.erase(key);
  }
  object["bomb_blast_strength"][2][3] = 4;
  const ActionRequest request = Accepted(object);
  EXPECT_EQ(request.believed,
            "game_env, bomb_life, bomb_moving_direction, flame_life, alive, step_count");
  EXPECT_FALSE(request.step_known);
  EXPECT_EQ(request.observation.alive, EmptyBoard().alive);
  EXPECT_EQ(request.observation.bomb_life[CellAt(2, 3)], 9);
  EXPECT_EQ(request.observation.bomb_blast_strength[CellAt(2, 3)], 4);
  EXPECT_EQ(request.observation.flame_life[CellAt(5, 5)], 3);
  EXPECT_EQ(Accepted(FreeForAll()).believed, "");
}

TEST(ActionRequestTest, TheBoardCountsWhereAnArrayContradictsIt) {
  OrderedJson object = FreeForAll();
  object["bomb_life"][2][3] = 5;
  object["bomb_moving_direction"][2][4] = 1;
  object["flame_life"][2][5] = 1;
  object["board"][9][1] = 0;
  object["alive"] = {10, 11, 12};
  Observation expected = EmptyBoard();
  expected.board[CellAt(9, 1)] = CellValue::kPassage;
  expected.alive = {true, false, true, true};
  EXPECT_EQ(Accepted(object).observation, expected);
}

TEST(ActionRequestTest, FogMayHaveAnyShape) {
  OrderedJson object = FreeForAll();
  object["game_type"] = 2;
  object["board"][10][10] = 5;
  EXPECT_EQ(Accepted(object).settings.view_radius, 9);
}

TEST(ActionRequestTest, BodiesMayBeEncodedOnce) {
  const OrderedJson body = {{"obs", FreeForAll()}};
  EXPECT_EQ(std::get<ActionRequest>(ParseActionRequest(body.dump())).observation, EmptyBoard());
  EXPECT_EQ(std::get<InitRequest>(ParseInitRequest(R"({"id": 2, "game_type": 1})")),
            (InitRequest{.id = 2, .mode = Mode::kFreeForAll}));
}

// --- What is refused ----------------------------------------------------------------------------

// The free-for-all observation with one value replaced (null: removed).
struct BadValue {
  std::string pointer;
  OrderedJson value;
  std::string reason;
};

OrderedJson With(const BadValue& bad) {
  OrderedJson object = FreeForAll();
  const OrderedJson::json_pointer pointer(bad.pointer);
  if (bad.value.is_null()) {
    object.erase(pointer.to_string().substr(1));
  } else {
    object[pointer] = bad.value;
  }
  return object;
}

const std::vector<BadValue>& BadValues() {
  static const std::vector<BadValue> values = {
      {"/board", nullptr, "the key board is missing"},
      {"/message", "x", ""},  // not read outside radio games
      {"/board", 3, "board is 3, expected a list"},
      {"/board", OrderedJson::array(), "board has 0 elements, expected 11"},
      {"/board/10", {1, 2}, "board[10] has 2 elements, expected 11"},
      {"/board/2/3", 14, "board[2] is 14, expected a whole number 0..13"},
      {"/board/2/3", -1, "board[2] is -1"},
      {"/board/2/3", 0.5, "board[2] is 0.5"},
      {"/board/2/3", "1", "board[2] is \"1\""},
      {"/board/2/3", true, "board[2] is true"},
      {"/board/2/3", 1e300, "board[2] is 1e+300"},
      {"/board/2/3", {{"a", 1}}, "board[2] is object"},
      {"/board/2/3", 9, "board[2][3] is 9, which is never on the board"},
      {"/board/2/3", 10, "agent 10 is shown 2 times"},
      {"/alive", {10, 11, 12, 13, 14}, "alive is no list of at most 4"},
      {"/alive", {9}, "alive is 9, expected a whole number 10..13"},
      {"/alive", 10, "alive is no list"},
      {"/position", {1, 2}, "board[1][2] is 0, expected the living agent"},
      {"/position", {1, 11}, "position[1] is 11"},
      {"/position", {1}, "position has 1 elements"},
      {"/position", nullptr, "the key position is missing"},
      {"/bomb_life", 3, "bomb_life is 3, expected a list"},
      {"/bomb_life/2/3", "x", "bomb_life[2] is \"x\", expected a number"},
      {"/ammo", OrderedJson::array(), "ammo is array, expected a number"},
      {"/can_kick", "yes", "can_kick is \"yes\", expected true or false"},
      {"/game_type", nullptr, "the key game_type is missing"},
      {"/game_type", 0, "game_type is 0"},
      {"/game_type", 5, "game_type is 5"},
      {"/game_type", 4, "board has 11 elements, expected 8"},
  };
  return values;
}

TEST(ActionRequestTest, BadValuesAreRefusedWithTheReason) {
  for (const BadValue& bad : BadValues()) {
    const std::string reason = ReasonOf(ParseActionRequest(ActionBody(With(bad))));
    EXPECT_THAT(reason, HasSubstr(bad.reason)) << bad.pointer << " " << bad.value;
    EXPECT_EQ(reason.empty(), bad.reason.empty()) << bad.pointer << " " << bad.value;
    EXPECT_EQ(reason.find('\n'), std::string::npos);
  }
}

TEST(ActionRequestTest, MoreBombsThanAStateHoldsAreRefused) {
  Observation observation = EmptyBoard();
  for (int bomb = 0; bomb <= kMaxBombs; ++bomb) {
    const auto cell = static_cast<std::size_t>(CellAt(2, 0) + bomb);
    observation.board[cell] = CellValue::kBomb;
    observation.bomb_life[cell] = 9;
    observation.bomb_blast_strength[cell] = 2;
  }
  EXPECT_EQ(ReasonOf(ParseActionRequest(ActionBody(GameSettings{}, observation))),
            "41 bombs, expected at most 40");
}

TEST(ActionRequestTest, WhatIsNoJsonIsRefused) {
  const std::string valid = ActionBody(FreeForAll());
  const std::vector<std::pair<std::string, std::string>> bodies = {
      {"", "the body is no JSON text"},
      {valid.substr(0, valid.size() / 2), "the body is no JSON text"},
      {valid + "}", "the body is no JSON text"},
      {"\xff\xfe", "the body is no JSON text"},
      {"null", "expected an object with the key obs, got null"},
      {"[]", "expected an object with the key obs, got array"},
      {"{}", "the key obs is missing"},
      {R"({"obs": {}})", "the key game_type is missing"},
      {R"({"obs": ""})", "obs is no JSON text"},
      {R"({"obs": "{"})", "obs is no JSON text"},
      {R"({"obs": "7"})", "expected an object with the key game_type, got 7"},
      {R"({"obs": "{}"})", "the key game_type is missing"},
  };
  for (const auto& [body, reason] : bodies) {
    EXPECT_EQ(ReasonOf(ParseActionRequest(body)), reason) << body;
  }
}

TEST(ActionRequestTest, EveryTruncationIsRefused) {
  const std::string body = ActionBody(FreeForAll());
  for (std::size_t length = 0; length < body.size(); length += 7) {
    EXPECT_NE(ReasonOf(ParseActionRequest(body.substr(0, length))), "") << length;
  }
}

TEST(ActionRequestTest, DeepNestingIsRefused) {
  constexpr std::size_t kDepth = 1'000'000;
  const std::string lists = std::string(kDepth, '[') + std::string(kDepth, ']');
  std::string objects;
  for (std::size_t i = 0; i < kDepth / 10; ++i) objects += R"({"a":)";
  EXPECT_NE(ReasonOf(ParseActionRequest(lists)), "");
  EXPECT_NE(ReasonOf(ParseActionRequest(objects)), "");
  EXPECT_NE(ReasonOf(ParseActionRequest(std::string(kDepth, '['))), "");
  OrderedJson object = FreeForAll();
  object["ammo"] = OrderedJson::parse(lists.substr(kDepth - 1000, 2000));
  EXPECT_NE(ReasonOf(ParseActionRequest(ActionBody(object))), "");
}

// --- The other bodies ---------------------------------------------------------------------------

TEST(InitRequestTest, ReadsWhatTheRunnerSends) {
  const auto parsed = ParseInitRequest(R"({"id": "2", "game_type": "3"})");
  ASSERT_EQ(ReasonOf(parsed), "");
  EXPECT_EQ(std::get<InitRequest>(parsed), (InitRequest{.id = 2, .mode = Mode::kTeamRadio}));
  EXPECT_EQ(std::get<InitRequest>(ParseInitRequest(InitBody(3, Mode::kOneVsOne))),
            (InitRequest{.id = 3, .mode = Mode::kOneVsOne}));
}

TEST(InitRequestTest, RefusesWithTheReason) {
  const std::vector<std::pair<std::string, std::string>> bodies = {
      {"{", "the body is no JSON text"},
      {R"({"id": "2"})", "the key game_type is missing"},
      {R"({"id": [2], "game_type": "1"})", "id is array, expected a whole number 0..3"},
      {R"({"id": "4", "game_type": "1"})", "id is 4, expected a whole number 0..3"},
      {R"({"id": "0", "game_type": "0"})", "game_type is 0, expected a whole number 1..4"},
      {R"({"id": "0", "game_type": "\"FFA\""})",
       "game_type is \"FFA\", expected a whole number 1..4"},
  };
  for (const auto& [body, reason] : bodies) EXPECT_EQ(ReasonOf(ParseInitRequest(body)), reason);
}

TEST(EpisodeEndTest, ReadsTheReward) {
  EXPECT_EQ(std::get<int>(ParseEpisodeEnd(R"({"reward": "-1"})")), -1);
  EXPECT_EQ(std::get<int>(ParseEpisodeEnd(R"({"reward": "1"})")), 1);
  EXPECT_EQ(ReasonOf(ParseEpisodeEnd(R"({"reward": "2"})")),
            "reward is 2, expected a whole number -1..1");
  EXPECT_EQ(ReasonOf(ParseEpisodeEnd("{}")), "the key reward is missing");
}

}  // namespace
}  // namespace powderkeg
