#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstring>
#include <mutex>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/pommerman/board_text.h"
#include "common/pommerman/observation.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/game_batch.h"

namespace powderkeg {
namespace {

constexpr std::int64_t kMaxGames = 1'000'000;
constexpr int kWords = 8;  // 0: silence

// Which agents an array tells of, in its second dimension.
using Agents = std::vector<AgentId>;

// A batch that any thread may call, one at a time; none of them holds the interpreter meanwhile.
class Games {
 public:
  Games(const GameBatchSettings& settings, std::size_t size, std::uint64_t seed)
      : batch_(settings, size, seed) {}

  template <typename Work>
  auto Do(Work&& work) {
    const py::gil_scoped_release released;
    const std::scoped_lock lock(mutex_);
    return work(batch_);
  }

  [[nodiscard]] const GameBatchSettings& settings() const { return batch_.settings(); }
  [[nodiscard]] py::ssize_t size() const { return static_cast<py::ssize_t>(batch_.size()); }

 private:
  std::mutex mutex_;
  GameBatch batch_;
};

GameSettings SettingsFor(const std::string& environment) {
  if (const auto settings = GameSettingsFor(environment)) return *settings;
  throw Error(
      StrCat("environment is '", environment, "', expected one of ", KnownEnvironmentIds()));
}

std::optional<PolicyKind> PolicyFor(const std::optional<std::string>& name) {
  if (!name) return std::nullopt;
  if (const auto kind = PolicyKindFor(*name)) return kind;
  throw Error(StrCat("policy is '", *name, "', expected None, idle, random, harmless, ",
                     "simple_unbiased or official_simple"));
}

std::unique_ptr<Games> MakeGames(const std::string& environment, std::int64_t size,
                                 std::uint64_t seed,
                                 const std::vector<std::optional<std::string>>& policies,
                                 bool to_the_end, bool restart) {
  GameBatchSettings settings{.game = SettingsFor(environment),
                             .policies = {},
                             .to_the_end = to_the_end,
                             .restart = restart};
  if (size < 1 || size > kMaxGames) {
    throw Error(StrCat("games is ", size, ", expected 1 to ", kMaxGames));
  }
  if (policies.size() != kAgentCount) {
    throw Error(StrCat("policies has ", policies.size(), " entries, expected ", kAgentCount));
  }
  for (std::size_t i = 0; i < kAgentCount; ++i) settings.policies[i] = PolicyFor(policies[i]);
  return std::make_unique<Games>(settings, static_cast<std::size_t>(size), seed);
}

std::vector<JointAction> ActionsFrom(std::span<const std::uint8_t> values) {
  std::vector<JointAction> actions(values.size() / kAgentCount);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] >= kActionCount) {
      throw Error(StrCat("actions[", i / kAgentCount, ", ", i % kAgentCount, "] is ", +values[i],
                         ", expected 0 to ", kActionCount - 1));
    }
    actions[i / kAgentCount][i % kAgentCount] = static_cast<Action>(values[i]);
  }
  return actions;
}

using Messages = std::array<Message, kAgentCount>;
static_assert(sizeof(Messages) == 2 * kAgentCount);

std::vector<Messages> MessagesFrom(const Games& games, const py::object& given) {
  if (given.is_none()) return {};
  if (games.settings().game.mode != Mode::kTeamRadio) {
    throw Error("messages are given in a game without radio, expected None");
  }
  const auto words =
      Integers<std::uint8_t>("messages", py::array(given), {games.size(), kAgentCount, 2});
  std::vector<Messages> messages(static_cast<std::size_t>(games.size()));
  std::memcpy(messages.data(), words.data(), messages.size() * sizeof(Messages));
  for (const Messages& row : messages) {
    for (const Message& message : row) {
      for (const std::uint8_t word : message) {
        if (word >= kWords) throw Error(StrCat("messages holds ", +word, ", expected 0 to 7"));
      }
    }
  }
  return messages;
}

