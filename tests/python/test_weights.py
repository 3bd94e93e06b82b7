"""Weights in and out, and the network as a PyTorch module."""

import copy
import dataclasses
import json
import pickle
import unittest

import numpy as np

import powderkeg
from support import PowderkegTest, write_data

try:
    import torch
except ImportError:
    torch = None


def header_of(path):
    """The header of a safetensors file, and what follows it."""
    data = path.read_bytes()
    end = 8 + int.from_bytes(data[:8], "little")
    return json.loads(data[8:end]), data[end:]


def write_safetensors(path, header, values):
    text = json.dumps(header).encode()
    path.write_bytes(len(text).to_bytes(8, "little") + text + values)


class WeightsTest(PowderkegTest):
    def setUp(self):
        super().setUp()
        write_data(self.folder)
        self.weights = powderkeg.load_weights(self.folder / "small.weights")

    def assert_same(self, a, b):
        self.assertEqual((a.version, a.description, a.canary), (b.version, b.description, b.canary))
        self.assertEqual(list(a.arrays), list(b.arrays))
        for name, array in a.arrays.items():
            self.assertTrue(np.array_equal(array, b.arrays[name]), name)

    def test_a_file(self):
        self.assertEqual(self.weights.version, 3)
        self.assertEqual(self.weights.description["planes"], 23)
        self.assertEqual(self.weights.arrays["stem.conv.weight"].dtype, np.float32)
        canary = self.weights.canary
        self.assertEqual((len(canary), canary.planes.shape), (6, (6, 23, 11, 11)))
        self.assertTrue(np.allclose(canary.policy.sum(axis=1), 1, atol=1e-5))
        self.assertEqual((canary.value.shape, canary.others.shape), ((6,), (6, 3, 6)))
        self.assertEqual(list(canary.viewer), [0, 1, 2, 3, 0, 1])

    def test_the_way_there_and_back(self):
        for name in ("small", "paper"):
            file = self.folder / f"{name}.weights"
            weights = powderkeg.load_weights(file)
            powderkeg.save_safetensors(weights, self.folder / "x.safetensors")
            back = powderkeg.load_safetensors(self.folder / "x.safetensors")
            self.assert_same(weights, back)
            powderkeg.save_weights(back, self.folder / "back.weights")
            self.assertEqual((self.folder / "back.weights").read_bytes(), file.read_bytes())

    def test_safetensors_as_the_format_is_described(self):
        path = self.folder / "x.safetensors"
        for version in (1, 10, 100):  # the header grows by a byte
            powderkeg.save_safetensors(dataclasses.replace(self.weights, version=version), path)
            header, values = header_of(path)
            self.assertEqual((path.stat().st_size - len(values)) % 8, 0)
        self.assertTrue(all(isinstance(text, str) for text in header.pop("__metadata__").values()))
        end = 0
        for name, entry in header.items():
            self.assertEqual((entry["dtype"], entry["data_offsets"][0]), ("F32", end))
            end = entry["data_offsets"][1]
            array = np.frombuffer(values[entry["data_offsets"][0]:end], "<f4")
            self.assertTrue(np.array_equal(array, self.weights.arrays[name].ravel()))
        self.assertEqual(end, len(values))

    def test_copies(self):
        self.assert_same(copy.deepcopy(self.weights), self.weights)
        self.assert_same(pickle.loads(pickle.dumps(self.weights)), self.weights)

    def test_weights_without_a_file(self):
        weights = powderkeg.load_weights("untrained:small")
        self.assertEqual((weights.version, len(weights.canary)), (0, 0))
        powderkeg.save_safetensors(weights, self.folder / "x.safetensors")
        self.assert_same(powderkeg.load_safetensors(self.folder / "x.safetensors"), weights)

    def test_bad_files(self):
        self.refuses("missing.weights", powderkeg.load_weights, self.folder / "missing.weights")
        self.refuses("network 'huge'|huge", powderkeg.load_weights, "untrained:huge")
        whole = (self.folder / "small.weights").read_bytes()
        bad = self.folder / "bad.weights"
        for data in (b"", whole[:100], whole[:-1], whole + b"x", b"x" + whole[1:]):
            bad.write_bytes(data)
            self.refuses("bad.weights: ", powderkeg.load_weights, bad)

    def test_bad_arrays(self):
        def save(**changes):
            powderkeg.save_weights(dataclasses.replace(self.weights, **changes), self.folder / "x")

        arrays = self.weights.arrays
        name = "stem.conv.weight"
        for change, reason in ((np.zeros((2, 2), np.float32), "has shape"),
                               (arrays[name] * np.float32("nan"), "expected a finite number"),
                               (arrays[name].astype(int), "no array of floats"),
                               ("text", "no array of floats"), (None, "no array of floats")):
            self.refuses(f"{name}.*{reason}", save, arrays=arrays | {name: change})
        self.refuses("arrays has .* entries", save, arrays=arrays | {"more": np.zeros(1)})
        self.refuses(f"arrays has no '{name}'", save,
                     arrays={key: value for key, value in arrays.items() if key != name})
        self.refuses("version is -1", save, version=-1)
        description = self.weights.description
        self.refuses("description has no 'blocks'", save,
                     description={key: description[key] for key in description if key != "blocks"})
        self.refuses("stem_channels is 'many', expected int", save,
                     description=description | {"stem_channels": "many"})
        self.refuses("kind is 'new'", save, description=description | {
            "blocks": [{"kind": "new", "expanded": 1, "channels": 1, "stride": 1}]})
        self.refuses("", save, description=description | {"stem_channels": -1})
        self.refuses("description is of type list, expected dict", save, description=[])
        self.refuses("arrays is of type NoneType, expected dict", save, arrays=None)
        self.refuses("canary is None", save, canary=None)
        self.assertFalse((self.folder / "x").exists())

    def test_bad_safetensors(self):
        path, bad = self.folder / "x.safetensors", self.folder / "bad.safetensors"
        powderkeg.save_safetensors(self.weights, path)
        header, values = header_of(path)
        metadata = header["__metadata__"]
        name = "stem.conv.weight"
        changes = [
            {"__metadata__": None}, {"__metadata__": {}}, {"__metadata__": {"format": "pt"}},
            {name: None}, {name: {"dtype": "I8"}},
            {name: header[name] | {"shape": [1]}}, {name: header[name] | {"shape": [-1, -1]}},
            {name: header[name] | {"data_offsets": [0, 10**15]}},
            {name: header[name] | {"data_offsets": [4, 0]}}, {"more": header[name]},
            {"__metadata__": metadata | {"powderkeg_version": "x"}},
            {"__metadata__": metadata | {"powderkeg_version": None}},
            {"__metadata__": metadata | {"powderkeg_description": "{"}},
            {"__metadata__": metadata | {"powderkeg_description": "[]"}},
            {"__metadata__": metadata | {"powderkeg_description": 7}},
            {"__metadata__": metadata | {"powderkeg_canary": "!"}},
            {"__metadata__": metadata | {"powderkeg_canary": "AAAA"}},
            {"__metadata__": metadata | {"powderkeg_canary": 7}},
        ]
        for change in changes:
            with self.subTest(change=str(change)[:100]):
                write_safetensors(bad, header | change, values)
                self.refuses("bad.safetensors: ", powderkeg.load_safetensors, bad)
        whole = path.read_bytes()
        a_list = b"\2" + b"\0" * 7 + b"[]"
        for data in (b"", b"1234567", b"\xff" * 40, whole[:60], whole[:-1], a_list):
            bad.write_bytes(data)
            self.refuses("bad.safetensors: ", powderkeg.load_safetensors, bad)

    def test_other_answers(self):
        canary = self.weights.canary
        other = canary.answered(canary.policy, canary.value * 0, canary.others)
        self.assertNotEqual(other, canary)
        self.assertFalse(other.value.any())
        self.assertTrue(np.array_equal(other.policy, canary.policy))
        self.refuses("policy has shape", canary.answered, np.zeros((2, 6)), canary.value)
        self.refuses("others has shape", canary.answered, canary.policy, canary.value, np.zeros(1))


