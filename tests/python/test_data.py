"""Segments and recorded games as arrays."""

import shutil
import warnings

import numpy as np

import powderkeg
from powderkeg import data
from support import DATA, PowderkegTest, write_data

DTYPES = {"ticket": np.uint64, "viewer": np.uint8, "step": np.uint16, "end_step": np.uint16,
          "searched": bool, "visits": np.uint16, "value": np.float32, "outcome": np.int8,
          "others": np.uint8, "planes": np.float32, "policy": np.float32}
SHAPES = {"visits": (6,), "others": (3,), "planes": (23, 11, 11), "policy": (6,)}


class BatchesTest(PowderkegTest):
    def setUp(self):
        super().setUp()
        write_data(self.folder)
        self.run_folder = self.folder / "run"
        self.segments = sorted((self.run_folder / "replay").iterdir())

    def test_a_run_is_its_segments(self):
        batches = list(powderkeg.batches(self.run_folder, 100))
        self.assertTrue(all(len(batch) == 100 for batch in batches[:-1]))
        self.assertTrue(0 < len(batches[-1]) <= 100)
        whole = data.joined(batches)
        for name, dtype in DTYPES.items():
            array = getattr(whole, name)
            self.assertEqual((array.shape, array.dtype),
                             ((len(whole), *SHAPES.get(name, ())), dtype), name)
        self.assertEqual(set(whole.ticket.tolist()), set(range(40)))
        parts = data.joined([data.joined(list(powderkeg.batches(file))) for file in self.segments])
        for name in DTYPES:
            self.assertTrue(np.array_equal(getattr(parts, name), getattr(whole, name)), name)

    def test_what_the_samples_say(self):
        batch = next(powderkeg.batches(self.run_folder))
        self.assertTrue((batch.viewer == 0).all() and batch.searched.all())
        self.assertTrue(np.allclose(batch.policy.sum(axis=1), 1))
        self.assertTrue((np.abs(batch.value) <= 0.5).all())
        self.assertTrue(np.isin(batch.outcome, (-1, 0, 1)).all())
        self.assertTrue((batch.step < batch.end_step).all())
        self.assertTrue((batch.others < 6).all())
        self.assertTrue((batch.planes[:, 10].sum(axis=(1, 2)) == 1).all())
        step = batch.planes[:, 22, 0, 0] * 799
        self.assertTrue(np.allclose(step, batch.step, atol=1e-3))
        self.assertIsNone(next(powderkeg.batches(self.run_folder, planes=False)).planes)

    def test_recorded_games_are_demonstrations(self):
        batches = list(powderkeg.batches(DATA / "ffa.jsonl.gz", 5000))
        whole = data.joined(batches)
        self.assertFalse(whole.searched.any() or whole.value.any())
        self.assertTrue((whole.visits.sum(axis=1) == 1).all())
        self.assertEqual(set(whole.viewer.tolist()), {0, 1, 2, 3})

    def test_planes_are_those_of_the_games(self):
        """What a stored game shows is what the games of this package show."""
        games = powderkeg.Games(games=1, seed=1)
        batch = next(powderkeg.batches(DATA / "ffa.jsonl.gz", 400))
        one = batch.planes[(batch.ticket == batch.ticket[0]) & (batch.viewer == 2)]
        self.assertEqual(games.planes((2,))[0, 0][14:].tolist(), one[0][14:].tolist())

    def test_damage_is_told(self):
        bytes_ = bytearray(self.segments[0].read_bytes())
        bytes_[len(bytes_) // 2] ^= 0xFF
        self.segments[0].write_bytes(bytes_)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            whole = data.joined(list(powderkeg.batches(self.run_folder)))
        self.assertEqual(len(caught), 1)
        self.assertRegex(str(caught[0].message), "segment-00000001.h5: .*lost games: ")
        self.assertIn(39, whole.ticket)

    def test_bad_input(self):
        self.refuses("batch_size is 0", powderkeg.batches, self.run_folder, 0)
        self.refuses("has no segments", powderkeg.batches, self.folder)
        for name in ("missing.h5", "missing.jsonl.gz"):
            self.refuses(name, next, powderkeg.batches(self.folder / name))
        for name in ("other.h5", "other.jsonl"):
            (self.folder / name).write_text("Not a segment.\n" * 100)
            self.refuses(name, next, powderkeg.batches(self.folder / name))
        shutil.copy(self.segments[0], self.folder / "cut.h5")
        whole = self.segments[0].read_bytes()
        for size in (0, 8, 100, len(whole) // 2, len(whole) - 1):
            (self.folder / "cut.h5").write_bytes(whole[:size])
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    list(powderkeg.batches(self.folder / "cut.h5"))
                except ValueError as error:
                    self.assertIn("cut.h5", str(error))
