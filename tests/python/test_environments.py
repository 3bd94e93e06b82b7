"""The environments by the documents of PettingZoo and Gymnasium, whether these are there or not."""

import unittest

import numpy as np

import powderkeg
from support import PowderkegTest

try:
    import gymnasium
    from gymnasium.utils.env_checker import check_env
except ImportError:
    gymnasium = None
try:
    import pettingzoo
    from pettingzoo.test import parallel_api_test, parallel_seed_test
except ImportError:
    pettingzoo = None

FREE_FOR_ALL = "PommeFFACompetition-v0"
TEAM = "PommeTeamCompetition-v0"
RADIO = "PommeRadioCompetition-v2"
DUEL = "OneVsOne-v0"
OFFICIAL_KEYS = ["alive", "board", "bomb_blast_strength", "bomb_life", "bomb_moving_direction",
                 "flame_life", "game_type", "game_env", "position", "blast_strength", "can_kick",
                 "teammate", "ammo", "enemies", "step_count"]


def same(a, b):
    """Whether two observations are equal."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(np.array_equal(a[key], b[key]) for key in a)
    return np.array_equal(a, b)


class ParallelTest(unittest.TestCase):
    def play(self, environment, **options):
        """A game of random actions that checks what the documents promise; its steps."""
        env = powderkeg.ParallelEnv(environment, **options)
        observations, infos = env.reset(seed=3)
        self.assertEqual(env.agents, env.possible_agents)
        total, gone, steps = {}, set(), 0
        while env.agents:
            names = list(env.agents)
            self.assertEqual(list(observations), names)
            self.assertEqual(list(infos), names)
            for name in names:
                self.assertIn(observations[name], env.observation_space(name))
                self.assertIs(env.action_space(name), env.action_space(name))
                self.assertIs(env.observation_space(name), env.observation_space(name))
            actions = {name: env.action_space(name).sample() for name in names}
            observations, rewards, terminations, truncations, infos = env.step(actions)
            steps += 1
            for result in (observations, rewards, terminations, truncations, infos):
                self.assertEqual(list(result), names)
            for name in names:
                total[name] = total.get(name, 0.0) + rewards[name]
                self.assertIsInstance(rewards[name], float)
                self.assertIs(truncations[name], False)
                if terminations[name]:
                    gone.add(name)
                    self.assertIn("winners", infos[name])
            self.assertFalse(gone & set(env.agents))
            self.assertEqual(set(env.agents) | gone, set(env.possible_agents))
            if env.agents:
                observations = {name: observations[name] for name in env.agents}
                infos = {name: infos[name] for name in env.agents}
        for value in total.values():
            self.assertIn(value, (-1.0, 0.0, 1.0))
        return steps

    def test_games_of_every_environment_end(self):
        for environment in powderkeg.ENVIRONMENT_IDS:
            for observation in ("planes", "arrays"):
                with self.subTest(environment, observation=observation):
                    steps = self.play(environment, observation=observation)
                    self.assertLessEqual(steps, 800)

    def test_policies_take_seats(self):
        env = powderkeg.ParallelEnv(TEAM, policies=[None, "simple_unbiased", None, "random"])
        self.assertEqual(env.possible_agents, ["agent_0", "agent_2"])
        self.assertGreater(self.play(TEAM, policies=[None, "simple_unbiased", None, "random"]), 0)
        with self.assertRaisesRegex(ValueError, "policies has no None"):
            powderkeg.ParallelEnv(FREE_FOR_ALL, policies="random")

    def test_dead_agents_stay_in_team_games_alone(self):
        """In free-for-all an agent leaves with its death."""
        env = powderkeg.ParallelEnv(FREE_FOR_ALL)
        env.reset(seed=1)
        bomb, rewards, infos = 5, {}, {}
        for _ in range(12):
            actions = dict.fromkeys(env.agents, 0) | {"agent_1": bomb}
            _, rewards, terminations, _, infos = env.step(actions)
            if terminations["agent_1"]:
                break
        self.assertEqual(rewards["agent_1"], -1.0)
        self.assertEqual(infos["agent_1"]["winners"], [])
        self.assertEqual(env.agents, ["agent_0", "agent_2", "agent_3"])
        env = powderkeg.ParallelEnv(TEAM)
        env.reset(seed=1)
        for _ in range(12):
            _, rewards, _, _, infos = env.step(dict.fromkeys(env.agents, 0) | {"agent_1": bomb})
        self.assertEqual(env.num_agents, 4)
        self.assertEqual(rewards["agent_1"], 0.0)
        self.assertEqual(infos["agent_1"]["action_mask"].tolist(), [1, 0, 0, 0, 0, 0])

    def test_equal_seeds_give_equal_games(self):
        def story(seed):
            env = powderkeg.ParallelEnv(FREE_FOR_ALL, policies=[None] + ["simple_unbiased"] * 3)
            seen = [env.reset(seed=seed)[0]["agent_0"]]
            while env.agents and len(seen) < 40:
                seen.append(env.step({"agent_0": 0})[0]["agent_0"])
            seen.append(env.reset()[0]["agent_0"])
            return np.array(seen)

        self.assertTrue(np.array_equal(story(5), story(5)))
        self.assertFalse(np.array_equal(story(5)[0], story(6)[0]))
        self.assertFalse(np.array_equal(story(5)[0], story(5)[-1]))

    def test_observations_are_kept_by_later_steps(self):
        env = powderkeg.ParallelEnv(DUEL, observation="arrays")
        first = env.reset(seed=1)[0]["agent_0"]
        copy = {key: value.copy() for key, value in first.items()}
        env.step({"agent_0": 5, "agent_1": 5})
        self.assertTrue(same(first, copy))

    def test_fog_hides(self):
        env = powderkeg.ParallelEnv(TEAM, observation="arrays")
        board = env.reset(seed=1)[0]["agent_0"]["board"]
        self.assertTrue((board[6:] == 5).all() and (board[:, 6:] == 5).all())
        self.assertFalse((board[:6, :6] == 5).any())
        planes = powderkeg.ParallelEnv(TEAM).reset(seed=1)[0]["agent_0"]
        self.assertFalse(planes[:14, 6:].any())

    def test_words_arrive(self):
        env = powderkeg.ParallelEnv(RADIO, observation="arrays")
        env.reset(seed=1)
        actions = {"agent_0": [0, 3, 4], "agent_1": 0, "agent_2": np.array([0, 7, 1]),
                   "agent_3": (0, 0, 0)}
        observations = env.step(actions)[0]
        messages = [observations[name]["message"].tolist() for name in env.agents]
        self.assertEqual(messages, [[7, 1], [0, 0], [3, 4], [0, 0]])
        self.assertEqual(env.official_observation("agent_2")["message"], (3, 4))


class OfficialObservationTest(unittest.TestCase):
    def observe(self, environment, agent="agent_0"):
        env = powderkeg.ParallelEnv(environment)
        env.reset(seed=1)
        return env.official_observation(agent)

    def test_free_for_all(self):
        seen = self.observe(FREE_FOR_ALL, "agent_1")
        self.assertEqual(list(seen), OFFICIAL_KEYS)
        self.assertEqual(seen["alive"], [10, 11, 12, 13])
        self.assertEqual((seen["board"].shape, seen["board"].dtype), ((11, 11), np.uint8))
        self.assertEqual(seen["bomb_life"].dtype, np.float64)
        self.assertEqual(seen["board"][seen["position"]], 11)
        self.assertEqual((seen["position"], seen["teammate"]), ((9, 1), 9))
        self.assertEqual(seen["enemies"], [10, 12, 13])
        self.assertEqual((seen["game_type"], seen["game_env"]), (1, "pommerman.envs.v0:Pomme"))
        self.assertEqual((seen["ammo"], seen["blast_strength"], seen["can_kick"]), (1, 2, False))

    def test_team_radio_and_duel(self):
        seen = self.observe("PommeTeamCompetition-v1", "agent_1")
        self.assertEqual((seen["teammate"], seen["enemies"]), (13, [10, 12, 9]))
        self.assertEqual(seen["game_env"], "pommerman.envs.v1:Pomme")
        seen = self.observe(RADIO)
        self.assertEqual(list(seen), OFFICIAL_KEYS + ["message"])
        self.assertEqual((seen["message"], seen["game_env"]), ((0, 0), "pommerman.envs.v2:Pomme"))
        seen = self.observe(DUEL)
        self.assertEqual((seen["teammate"], seen["enemies"], seen["alive"]), (9, [11], [10, 11]))
        self.assertEqual(seen["board"].shape, (8, 8))

    def test_bombs_and_flames(self):
        env = powderkeg.ParallelEnv(DUEL)
        env.reset(seed=1)
        env.step({"agent_0": 5, "agent_1": 0})
        seen = env.official_observation("agent_1")
        self.assertEqual((seen["bomb_life"][1, 1], seen["bomb_blast_strength"][1, 1]), (9.0, 2.0))
        self.assertEqual((seen["board"][1, 1], seen["step_count"]), (10, 1))


class SingleAgentTest(unittest.TestCase):
    def test_a_game(self):
        for observation in ("planes", "arrays"):
            env = powderkeg.Env(FREE_FOR_ALL, agent=2, observation=observation)
            seen, info = env.reset(seed=4)
            self.assertEqual(info["action_mask"].shape, (6,))
            terminated, total = False, 0.0
            while not terminated:
                self.assertIn(seen, env.observation_space)
                seen, reward, terminated, truncated, info = env.step(env.action_space.sample())
                self.assertFalse(truncated)
                total += reward
            self.assertIn(total, (-1.0, 1.0))

    def test_render(self):
        env = powderkeg.Env(DUEL, render_mode="ansi", policies="idle")
        env.reset(seed=1)
        board = env.render().splitlines()[:8]
        self.assertEqual([len(line) for line in board], [8] * 8)
        self.assertEqual((board[1][1], board[6][6]), ("0", "1"))
        env = powderkeg.Env(render_mode="rgb_array")
        env.reset(seed=1)
        self.assertEqual((env.render().shape, env.render().dtype), ((264, 264, 3), np.uint8))


class BadInputTest(PowderkegTest):
    def test_settings(self):
        self.refuses("environment is 'Pomme', expected one of PommeFFA", powderkeg.ParallelEnv,
                     "Pomme")
        self.refuses("environment is 3, expected a text", powderkeg.Env, 3)
        self.refuses("policy is 'clever', expected one of .*simple_unbiased", powderkeg.Env,
                     policies="clever")
        self.refuses("policies has 3 entries, expected 4", powderkeg.Env, policies=[None] * 3)
        self.refuses("agent is 4, expected an integer from 0 to 3", powderkeg.Env, agent=4)
        self.refuses("agent is 2, expected an integer from 0 to 1", powderkeg.Env, DUEL, agent=2)
        self.refuses("observation is 'rgb'", powderkeg.Env, observation="rgb")
        self.refuses("render_mode is 'human'", powderkeg.Env, render_mode="human")

    def test_actions(self):
        env = powderkeg.ParallelEnv(DUEL)
        env.reset(seed=1)
        for action in (6, -1, 2.0, "up", None, [1], [1, 2, 3], 10**30, np.zeros((2, 2)), [[1], 2]):
            with self.subTest(action=action):
                self.refuses("action of agent_1 ", env.step, {"agent_0": 0, "agent_1": action})
        self.refuses("actions has .'agent_0'., expected a dictionary of", env.step, {"agent_0": 0})
        self.refuses("actions has ", env.step, {"agent_0": 0, "agent_1": 0, "agent_7": 0})
        self.refuses("actions has ", env.step, [0, 0])
        env = powderkeg.ParallelEnv(RADIO)
        env.reset(seed=1)
        self.refuses("action of agent_0 is .0, 8, 0.", env.step,
                     dict.fromkeys(env.agents, 0) | {"agent_0": [0, 8, 0]})

    def test_resets(self):
        env = powderkeg.Env()
        self.refuses("seed is -1", env.reset, seed=-1)
        self.refuses("seed is 'a'", env.reset, seed="a")
        self.refuses("options has the key 'size', expected none", env.reset,
                     options={"size": 11})
        self.refuses("agent is 'agent_9'", powderkeg.ParallelEnv().observation_space, "agent_9")

    def test_the_wrong_order(self):
        env = powderkeg.Env(DUEL, policies="idle")
        with self.assertRaisesRegex(RuntimeError, "no game is running, call reset first"):
            env.step(0)
        env.reset(seed=1)
        terminated = False
        while not terminated:
            terminated = env.step(5)[2]
        with self.assertRaisesRegex(RuntimeError, "no game is running, call reset first"):
            env.step(0)
        env.close()
        env.close()
        for call in (env.reset, env.render, env.official_observation, lambda: env.step(0)):
            with self.assertRaisesRegex(RuntimeError, "closed"):
                call()


@unittest.skipIf(pettingzoo is None, "PettingZoo is not installed")
class PettingZooTest(unittest.TestCase):
    def test_its_own_tests_pass(self):
        for environment in (FREE_FOR_ALL, TEAM, RADIO, DUEL):
            for observation in ("planes", "arrays"):
                env = powderkeg.ParallelEnv(environment, observation=observation)
                parallel_api_test(env, num_cycles=300)
        parallel_seed_test(lambda: powderkeg.ParallelEnv(TEAM))


@unittest.skipIf(gymnasium is None, "Gymnasium is not installed")
class GymnasiumTest(unittest.TestCase):
    def test_its_own_test_passes(self):
        for environment in (FREE_FOR_ALL, TEAM, RADIO, DUEL):
            for observation in ("planes", "arrays"):
                env = powderkeg.Env(environment, observation=observation, render_mode="rgb_array")
                check_env(env, skip_render_check=True)
