"""Identity of a function: changes that matter are seen, others are not."""

import functools
import importlib.util
import threading

import numpy as np
import pytest

from fractional_haptics.sweep.identity import identity

BASE = '''
import numpy as np

MASS = 0.065
TABLE = np.array([1.0, 2.0])

def helper(x):
    return x * MASS

def function(x, gain=2.0):
    """Doubles."""
    # a comment
    return sum(helper(one) for one in (x, gain)) + TABLE[0]

def unused():
    return 1
'''


def of(tmp_path, source, name="function"):
    """Identity of a function of a module with that source."""
    path = tmp_path / f"module_{abs(hash(source))}.py"
    path.write_text(source)
    spec = importlib.util.spec_from_file_location("module", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return identity(getattr(module, name), None)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Doubles.", "Takes twice."),
        ("    # a comment\n", ""),
        ("gain=2.0", "gain = 2.0"),
        ("return 1", "return 2"),
        ("def unused", "def still_unused"),
    ],
)
def test_words_layout_and_what_is_not_used_do_not_count(tmp_path, old, new):
    assert old in BASE
    assert of(tmp_path, BASE.replace(old, new)) == of(tmp_path, BASE)


@pytest.mark.parametrize(
    ("old", "new", "names"),
    [
        ("+ TABLE[0]", "- TABLE[0]", "code of module.function"),
        ("gain=2.0", "gain=2.5", "default gain of module.function"),
        ("MASS = 0.065", "MASS = 0.066", "MASS in module"),
        ("[1.0, 2.0]", "[1.5, 2.0]", "TABLE in module"),
        ("x * MASS", "x / MASS", "code of module.helper"),
    ],
)
def test_code_values_and_helpers_of_the_module_count(tmp_path, old, new, names):
    before, after = of(tmp_path, BASE), of(tmp_path, BASE.replace(old, new))
    assert before.keys() == after.keys()
    assert names in {key for key in before if before[key] != after[key]}


def test_bound_arguments_and_closures_count():
    def function(x, gain, table=None):
        return x * gain

    facts = identity(functools.partial(function, gain=2.0), None)
    assert facts["argument gain"] == "2.0"
    assert identity(functools.partial(function, gain=3.0), None)["argument gain"] == "3.0"
    tables = [identity(functools.partial(function, table={"a": np.arange(n)}), None) for n in (3, 3, 4)]
    assert tables[0] == tables[1] != tables[2]


def test_objects_count_by_their_contents():
    class Device:
        def __init__(self, mass):
            self.mass = mass
            self.itself = self

        def largest(self, x):
            return x / self.mass

    assert identity(Device(1.0).largest, None) == identity(Device(1.0).largest, None)
    assert identity(Device(1.0).largest, None) != identity(Device(2.0).largest, None)
    assert identity(Device(1.0).largest, "1") != identity(Device(1.0).largest, "2")


def test_recursion_ends():
    def down(x):
        return x if x < 1 else down(x - 1)

    assert identity(down, None) == identity(down, None)


def test_the_place_of_a_lambda_does_not_count():
    first = lambda x: x + 1  # noqa: E731
    second = identity(lambda x: x + 1, None)
    assert list(identity(first, None).values()) == list(second.values())


def test_code_without_source_counts():
    namespaces = [{}, {}, {}]
    for namespace, constant in zip(namespaces, (1, 1, 2), strict=True):
        exec(f"def function(x): return [x + {constant} for _ in range(2)]", namespace)
    one, same, other = (identity(namespace["function"], None) for namespace in namespaces)
    assert one == same != other


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(ValueError, match=r"a _thread.lock cannot be compared.*open it inside the function"):
        identity(functools.partial(lambda x, lock: x, lock=threading.Lock()), None)


REACHES = '''
import collections, dataclasses, functools, threading
from fractional_haptics import analysis

DEVICE = analysis.Device(0.065, 3.5)
SETTINGS = {"gain": 1.0}
GAINS = [1.0, 2.0]
QUEUE = collections.deque([1.0])

@dataclasses.dataclass
class Hand:
    stiffness: float = 300.0

HAND = Hand(200.0)

class Law:
    GAIN = 3.0
    def force(self, x):
        return self.GAIN * x

class Softer(Law):
    pass

SOFT = Softer()

def scaled(gain, x):
    return gain * x

TWICE = functools.partial(scaled, 2.0)

@functools.lru_cache
def looked_up(x):
    return 5.0 * x

def function(x):
    return (DEVICE.mass_kg, SETTINGS, GAINS, QUEUE, HAND, Hand().stiffness, SOFT.force(x), TWICE(x), looked_up(x))
'''


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("0.065", "0.1"),
        ('"gain": 1.0', '"gain": 1.5'),
        ("[1.0, 2.0]", "[1.0, 2.5]"),
        ("deque([1.0])", "deque([1.5])"),
        ("Hand(200.0)", "Hand(250.0)"),
        ("stiffness: float = 300.0", "stiffness: float = 350.0"),
        ("GAIN = 3.0", "GAIN = 3.5"),
        ("self.GAIN * x", "self.GAIN * x * x"),
        ("partial(scaled, 2.0)", "partial(scaled, 2.5)"),
        ("return gain * x", "return gain + x"),
        ("5.0 * x", "5.5 * x"),
    ],
)
def test_whatever_the_function_reaches_in_its_module_counts(tmp_path, old, new):
    assert old in REACHES
    assert of(tmp_path, REACHES) == of(tmp_path, REACHES)
    assert of(tmp_path, REACHES.replace(old, new)) != of(tmp_path, REACHES)


def test_a_module_beside_the_script_counts_and_an_installed_one_does_not(tmp_path, monkeypatch):
    source = "import numpy as np\nimport beside_it\nfrom beside_it import law\ndef function(x): return law(x) + beside_it.K\n"
    seen = []
    for name, text in [("a", "K = 1.0\ndef law(x): return x\n"), ("b", "K = 1.5\ndef law(x): return x\n")]:
        (tmp_path / name).mkdir()
        (tmp_path / name / "beside_it.py").write_text(text)
        monkeypatch.setattr("sys.path", [str(tmp_path / name), *__import__("sys").path])
        __import__("sys").modules.pop("beside_it", None)
        seen.append(of(tmp_path, source))
    assert seen[0] != seen[1]
    assert not any("numpy" in key for key in seen[0])


def test_a_global_that_cannot_be_compared_is_refused_by_its_name(tmp_path):
    source = "import threading\nLOCK = threading.Lock()\ndef function(x):\n    with LOCK:\n        return x\n"
    with pytest.raises(ValueError, match=r"LOCK.*_thread.lock cannot be compared"):
        of(tmp_path, source)
