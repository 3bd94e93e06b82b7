"""Where Gymnasium and PettingZoo are installed, their classes are used: shown by stand-ins."""

import os
import subprocess
import sys
import textwrap

from support import ROOT, PowderkegTest

GYMNASIUM = '''
    import numpy as np
    from . import spaces

    class Env:
        _np_random = None
        spec = None

        @property
        def np_random(self):
            return self._np_random

        def reset(self, *, seed=None, options=None):
            if seed is not None:
                self._np_random = np.random.default_rng(seed)
    '''
SPACES = '''
    class Space:
        def __init__(self, *arguments):
            self.arguments = arguments

    class Box(Space): pass
    class Dict(Space): pass
    class Discrete(Space): pass
    class MultiDiscrete(Space): pass
    '''
PETTINGZOO = '''
    class ParallelEnv:
        metadata = {}
        agents = []
        possible_agents = []
    '''
PROGRAM = '''
    import gymnasium, pettingzoo, powderkeg
    env = powderkeg.Env(observation="arrays")
    assert isinstance(env, gymnasium.Env) and env.unwrapped is env
    assert type(env.action_space) is gymnasium.spaces.Discrete
    assert type(env.observation_space) is gymnasium.spaces.Dict
    env.reset(seed=1)
    state = env.np_random.bit_generator.state
    env.reset(seed=1)
    assert env.np_random.bit_generator.state == state
    env.step(0)
    parallel = powderkeg.ParallelEnv("PommeRadio-v2")
    assert isinstance(parallel, pettingzoo.ParallelEnv)
    parallel.reset(seed=1)
    assert parallel.num_agents == 4 and parallel.metadata["name"] == "pommerman"
    parallel.step(dict.fromkeys(parallel.agents, [0, 1, 2]))
    '''


class BaseClassesTest(PowderkegTest):
    def test_stand_ins(self):
        files = {"gymnasium/__init__.py": GYMNASIUM, "gymnasium/spaces.py": SPACES,
                 "pettingzoo/__init__.py": PETTINGZOO}
        for name, text in files.items():
            path = self.folder / name
            path.parent.mkdir(exist_ok=True)
            path.write_text(textwrap.dedent(text))
        paths = os.pathsep.join([str(self.folder), str(ROOT / "python")])
        result = subprocess.run([sys.executable, "-B", "-c", textwrap.dedent(PROGRAM)],
                                env=os.environ | {"PYTHONPATH": paths}, capture_output=True,
                                text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
