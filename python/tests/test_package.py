"""The package as a whole: import, documentation, stubs."""

import doctest
import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import fractional_haptics
from fractional_haptics import _native, control, experiment, tissue

QUESTIONS = [name for name in experiment.__all__ if name.startswith("analyze_")] + ["design", "zwidth"]
MODULES = ("analysis", "bridge", "control", "experiment", "log", "operators", "plot", "tissue")


def test_a_stream_of_single_samples_needs_no_numpy() -> None:
    code = "import sys; from fractional_haptics.operators import Operator; Operator(0.5, 1e-3).step(1.0); print('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.strip() == "False"


def test_an_import_loads_nothing_that_is_not_needed() -> None:
    code = (
        "import sys, fractional_haptics.operators, fractional_haptics.analysis, fractional_haptics.log;"
        "heavy = {'pandas', 'matplotlib', 'control', 'scipy'} & set(sys.modules);"
        "sys.exit(str(heavy) if heavy else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_version_is_that_of_the_package() -> None:
    from importlib.metadata import PackageNotFoundError, version

    try:
        assert version("fractional-haptics") == fractional_haptics.__version__
    except PackageNotFoundError:
        pytest.skip("run from the source tree")


@pytest.mark.parametrize(
    ("question", "function"),
    [
        ("identify", tissue.identify_tables),
        ("control identify", control.identify),
        ("control design", control.design),
        ("control analyze", control.analyze),
        ("control simulate", control.simulate),
        *((name.replace("analyze_", "analyze ").replace("_", "-"), getattr(experiment, name)) for name in QUESTIONS),
    ],
)
def test_every_key_of_a_question_is_an_argument(question: str, function) -> None:
    page = (Path(__file__).parents[2] / "docs/guide/src/experiment-keys.md").read_text()
    for name, group in reversed(re.findall(r"\n(\*.+?\*): (.+)", page)):
        page = page.replace(name, group)

    def keys(text: str) -> list[str]:
        return re.findall(r"`([a-z][a-z0-9_]*)`", text)

    table = page.split("\n## Questions\n")[1].split(f"\n### {question}\n")[1].split("\n### ")[0]
    rows, _, elsewhere = table.partition("\nAlso ")
    named = [row.split("|")[0] for row in rows.splitlines() if row.startswith("`")]
    in_python = {}
    for row in re.findall(r"\n(`.+?` \| same \| same \| `.+?`)(?=\n)", page):
        key, name = keys(row)
        in_python[key] = name
    assert len(in_python) == 5
    names = [in_python.get(key, key) for key in keys(" ".join(named) + elsewhere)]
    assert len(names) > 5
    assert set(names) <= set(inspect.signature(function).parameters)


def test_a_name_that_is_none_says_so() -> None:
    with pytest.raises(AttributeError, match="tissues"):
        fractional_haptics.tissues  # noqa: B018
    assert "operators" in dir(fractional_haptics)


def test_the_modules_of_the_package_are_known_to_type_checkers_and_editors() -> None:
    import jedi
    from mypy import api

    begin = "import fractional_haptics as fh\n"
    lines = (
        "x: float = fh.operators.Operator(0.5, 1e-3).step(1.0)",
        "fh.sweep.Grid(x=[1.0])",
        # An ignored mistake that is none would be told.
        "fh.operators.Nothing  # type: ignore[attr-defined]",
    )
    said, _errors, code = api.run(["--strict", "--config-file=", "-c", begin + "\n".join(lines)])
    assert code == 0, said
    for module in (*MODULES, "sweep"):
        script = jedi.Script(begin + f"fh.{module}.")
        public = importlib.import_module(f"fractional_haptics.{module}").__all__
        assert set(public) <= {one.name for one in script.complete(2, len(f"fh.{module}."))}, module


@pytest.mark.parametrize("name", MODULES)
def test_examples_in_the_documentation_are_right(name: str) -> None:
    module = importlib.import_module(f"fractional_haptics.{name}")
    finder = doctest.DocTestFinder()
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    public = [getattr(module, one) for one in module.__all__]
    for thing in public:
        if callable(thing):
            for test in finder.find(thing, module=False, globs=dict(vars(module))):
                runner.run(test)
    assert runner.summarize().failed == 0


@pytest.mark.parametrize("name", MODULES)
def test_everything_public_is_documented(name: str) -> None:
    module = importlib.import_module(f"fractional_haptics.{name}")
    missing = []
    for one in module.__all__:
        thing = getattr(module, one)
        if callable(thing) and not (thing.__doc__ or "").strip():
            missing.append(one)
        if inspect.isclass(thing):
            for key, value in vars(thing).items():
                public = not key.startswith("_") and (callable(value) or inspect.isgetsetdescriptor(value))
                if public and not (value.__doc__ or "").strip():
                    missing.append(f"{one}.{key}")
    assert missing == []


def test_the_stubs_name_what_there_is() -> None:
    import ast
    from pathlib import Path

    stub = Path(fractional_haptics.__file__).with_name("_native.pyi")
    named = set()
    for node in ast.parse(stub.read_text()).body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            named.add(node.name)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            named.add(node.target.id)
    there = {one for one in dir(_native) if not one.startswith("__")} | {"__version__"}
    assert named == there


@pytest.mark.skipif(sys.platform != "linux", reason="symbols of a shared object of Linux are read")
def test_no_number_comes_from_the_mathematics_of_the_platform() -> None:
    listed = subprocess.run(["nm", "-D", "--undefined-only", _native.__file__], check=True, capture_output=True, text=True).stdout
    names = {line.split()[-1].split("@")[0] for line in listed.splitlines()}
    mathematics = (
        "acos acosh asin asinh atan atan2 atanh cbrt cos cosh erf exp exp10 exp2 expm1 hypot lgamma log log10 log1p log2 pow "
        "sin sincos sinh tan tanh tgamma"
    ).split()
    assert len(names) > 20
    assert not names & {name + end for name in mathematics for end in ("", "f")}
