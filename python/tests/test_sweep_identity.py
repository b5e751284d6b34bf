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
