"""Many games at once."""

import threading
import unittest

import numpy as np

import powderkeg
from powderkeg import _native
from support import PowderkegTest


class GamesTest(unittest.TestCase):
    def test_shapes_and_types(self):
        games = powderkeg.Games(games=5, seed=1)
        step = games.step(np.zeros((5, 4), np.uint8))
        self.assertEqual((len(games), step.rewards.shape, step.rewards.dtype),
                         (5, (5, 4), np.float32))
        for array, dtype in zip(step[1:], (bool, np.uint8, np.uint16)):
            self.assertEqual((array.shape, array.dtype), ((5,), dtype))
        planes = games.planes((1, 3))
        self.assertEqual((planes.shape, planes.dtype), ((5, 2, 23, 11, 11), np.float32))
        self.assertEqual((games.alive().shape, games.alive().dtype), ((5, 4), bool))
        self.assertEqual(games.legal_actions().shape, (5, 4, 6))
        self.assertEqual(games.last_actions().dtype, np.uint8)
        seen = games.observations((0,))
        self.assertEqual((seen["board"].shape, seen["alive"].shape), ((5, 1, 11, 11), (5, 1, 4)))
        self.assertEqual(seen["step_count"].tolist(), [[1]] * 5)

    def test_planes_fill_the_room_that_is_given(self):
        games = powderkeg.Games(games=3, seed=1)
        room = np.empty((3, 4, 23, 11, 11), np.float32)
        self.assertIs(games.planes(out=room), room)
        self.assertTrue(np.array_equal(room, games.planes()))
        self.assertTrue(np.array_equal(room[:, 2], games.planes((2,))[:, 0]))
        own = room[0, 1, 10]  # agent 1 begins at row 9, column 1
        self.assertEqual((own[9, 1], own.sum()), (1.0, 1.0))

    def test_a_batch_is_its_games(self):
        """Each game of a batch goes as it goes alone, and as it goes among others."""
        policies = ["simple_unbiased", None, "official_simple", "random"]
        few = powderkeg.Games("PommeTeamCompetition-v0", 2, seed=7, policies=policies)
        many = powderkeg.Games("PommeTeamCompetition-v0", 40, seed=7, policies=policies)
        for _ in range(100):
            a = few.step(np.zeros((2, 4), np.uint8))
            b = many.step(np.zeros((40, 4), np.uint8))
            for one, other in zip(a, b):
                self.assertTrue(np.array_equal(one, other[:2]))
        self.assertEqual(few.text(1), many.text(1))

    def test_games_that_are_over_begin_anew(self):
        games = powderkeg.Games("OneVsOne-v0", 64, seed=1)
        rng = np.random.default_rng(1)
        ended = 0
        for _ in range(200):
            before = games.observations((0,))["step_count"][:, 0]
            step = games.step(rng.integers(6, size=(64, 4), dtype=np.uint8))
            self.assertTrue(np.array_equal(step.steps, before + 1))
            after = games.observations((0,))["step_count"][:, 0]
            self.assertTrue(np.array_equal(after, np.where(step.done, 0, step.steps)))
            won = step.winners > 0
            self.assertFalse((won & ~step.done).any())
            self.assertTrue(((step.rewards[:, 0] == 1) == (step.winners == 1)).all())
            ended += step.done.sum()
        self.assertGreater(ended, 64)

    def test_without_auto_reset_they_stay(self):
        games = powderkeg.Games("OneVsOne-v0", 16, seed=1, policies="random", auto_reset=False)
        nothing = np.zeros((16, 4), np.uint8)
        for _ in range(801):
            step = games.step(nothing)
        self.assertTrue(step.done.all())
        again = games.step(nothing)
        self.assertTrue(np.array_equal(again.steps, step.steps))
        self.assertFalse(again.rewards.any())
        games.reset()
        self.assertTrue(games.alive()[:, :2].all())

    def test_a_game_may_end_with_the_callers_agents(self):
        games = powderkeg.Games(games=8, seed=1, policies=[None, "idle", "idle", "idle"],
                                to_the_end=False)
        actions = np.zeros((8, 4), np.uint8)
        actions[:, 0] = 5
        ends = [games.step(actions) for _ in range(11)]
        done = [step for step in ends if step.done.any()]
        self.assertEqual(len(done), 1)
        self.assertEqual(done[0].rewards.tolist(), [[-1, 0, 0, 0]] * 8)

    def test_policies_move_their_seats(self):
        games = powderkeg.Games(games=32, seed=1, policies=[None, "random", "idle", None])
        seen = set()
        for _ in range(8):
            games.step(np.full((32, 4), 2, np.uint8))
            seen |= set(games.last_actions()[:, 1].tolist())
            self.assertFalse(games.last_actions()[:, 2].any())
            self.assertTrue((games.last_actions()[:, 0] == 2).all())
        self.assertEqual(seen, set(range(6)))

    def test_legal_actions_move(self):
        games = powderkeg.Games(games=32, seed=2)
        legal = games.legal_actions()
        before = games.observations()["position"]
        games.step(np.full((32, 4), 4, np.uint8))
        moved = (games.observations()["position"] != before).any(axis=-1)
        self.assertTrue(np.array_equal(moved, legal[:, :, 4]))

    def test_a_board_collapses_with_the_next_step(self):
        games = powderkeg.Games("PommeFFA-v1", 1, seed=1)
        nothing = np.zeros((1, 4), np.uint8)
        for _ in range(500):
            games.step(nothing)
        board = games.observations((0,))["board"][0, 0]
        self.assertFalse((board[0] == 1).all())
        games.step(nothing)
        board = games.observations((0,))["board"][0, 0]
        self.assertTrue((board[0] == 1).all() and (board[:, 10] == 1).all())

    def test_threads_take_turns(self):
        games = powderkeg.Games(games=64, seed=1)

        def work():
            for _ in range(50):
                games.step(np.full((64, 4), 5, np.uint8))
                games.planes((0,))
                games.reset()

        threads = [threading.Thread(target=work) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertTrue(games.alive().all())


class BadInputTest(PowderkegTest):
    def test_settings(self):
        self.refuses("games is 0, expected 1 to 1000000", powderkeg.Games, games=0)
        self.refuses("games is 1.5, expected an integer", powderkeg.Games, games=1.5)
        self.refuses("games is 2000000", powderkeg.Games, games=2_000_000)
        self.refuses("seed is -1", powderkeg.Games, games=1, seed=-1)
        self.refuses("environment is ''", powderkeg.Games, "")
        self.refuses("environment is 'x'", powderkeg.rules, "x")

    def test_actions(self):
        games = powderkeg.Games(games=3, seed=1)
        good = np.zeros((3, 4), np.uint8)
        self.refuses(r"actions has shape \(4, 3\), expected \(3, 4\)", games.step, good.T)
        self.refuses(r"actions has shape \(\), expected \(3, 4\)", games.step, None)
        self.refuses("actions has dtype float64, expected integers", games.step, np.zeros((3, 4)))
        self.refuses("actions has dtype <U1", games.step, np.full((3, 4), "a"))
        self.refuses("actions is no array", games.step, [[1, 2], [3]])
        bad = good.copy()
        bad[2, 1] = 6
        self.refuses(r"actions\[2, 1\] is 6, expected 0 to 5", games.step, bad)
        self.refuses("actions holds -1, expected 0 to 255", games.step, good.astype(int) - 1)
        self.refuses("messages are given in a game without radio", games.step, good,
                     np.zeros((3, 4, 2), np.uint8))
        self.assertEqual(games.step(good[::-1].astype(np.int64)).steps.tolist(), [1, 1, 1])

    def test_words(self):
        games = powderkeg.Games("PommeRadio-v2", games=1, seed=1)
        actions = np.zeros((1, 4), np.uint8)
        self.refuses("messages holds 8, expected 0 to 7", games.step, actions,
                     np.full((1, 4, 2), 8))
        self.refuses("messages has shape", games.step, actions, np.zeros((1, 4)))

    def test_views(self):
        games = powderkeg.Games(games=2, seed=1)
        self.refuses("agent is 4, expected an integer from 0 to 3", games.planes, (4,))
        self.refuses("out has shape", games.planes, out=np.empty((2, 3, 23, 11, 11), np.float32))
        self.refuses("out is no writable C-contiguous array of float32", games.planes,
                     out=np.empty((2, 4, 23, 11, 11)))
        fixed = np.empty((2, 4, 23, 11, 11), np.float32)
        fixed.flags.writeable = False
        self.refuses("out is no writable", games.planes, out=fixed)
        self.refuses("game is 2, expected 0 to 1", games.text, 2)
        self.refuses("game is -1", games.text, -1)

    def test_the_module_itself_is_safe(self):
        games = _native.Games("OneVsOne-v0", 2, 1, [None] * 4, True, True)
        self.refuses("agents holds -1", games.planes, [-1], None)
        self.refuses("agents holds 9", games.observations, [9])
        with self.assertRaises(TypeError):
            games.step(None, None)
        self.refuses("policies has 0 entries", _native.Games, "OneVsOne-v0", 2, 1, [], True, True)
        self.refuses("policy is 'x'", _native.Games, "OneVsOne-v0", 2, 1, ["x"] * 4, True, True)