@unittest.skipIf(torch is None, "PyTorch is not installed")
class NetworkTest(PowderkegTest):
    def setUp(self):
        super().setUp()
        write_data(self.folder)
        torch.set_num_threads(1)

    def test_it_answers_as_the_canary_says(self):
        from powderkeg.network import Network
        for name in ("small", "paper"):
            weights = powderkeg.load_weights(self.folder / f"{name}.weights")
            network = Network.load(self.folder / f"{name}.weights")
            policy, value = network.canary_difference(weights.canary)
            self.assertLess(policy, 1.01 / 255, name)
            self.assertLess(value, 1e-4, name)
            names = [key for key in network.state_dict() if not key.endswith("tracked")]
            self.assertEqual(set(names), set(weights.arrays))

    def test_trained_weights_go_back(self):
        from powderkeg.network import Network
        weights = powderkeg.load_weights(self.folder / "small.weights")
        network = Network.from_weights(weights)
        with torch.no_grad():
            network.value.fc2.bias += 0.5
        self.assertGreater(network.canary_difference(weights.canary)[1], 0.01)
        powderkeg.save_weights(network.to_weights(9, weights.canary), self.folder / "new.weights")
        back = powderkeg.load_weights(self.folder / "new.weights")
        self.assertEqual(back.version, 9)
        self.assertEqual(Network.from_weights(back).canary_difference(back.canary), (0.0, 0.0))

    def test_bad_descriptions(self):
        from powderkeg.network import Network
        description = powderkeg.load_weights("untrained:small").description
        self.refuses("", Network, description | {"stem_stride": 5})
        self.refuses("description has no 'planes'", Network, {})
