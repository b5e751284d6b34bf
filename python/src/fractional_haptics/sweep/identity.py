"""Identity of a function: enough of it to see that a store was made by another one.

What is looked at: its name and its source without comments, layout and docstrings (its compiled code where there is no
source); defaults, arguments bound by `functools.partial`, values of an enclosing function; and every global that it
names, as deep as it goes: functions, classes with their attributes and bases, objects of any kind by what they would be
pickled with, modules of the user's own by their source. What cannot be told is refused. What is not seen: what is
installed, as are Python, NumPy and this package (their version is the business of `version`), and files.
"""

from __future__ import annotations

import ast
import functools
import inspect
import sys
import sysconfig
import textwrap
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np


def identity(function: Callable[..., Any], version: str | None) -> dict[str, str]:
    """Names and digests that together identify a function.

    Parameters
    ----------
    function : callable
    version : str or None
        Any text of the user's: a change of it is a change of the function.

    Returns
    -------
    dict
        Digest or text by a name that a person understands.
    """
    facts = {"version": version or ""}
    _add(facts, "function", function, {})
    return facts


def _add(facts: dict[str, str], name: str, value: Any, seen: dict[int, Any]) -> None:
    value = _bare(value)
    if id(value) in seen:
        return
    seen[id(value)] = value  # kept, so that no other object gets its id
    if isinstance(value, functools.partial):
        _add(facts, name, value.func, seen)
        for place, argument in enumerate(value.args):
            facts[f"argument {place}"] = _digest(facts, argument, seen)
        for key, argument in value.keywords.items():
            facts[f"argument {key}"] = _digest(facts, argument, seen)
    elif inspect.ismethod(value):
        _add(facts, name, value.__func__, seen)
        facts[f"object of {name}"] = _digest(facts, value.__self__, seen)
    elif isinstance(value, FunctionType):
        _add_function(facts, name, value, seen)
    else:
        facts[name] = _digest(facts, value, seen)


def _bare(value: Any) -> Any:
    """What `functools.cache` and the like keep results of."""
    return value if isinstance(value, FunctionType | type) or not callable(value) else inspect.unwrap(value)


def _add_function(facts: dict[str, str], name: str, function: FunctionType, seen: dict[int, Any]) -> None:
    label = f"{function.__module__}.{function.__qualname__}"
    facts[name] = label
    if _is_installed(function.__module__):
        return
    facts[f"code of {label}"] = _code(function)
    values = inspect.getclosurevars(function)
    for key, default in _defaults(function).items():
        facts[f"default {key} of {label}"] = _digest(facts, default, seen)
    for key, value in sorted(values.nonlocals.items()):
        facts[f"{key} of {label}"] = _digest(facts, value, seen)
    for key, value in sorted({**values.globals, **_nested_globals(function)}.items()):
        about = f"{key} in {function.__module__}"
        if isinstance(value, FunctionType):
            _add(facts, about, value, seen)
        elif not isinstance(value, ModuleType) or not _is_installed(value.__name__):
            try:
                facts[about] = _digest(facts, value, seen)
            except ValueError as error:
                raise ValueError(f"{about}: {error}") from None


def _is_installed(module: str | None) -> bool:
    """True for what comes with Python, with this package or from an index."""
    root = (module or "").partition(".")[0]
    file = getattr(sys.modules.get(root), "__file__", None) or ""
    folders = (sysconfig.get_path(name) for name in ("purelib", "platlib"))
    return root in {*sys.stdlib_module_names, "fractional_haptics"} or any(
        Path(folder) in Path(file).parents for folder in folders
    )


def _defaults(function: FunctionType) -> dict[str, Any]:
    parameters = inspect.signature(function).parameters.values()
    return {one.name: one.default for one in parameters if one.default is not inspect.Parameter.empty}


def _nested_globals(function: FunctionType) -> dict[str, Any]:
    """Globals that functions and comprehensions inside a function name."""
    names: set[str] = set()
    codes = [function.__code__]
    while codes:
        code = codes.pop()
        names.update(code.co_names)
        codes.extend(one for one in code.co_consts if isinstance(one, CodeType))
    return {name: function.__globals__[name] for name in names if name in function.__globals__}