py::tuple StepGames(Games& games, const py::array& given, const py::object& words) {
  const auto values = Integers<std::uint8_t>("actions", given, {games.size(), kAgentCount});
  const std::vector<JointAction> actions = ActionsFrom(Values(values));
  const std::vector<Messages> messages = MessagesFrom(games, words);
  Array<float> rewards({games.size(), py::ssize_t{kAgentCount}});
  Array<bool> done(games.size());
  Array<std::uint8_t> winners(games.size());
  Array<std::uint16_t> steps(games.size());
  const StepResults results{Values(rewards), Values(done), Values(winners), Values(steps)};
  games.Do([&](GameBatch& batch) { batch.Step(actions, messages, results); });
  return py::make_tuple(rewards, done, winners, steps);
}

Agents Checked(const Agents& agents) {
  for (const AgentId agent : agents) {
    if (agent < 0 || agent >= kAgentCount) {
      throw Error(StrCat("agents holds ", agent, ", expected 0 to ", kAgentCount - 1));
    }
  }
  return agents;
}

// Calls visit(state, agent, row) for these agents of every game; rows are numbered in this order.
template <typename Visit>
void ForEachView(Games& games, const Agents& agents, Visit&& visit) {
  games.Do([&](const GameBatch& batch) {
    std::size_t row = 0;
    for (std::size_t game = 0; game < batch.size(); ++game) {
      for (const AgentId agent : agents) visit(batch.state(game), agent, row++);
    }
  });
}

Shape ViewShape(const Games& games, const Agents& agents, std::initializer_list<int> rest) {
  Shape shape{games.size(), static_cast<py::ssize_t>(agents.size())};
  shape.insert(shape.end(), rest.begin(), rest.end());
  return shape;
}

Array<float> Planes(Games& games, const Agents& given, const py::object& out) {
  const Agents agents = Checked(given);
  auto planes =
      Room<float>("out", out, ViewShape(games, agents, {kPlaneCount, kBoardSize, kBoardSize}));
  float* const first = planes.mutable_data();
  const GameSettings& settings = games.settings().game;
  ForEachView(games, agents, [&](const State& state, AgentId agent, std::size_t row) {
    const BitBoard visible = VisibleCells(settings, state.agents[agent].cell);
    EncodePlanes(settings, {&state, agent, visible},
                 std::span<float, kPlanesSize>(first + row * kPlanesSize, kPlanesSize));
  });
  return planes;
}

// One array of an observation: `size` numbers of type T per agent.
template <typename T>
struct Column {
  Column(const Games& games, const Agents& agents, std::initializer_list<int> shape)
      : array(ViewShape(games, agents, shape)), first(array.mutable_data()), size(1) {
    for (const int extent : shape) size *= static_cast<std::size_t>(extent);
  }
  void Put(std::size_t row, const auto& value) {
    static_assert(sizeof(value) % sizeof(T) == 0);
    std::memcpy(first + row * size, &value, sizeof(T) * size);
  }
  Array<T> array;
  T* first;
  std::size_t size;
};

py::dict Observations(Games& games, const Agents& given) {
  const Agents agents = Checked(given);
  using Bytes = Column<std::uint8_t>;
  constexpr int kSide = kBoardSize;
  Bytes board(games, agents, {kSide, kSide}), strengths(games, agents, {kSide, kSide}),
      lives(games, agents, {kSide, kSide}), directions(games, agents, {kSide, kSide}),
      flames(games, agents, {kSide, kSide}), position(games, agents, {2}),
      strength(games, agents, {}), ammo(games, agents, {}), message(games, agents, {2});
  Column<bool> alive(games, agents, {kAgentCount}), can_kick(games, agents, {});
  Column<std::uint16_t> step(games, agents, {});
  const GameSettings& settings = games.settings().game;
  ForEachView(games, agents, [&](const State& state, AgentId agent, std::size_t row) {
    const Observation seen = Observe(settings, state, agent);
    board.Put(row, seen.board);
    strengths.Put(row, seen.bomb_blast_strength);
    lives.Put(row, seen.bomb_life);
    directions.Put(row, seen.bomb_moving_direction);
    flames.Put(row, seen.flame_life);
    alive.Put(row, seen.alive);
    position.Put(row, std::array{static_cast<std::uint8_t>(RowOf(seen.position)),
                                 static_cast<std::uint8_t>(ColumnOf(seen.position))});
    strength.Put(row, seen.blast_strength);
    can_kick.Put(row, seen.can_kick);
    ammo.Put(row, seen.ammo);
    step.Put(row, seen.step);
    message.Put(row, seen.message);
  });
  py::dict result;
  result["alive"] = alive.array;
  result["board"] = board.array;
  result["bomb_blast_strength"] = strengths.array;
  result["bomb_life"] = lives.array;
  result["bomb_moving_direction"] = directions.array;
  result["flame_life"] = flames.array;
  result["position"] = position.array;
  result["blast_strength"] = strength.array;
  result["can_kick"] = can_kick.array;
  result["ammo"] = ammo.array;
  result["step_count"] = step.array;
  result["message"] = message.array;
  return result;
}

