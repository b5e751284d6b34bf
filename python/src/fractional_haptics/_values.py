"""Values: equal if what makes them is, and shown on one screen, in text and in a notebook.

One mechanism for all classes of the package. A value is a report: its keys are the names of its fields, which carry their
units; `_native.lines` makes rows of them, as of the reports of the command, with four digits and a unit.
"""

# NumPy takes most of the time of an import, and a stream of single samples does without: its arrays are known by what they have.
from __future__ import annotations

import inspect
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from html import escape
from typing import TYPE_CHECKING, Any, cast

from fractional_haptics import _native

if TYPE_CHECKING:
    import os
    from typing import TypeAlias

    import numpy as np
    from numpy.typing import NDArray

    AnyPath: TypeAlias = str | os.PathLike[str]
    """A path, as Python's own functions take it."""
    Floats: TypeAlias = NDArray[np.float64]
    """An array of numbers."""
    Quantity: TypeAlias = float | str
    """A number in SI units, or a text with a unit."""

__all__ = ["AnyPath", "Floats", "HoldsArrays", "Quantity", "Shown", "needed", "same", "which"]

_SCREEN = 40
"""Lines of a summary at most."""
_WIDTH = 110
"""Letters of a line at most, beside its label."""
_TABLE = 140
"""Letters of a row of a table at most."""
_FIRST = ("name", "kind", "description")
"""What a value of the native module says first."""
_IN_SECONDS = {"sample_time": "sample_time_s", "horizon": "horizon_s"}


class Shown:
    """What shows itself on one screen."""

    __slots__ = ()

    def summary(self) -> str:
        """What it says, on one screen: numbers in four digits with their units.

        Returns
        -------
        str
        """
        return "\n".join(_text(_lines(self)))

    def _repr_html_(self) -> str:
        """The same for a notebook."""
        return _html(_lines(self))

    def __str__(self) -> str:
        return self.summary()


class HoldsArrays:
    """A dataclass some of whose fields are arrays, which Python cannot compare as one; it has no hash, as they have none."""

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(same(getattr(self, one.name), getattr(other, one.name)) for one in fields(self))  # type: ignore[arg-type]

    def __repr__(self) -> str:
        shown = (f"{one.name}={_short(getattr(self, one.name))}" for one in fields(self))  # type: ignore[arg-type]
        return f"{type(self).__name__}({', '.join(shown)})"


def _short(value: Any) -> str:
    """A value in a line: arrays and long lists by their size."""
    if hasattr(value, "shape") and hasattr(value, "dtype"):
        return f"<array {value.shape}>"
    text = repr(value)
    return text if len(text) <= 60 else f"<{type(value).__name__} of {len(value)}>" if hasattr(value, "__len__") else f"{text[:59]}…"


def same(a: Any, b: Any) -> bool:
    """Equality, of arrays by type, shape and numbers; NaN is equal to itself."""
    import numpy as np

    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        if not (isinstance(a, np.ndarray) and isinstance(b, np.ndarray)) or a.dtype != b.dtype:
            return False
        return np.array_equal(a, b, equal_nan=a.dtype.kind in "fc")
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple) and type(a) is type(b):
        return len(a) == len(b) and all(map(same, a, b))
    return bool(a == b or (a != a and b != b))


_WHICH = {
    "Operator": "an Operator is D^μ alone; analysis takes it by order and scheme, as Loop(plant, K, B, 0.5, 1e-3)",
    "Device": "a Device is what analysis.Loop and analysis.region take",
    "LinearPlant": "a LinearPlant is what analysis.Loop and analysis.region take",
    "Plant": "a control.Plant is what control.design and control.analyze take first",
    "TransferFunction": "a TransferFunction becomes what they take by control.plant",
    "Pid": "a Pid is a controller, which control.analyze takes second",
    "Model": "a Model is what a wall renders, not the device that feels it",
    "Material": "a Material is what a wall renders, not the device that feels it",
}


def which(value: object) -> str:
    """What a value of ours is for, to be said where another one is wanted."""
    known = _WHICH.get(type(value).__name__)
    return f" ({known})" if known and type(value).__module__.startswith("fractional_haptics") else ""


def needed(package: str, extra: str = "") -> Any:
    """A package that comes with an extra, of the same name unless another one is given."""
    from importlib import import_module

    try:
        return import_module(package)
    except ImportError as error:
        raise ImportError(f"{package} is missing: pip install 'fractional-haptics[{extra or package}]'") from error


def _made_of(value: Any) -> dict[str, Any]:
    """The arguments by which a value is made again; empty where it can change."""
    if not any("__reduce__" in vars(known) for known in type(value).__mro__[:-1]):
        return {}
    made_by, arguments, *_ = value.__reduce__()
    return dict(inspect.signature(made_by).bind(*arguments).arguments)


def _equal(one: object, other: object) -> bool:
    return type(other) is type(one) and one.__reduce__() == other.__reduce__()


def _hash(one: object) -> int:
    return hash(one.__reduce__())


def _repr(one: object) -> str:
    return f"{type(one).__name__}({', '.join(f'{key}={_short(value)}' for key, value in _made_of(one).items())})"


def _equip() -> None:
    """Gives the classes of the native module what they share: `Shown`, and equality by what makes them."""
    for name in dir(_native):
        known = getattr(_native, name)
        if not isinstance(known, type):
            continue
        own = vars(known)
        shared: dict[str, Any] = {key: vars(Shown)[key] for key in ("summary", "_repr_html_", "__str__")}
        if "__reduce__" in own:
            shared.update(__eq__=_equal, __hash__=_hash, __repr__=_repr)
        for key, function in shared.items():
            # Python gives every class with an equality of its own a hash of None.
            if own.get(key) is None:
                setattr(known, key, function)