def _code(function: FunctionType) -> str:
    try:
        tree: ast.AST = ast.parse(textwrap.dedent(inspect.getsource(function.__code__)))
    except (OSError, TypeError, SyntaxError):
        return _hash(_compiled(function.__code__))
    if function.__name__ == "<lambda>":  # its source is the whole statement around it
        lambdas = [node for node in ast.walk(tree) if isinstance(node, ast.Lambda)]
        if len(lambdas) != 1:
            return _hash(_compiled(function.__code__))
        tree = lambdas[0]
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and isinstance(body[0], ast.Expr) and _is_text(body[0].value):
            body[0] = ast.Pass()
    return _hash(ast.unparse(tree))


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _compiled(code: CodeType) -> str:
    constants = [_compiled(one) if isinstance(one, CodeType) else repr(one) for one in code.co_consts]
    return repr((code.co_code, constants, code.co_names, code.co_varnames))


def _digest(facts: dict[str, str], value: Any, seen: dict[int, Any]) -> str:
    """A short text that changes with the value."""
    value = _bare(value)
    if isinstance(value, bool | int | float | complex | str | type(None)):
        text = repr(value)
        return text if len(text) <= 80 else _hash(text)
    if isinstance(value, np.ndarray) and value.dtype.kind != "O":
        return _hash(f"{value.dtype}{value.shape}", value.tobytes())
    if isinstance(value, np.generic):
        return repr(value)
    if isinstance(value, bytes):
        return _hash(value)
    if isinstance(value, tuple | list):
        return _hash(repr([_digest(facts, one, seen) for one in value]))
    if isinstance(value, set | frozenset):
        return _hash(repr(sorted(_digest(facts, one, seen) for one in value)))
    if isinstance(value, Mapping):
        return _hash(repr([(repr(key), _digest(facts, one, seen)) for key, one in value.items()]))
    if isinstance(value, FunctionType | functools.partial) or inspect.ismethod(value):
        _add(facts, f"function {getattr(value, '__qualname__', 'partial')}", value, seen)
        return getattr(value, "__qualname__", "partial")
    if isinstance(value, ModuleType):
        return _hash(Path(value.__file__ or "").read_bytes()) if getattr(value, "__file__", None) else value.__name__
    if isinstance(value, type):
        return _class(facts, value, seen)
    if inspect.isbuiltin(value):
        return f"{value.__module__}.{value.__name__}"
    return _object(facts, value, seen)


def _class(facts: dict[str, str], value: type, seen: dict[int, Any]) -> str:
    """Its name; its own methods and attributes, and those of its bases, become facts."""
    label = f"{value.__module__}.{value.__qualname__}"
    if id(value) in seen or _is_installed(value.__module__):
        return label
    seen[id(value)] = value
    for key, one in sorted(vars(value).items()):
        one = getattr(one, "__func__", getattr(one, "fget", one))
        if isinstance(one, FunctionType) or not key.startswith(("__", "_abc_")):
            facts[f"{key} of {label}"] = _digest(facts, one, seen)
    facts[f"bases of {label}"] = " ".join(_class(facts, base, seen) for base in value.__bases__)
    return label


def _object(facts: dict[str, str], value: Any, seen: dict[int, Any]) -> str:
    """Digest of any other object: its class and what it would be pickled with, which holds no addresses."""
    kind = _class(facts, type(value), seen)
    if id(value) in seen:
        return kind
    seen[id(value)] = value  # kept, so that no other object gets its id
    try:
        reduced = value.__reduce_ex__(4)
    except Exception:
        raise ValueError(
            f"a {kind} cannot be compared with the one that a store was made with: open it inside the function"
        ) from None
    if isinstance(reduced, str):  # one of its module, which has no state
        return f"{kind} {reduced}"
    # Behind arguments and state: what a list or mapping of another kind holds.
    state = [one if place < 3 else list(one or ()) for place, one in enumerate(reduced[:5])]
    return _hash(kind, repr([_digest(facts, one, seen) for one in state[1:]]))


def _hash(*pieces: str | bytes) -> str:
    digest = sha256()
    for piece in pieces:
        digest.update(piece.encode() if isinstance(piece, str) else piece)
    return digest.hexdigest()[:16]