Agents AllAgents() { return {0, 1, 2, 3}; }

Array<bool> Alive(Games& games) {
  Array<bool> alive({games.size(), py::ssize_t{kAgentCount}});
  bool* const first = alive.mutable_data();
  ForEachView(games, AllAgents(), [&](const State& state, AgentId agent, std::size_t row) {
    first[row] = state.agents[agent].alive;
  });
  return alive;
}

constexpr ActionSet kStopAlone = 1;

Array<bool> Legal(Games& games) {
  Array<bool> legal(ViewShape(games, AllAgents(), {kActionCount}));
  bool* const first = legal.mutable_data();
  ForEachView(games, AllAgents(), [&](const State& state, AgentId agent, std::size_t row) {
    const ActionSet set = state.agents[agent].alive ? LegalActions(state, agent) : kStopAlone;
    for (std::size_t i = 0; i < kActionCount; ++i) first[row * kActionCount + i] = Has(set, i);
  });
  return legal;
}

Array<std::uint8_t> LastActions(Games& games) {
  Array<std::uint8_t> actions({games.size(), py::ssize_t{kAgentCount}});
  std::uint8_t* const first = actions.mutable_data();
  games.Do([&](const GameBatch& batch) {
    for (std::size_t i = 0; i < batch.size(); ++i) {
      std::memcpy(first + i * kAgentCount, &batch.actions(i), sizeof(JointAction));
    }
  });
  return actions;
}

std::string Text(Games& games, std::int64_t game) {
  if (game < 0 || game >= games.size()) {
    throw Error(StrCat("game is ", game, ", expected 0 to ", games.size() - 1));
  }
  return games.Do(
      [&](const GameBatch& batch) { return ToText(batch.state(static_cast<std::size_t>(game))); });
}

py::dict Rules(const std::string& environment) {
  const GameSettings settings = SettingsFor(environment);
  py::dict rules;
  rules["game_type"] = static_cast<int>(settings.mode);
  rules["board_size"] = settings.board_size;
  rules["max_steps"] = settings.max_steps;
  rules["blast_strength_cap"] = settings.blast_strength_cap;
  rules["view_radius"] = settings.view_radius;
  rules["collapse_steps"] = settings.collapse_steps;
  rules["agents"] = SeatCount(settings.mode);
  return rules;
}

}  // namespace

void BindGames(py::module_& module) {
  using py::arg;
  module.attr("ENVIRONMENT_IDS") = py::str(KnownEnvironmentIds()).attr("split")(", ");
  module.def("rules", &Rules, arg("environment"));
  py::class_<Games>(module, "Games")
      .def(py::init(&MakeGames), arg("environment"), arg("games"), arg("seed"), arg("policies"),
           arg("to_the_end"), arg("restart"))
      .def("__len__", &Games::size)
      .def(
          "reset",
          [](Games& games, std::optional<std::uint64_t> seed) {
            games.Do([&](GameBatch& batch) { batch.Reset(seed); });
          },
          arg("seed"))
      .def("step", &StepGames, arg("actions"), arg("messages"))
      .def("planes", &Planes, arg("agents"), arg("out"))
      .def("observations", &Observations, arg("agents"))
      .def("alive", &Alive)
      .def("legal_actions", &Legal)
      .def("last_actions", &LastActions)
      .def("text", &Text, arg("game"));
}

}  // namespace powderkeg