def _rows(value: Any) -> Any:
    """A value as JSON has it: numbers, texts, lists, and objects by their keys."""
    if value is None or isinstance(value, bool | int | str):
        return None if value == "" else value
    if isinstance(value, float):
        return value if abs(value) < float("inf") else None
    if isinstance(value, Mapping):
        return _object(value)
    if hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        return _rows(value.item())
    if isinstance(value, complex) or hasattr(value, "__fspath__"):
        return str(value)
    if hasattr(value, "_shown"):
        return _object(value._shown())
    if is_dataclass(value):
        return _object({one.name: getattr(value, one.name) for one in fields(value)})
    if hasattr(value, "_asdict"):
        return _object(value._asdict())
    if isinstance(value, list | tuple):
        if value and all(isinstance(item, complex) for item in value):
            return f"{len(value)} values"
        return [_rows(item) for item in value]
    return _object(_native_rows(value))


def _native_rows(value: Any) -> dict[str, Any]:
    """What makes a value of the native module, and what it knows of itself."""
    rows = {} if isinstance(value, _native.Model | _native.Material) else _made_of(value)
    if cast("Any", type(value)).__str__ is not Shown.__str__:
        rows = {"notation": str(value)}
    known = [key for key, _ in inspect.getmembers_static(type(value), inspect.isgetsetdescriptor) if not key.startswith("_")]
    known.sort(key=lambda key: _FIRST.index(key) if key in _FIRST else len(_FIRST))
    rows.update({key: getattr(value, key) for key in known if key not in rows})
    return rows


def _object(mapping: Mapping[Any, Any]) -> dict[str, Any]:
    """The rows of an object: arrays by their ends, a value with its frequency as two keys."""
    rows: dict[str, Any] = {}
    for key, value in mapping.items():
        name = _IN_SECONDS.get(str(key), str(key))
        if hasattr(value, "dtype") and getattr(value, "ndim", 0) > 0:
            rows.update(_array(name, value))
        elif isinstance(value, list | tuple) and value and all(hasattr(item, "dtype") for item in value):
            rows[name] = f"{len(value)} of {sum(len(item) for item in value)} points"
        elif isinstance(value, float) and not abs(value) < float("inf"):
            rows[name], rows[f"{name}_reason"] = None, "no number" if value != value else "infinite"
        elif isinstance(value, Mapping) and all(item in (None, "") for item in value.values()):
            rows[name] = None
        elif getattr(value, "_fields", None) == ("value", "omega_rad_s"):
            rows[name], rows[f"{name}_rad_s"] = _rows(value.value), _rows(value.omega_rad_s)
        else:
            rows[name] = _rows(value)
    return rows


def _array(name: str, array: Any) -> dict[str, Any]:
    """The ends of an array, and the number of its values."""
    finite = array[array == array].ravel() if array.dtype.kind in "fiu" else array[:0]
    count = " by ".join(map(str, array.shape))
    if not len(finite):
        return {name: f"{count} values"}
    ends = {"least": _rows(float(finite.min())), "largest": _rows(float(finite.max()))}
    return {name: ends, f"{name}_reason": f"{count} values"}


def _lines(value: Any) -> list[dict[str, Any]]:
    return _native.lines(_rows(value))


def _text(lines: list[dict[str, Any]]) -> Iterator[str]:
    """Lines for a terminal, a screen of them."""
    said = list(_all(lines))
    yield from said[:_SCREEN]
    if len(said) > _SCREEN:
        yield f"… and {len(said) - _SCREEN} more lines"


def _all(lines: list[dict[str, Any]]) -> Iterator[str]:
    labels = [2 * line["level"] + len(line["label"]) for line in lines if line.get("value")]
    width = max(labels, default=0)
    for line in lines:
        label = "  " * line["level"] + line["label"]
        if "rows" in line:
            yield label
            columns = list(zip(line["columns"], *line["rows"], strict=True))
            widths = [max(map(len, column)) for column in columns]
            for row in (line["columns"], *line["rows"]):
                cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
                text = ("  " * (line["level"] + 1) + "  ".join(cells)).rstrip()
                yield text if len(text) <= _TABLE else f"{text[: _TABLE - 1]}…"
        else:
            reason = f"  ({line['reason']})" if line["reason"] else ""
            first, *others = line["value"].split("\n")
            said = [f"{first}{reason}", *others]
            cut = [one for text in said for one in textwrap.wrap(text, max(_WIDTH - width, 40)) or [""]]
            yield f"{label.ljust(width)}  {cut[0]}".rstrip()
            yield from (f"{' ' * width}  {other}" for other in cut[1:])


def _html(lines: list[dict[str, Any]]) -> str:
    """Lines as a table of HTML, a screen of them."""
    rows = []
    for line in lines[:_SCREEN]:
        label = f'<th style="text-align:left;white-space:nowrap;padding-left:{line["level"] + 0.5}em">{escape(line["label"])}</th>'
        if "rows" in line:
            heading = "".join(f"<th>{escape(column)}</th>" for column in line["columns"])
            body = "".join(
                f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in line["rows"][:_SCREEN]
            )
            rows.append(f"<tr>{label}<td><table><tr>{heading}</tr>{body}</table></td></tr>")
        else:
            reason = f" <small>({escape(line['reason'])})</small>" if line["reason"] else ""
            rows.append(f'<tr>{label}<td style="text-align:left">{escape(line["value"])}{reason}</td></tr>')
    if len(lines) > _SCREEN:
        rows.append(f'<tr><td colspan="2">… and {len(lines) - _SCREEN} more lines</td></tr>')
    return f"<table>{''.join(rows)}</table>"


_equip()
