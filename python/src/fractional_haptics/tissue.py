"""Viscoelastic tissue: models, the library, and models from records. The crates ``haptic-tissue`` and ``tissue-identification``.

Names of parameters carry their units: ``_pa``, ``_pa_s_alpha`` (Pa·s^α), ``_s``.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fractional_haptics import _native
from fractional_haptics._native import Material, Model
from fractional_haptics._series import Series
from fractional_haptics._values import HoldsArrays, Shown

if TYPE_CHECKING:
    import os
    from types import ModuleType

    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike
    from typing import TypeAlias

    from fractional_haptics._values import AnyPath, Floats

    _Fix: TypeAlias = Mapping[str, float | tuple[float, float]] | None
    _Loading: TypeAlias = Literal["shear", "tension", "compression", "punch", "sphere", "cone"] | None
    _Contact: TypeAlias = float | Literal["fit"] | None
    _Baseline: TypeAlias = Literal["constant", "linear"] | None
    _Weights: TypeAlias = Literal["errors", "equal", "log-spacing"]

__all__ = [
    "MODELS",
    "Estimate",
    "Fit",
    "Identification",
    "Material",
    "Model",
    "ModelDescription",
    "Parameter",
    "explain_table",
    "find",
    "identify",
    "identify_tables",
    "library",
]


@dataclass(frozen=True)
class Parameter(Shown):
    """A parameter of a model."""

    name: str
    """Its keyword in `Model`."""
    unit: str
    """Its unit; empty for a pure number."""
    allowed: str
    """The numbers that it may be, in words."""
    help: str
    """A few words."""
    is_list: bool
    """True where there is one for each branch of a Prony series."""


@dataclass(frozen=True)
class ModelDescription(Shown):
    """A kind of model."""

    description: str
    """A few words."""
    parameters: tuple[Parameter, ...]
    """Its parameters."""


MODELS: Mapping[str, ModelDescription] = MappingProxyType(
    {
        name: ModelDescription(description, tuple(Parameter(*parameter) for parameter in parameters))
        for name, description, parameters in _native.model_table()
    }
)
"""All models by name, simple ones first."""


def library(folder: AnyPath | None = None) -> dict[str, Material]:
    """The tissues that are known by name.

    Parameters
    ----------
    folder : path, optional
        A folder whose tissue files (``*.toml``) are added. A file that is no tissue is skipped with a warning.

    Returns
    -------
    dict of str to Material
        Those that come with the package first.

    Raises
    ------
    FileNotFoundError
        No such folder.
    ValueError
        A name that is there twice.

    Examples
    --------
    >>> library()["fish-muscle"].model.kind
    'fractional-maxwell'
    """
    return {material.name: material for material in _native.library(folder)}


def find(name: AnyPath, folder: AnyPath | None = None) -> Material:
    """A tissue by name, or from a file where `name` ends in ``.toml``.

    Parameters
    ----------
    name : str or path
        A name of `library`, or a path.
    folder : path, optional
        As in `library`.

    Returns
    -------
    Material

    Raises
    ------
    FileNotFoundError
        No such file or folder.
    ValueError
        None of that name (all that are known are named), or a file that is wrong.
    """
    import os

    return _native.find_material(os.fspath(name), folder)


@dataclass(frozen=True)
class Estimate(Shown):
    """A parameter of a fit with its errors; None where the record does not settle it."""

    name: str
    """As in `Model`."""
    unit: str
    """Empty for an order."""
    value: float
    """At the best fit."""
    standard_error: float | None
    """By the curvature of the sum of squares."""
    low_95: float | None
    """Low end of the 95 % interval; None for a modulus that the record does not bound."""
    high_95: float | None
    """High end, likewise."""
    held: bool
    """It is at the end of a range that was given, or has one value."""


@dataclass(frozen=True, eq=False, repr=False)
class Fit(HoldsArrays, Shown):
    """A model fitted to a record."""

    kind: str
    """Name of the model."""
    model: Model | None
    """The model; None if the fit has come down to a simpler one."""
    estimates: tuple[Estimate, ...]
    """Its parameters."""
    correlation: list[list[float]]
    """Correlations of the estimates, of the logarithm where it is a modulus; empty if the record does not settle them."""
    rms: float
    """Root of the mean square of the residuals: of the logarithm, or Pa for ``kind="record"``."""
    aic: float
    """Akaike's criterion."""
    bic: float
    """Schwarz's criterion: the lower, the better."""
    predicted: Floats
    """The model where the record has a value, as `Identification.measured`."""
    is_settled: bool
    """False if a standard error is many times its value."""

    def _shown(self) -> dict[str, Any]:
        rows = ("name", "value", "unit", "low_95", "high_95")
        estimates = [{row: getattr(one, row) for row in rows} for one in self.estimates]
        return {
            "model": self.kind,
            "estimates": estimates,
            "rms": self.rms,
            "bic": self.bic,
            "is_settled": self.is_settled,
        }


_COLUMNS = {
    "relaxation": ("time_s", "modulus_pa"),
    "creep": ("time_s", "compliance_per_pa"),
    "oscillation": ("angular_frequency_rad_s", "moduli_pa"),
    "record": ("time_s", "stress_pa"),
}
"""What is in each kind of record, as keys of a report."""


@dataclass(frozen=True, eq=False, repr=False)
class Identification(HoldsArrays, Shown, Series):
    """Models fitted to a record, the best first."""

    kind: str
    """Kind of the record."""
    fits: tuple[Fit, ...]
    """Fits that converged, the chosen one first, the others by BIC."""
    x: Floats
    """Times in s, or angular frequencies in rad/s; of an oscillation all are there twice."""
    measured: Floats
    """Moduli, compliances, all storage and then all loss moduli, or stresses: of an indenter its force over γℓ, Pa."""
    warnings: tuple[str, ...]
    """Sentences that one should read."""
    notes: tuple[str, ...] = ()
    """Of tables: what was guessed, converted or left out."""
    beside: tuple[Estimate, ...] = ()
    """Numbers that were found beside the models, where they were asked for: contact point, offset and drift."""
    several: dict[str, Any] = field(default_factory=dict)
    """Of specimens their spread; of temperatures the shifts, their overlaps and laws: as the command's JSON has them."""

    @property
    def best(self) -> Fit:
        """The fit that was chosen."""
        return self.fits[0]

    def _series(self) -> Mapping[str, Floats]:
        along, key = _COLUMNS[self.kind]
        found = {key: self.measured} | {f"{fit.kind.replace('-', '_')}_{key}": fit.predicted for fit in self.fits}
        if self.kind != "oscillation":
            return {along: self.x, **found}
        halves = {name.replace("moduli", f"{part}_modulus"): half for name, values in found.items()
                  for part, half in zip(("storage", "loss"), np.split(values, 2), strict=True)}
        return {along: self.x[: len(self.x) // 2], **halves}

    def _drawn(self, plot: ModuleType, ax: Axes | None) -> Axes:
        return plot.identification(self, ax)  # type: ignore[no-any-return]

    def _shown(self) -> dict[str, Any]:
        candidates = [{"model": fit.kind, "rms": fit.rms, "bic": fit.bic, "settled": fit.is_settled} for fit in self.fits]
        record = {"record": self.kind, **dict(zip(_COLUMNS[self.kind], (self.x, self.measured), strict=True))}
        return {**record, **self.best._shown(), "candidates": candidates, "warnings": list(self.warnings)}


def identify(
    t: ArrayLike,
    y: ArrayLike,
    kind: Literal["relaxation", "creep", "oscillation", "record"] = "relaxation",
    *,
    strain: ArrayLike | None = None,
    depth: ArrayLike | None = None,
    loading: _Loading = None,
    area_m2: float | None = None,
    thickness_m: float | None = None,
    indenter_radius_m: float | None = None,
    half_angle_rad: float | None = None,
    bonded: bool = False,
    poisson_ratio: float = 0.5,
    models: Sequence[str] | None = None,
    chosen: str | None = None,
    weights: _Weights = "errors",
    starts: int = 40,
    bootstrap: int = 0,
    seed: int = 1,
    stiffening: bool = False,
    contact_point: _Contact = None,
    baseline: _Baseline = None,
    ramp_time_s: float | None = None,
    fix: _Fix = None,
    progress: Callable[[int], object] | None = None,
) -> Identification:
    """Models from a measured record, or from several motions of one tissue together.

    Parameters
    ----------
    t : array_like, shape (n,)
        Times in s; for an oscillation angular frequencies in rad/s. For several motions a sequence with those of each; then
        ``y`` with ``strain`` or ``depth`` are such sequences too.
    y : array_like, shape (n,)
        ``relaxation``: modulus after a step of strain in Pa. ``creep``: compliance after a step of stress in 1/Pa.
        ``oscillation``: complex modulus in Pa. ``record``: stress in Pa of any motion from rest, or force in N with ``depth``.
    kind : str
        Kind of the record.
    strain : array_like, shape (n,), optional
        Strain at the times of a ``record``.
    depth : array_like, shape (n,), optional
        Depth in m at the times of a ``record`` of force; below 0 there is no contact. The model found is of the shear modulus
        for ``loading="shear"``, else of Young's.
    loading : str, optional
        How the specimen of ``depth`` is pressed.
    area_m2, thickness_m : float, optional
        Of a slab; the thickness of a bonded layer under a sphere.
    indenter_radius_m : float, optional
        Of a punch or sphere.
    half_angle_rad : float, optional
        Of a cone, between axis and flank.
    bonded : bool, default False
        The slab cannot slide on its plates, or the layer under a sphere cannot slide on its base.
    poisson_ratio : float, default 0.5
        Of the specimen of ``depth``.
    models : sequence of str, optional
        Candidates; without them all five fractional ones.
    chosen : str, optional
        The one to put first; without it that with the least BIC, or one with fewer parameters that is as good.
    weights : {"errors", "equal", "log-spacing"}
        Weights of the samples: by the errors in a column of a table, else alike; alike; or as much as each covers of ln t.
    starts : int, default 40
        Starts of the search for each model.
    bootstrap : int, default 0
        Records drawn for the intervals, at least 40; 0 takes profiles of the likelihood.
    seed : int, default 1
        Seed of the bootstrap: same seed, same numbers.
    stiffening : bool, default False
        Of a ``record``: find b of tissue that stiffens too, the last estimate of the best fit, 0 to 100.
    contact_point : float or "fit", optional
        Of ``depth``: where an indenter touches, m; ``"fit"`` finds it. Without it 0.
    baseline : {"constant", "linear"}, optional
        Of a ``record``: find the part of the force that is not the tissue's too.
    ramp_time_s : float, optional
        Of a ``relaxation`` that begins with the ramp to its strain, at the time 0.
    fix : mapping, optional
        Parameters, by their names in `Model`, that are held at a value, or between two; models without them are left out.
    progress : callable, optional
        Called with the number of records of the bootstrap that are done.

    Returns
    -------
    Identification

    Raises
    ------
    ValueError
        Columns of different length, a sample that is wrong (with its index and the remedy), no model that fits.

    Notes
    -----
    Least squares by Levenberg-Marquardt from many starts: in the logarithm for relaxation, creep and oscillation, in the
    stress for any motion. Releases the interpreter; uses all cores. 40 starts of four parameters on 566 samples: 0.3 s.

    References
    ----------
    J. J. Moré, *The Levenberg-Marquardt algorithm: implementation and theory*, 1978.

    Examples
    --------
    >>> import numpy as np
    >>> gel = Model("spring-pot", viscosity_pa_s_alpha=5000.0, order=0.2)
    >>> t = np.geomspace(0.01, 100.0, 60)
    >>> best = identify(t, gel.relaxation_modulus(t)).best
    >>> best.kind, round(best.model.parameters["order"], 6)
    ('spring-pot', 0.2)
    """
    asked = locals()
    if contact_point is not None and depth is None:
        raise ValueError("contact_point belongs to depth: give both, or neither")
    if (depth is None) != (loading is None):
        raise ValueError("depth and loading belong together: give both, or neither")
    apart = ("t", "y", "strain", "depth", "models", "chosen", "progress")
    given = _fit_options({key: value for key, value in asked.items() if key not in apart}) | {"model": chosen}
    records = _motions(t, y, strain, depth)
    found = _native.identify_record(records, None if models is None else list(models), given, progress)
    return _identification(found)


def _fit_options(given: dict[str, Any]) -> dict[str, Any]:
    """Options of a fit as the command takes them; of a bootstrap alone a seed says something."""

    def text(value: float | tuple[float, float]) -> str:
        return "..".join(map(str, value)) if isinstance(value, tuple) else str(value)

    if not given["bootstrap"]:
        del given["seed"]
    for name in ("starts", "bootstrap", "seed"):
        if not 0 <= operator.index(given.get(name, 0)) < 2**64:
            raise ValueError(f"{name} {given[name]} is not a whole number from 0 to 2**64 - 1")
    fixed: dict[str, Any] = given["fix"] or {}
    return given | {"fix": ",".join(f"{name}={text(value)}" for name, value in fixed.items()), "contact_point_m": given.pop("contact_point")}


def identify_tables(
    *tables: AnyPath,
    kind: Literal["relaxation", "creep", "oscillation", "record"] | None = None,
    model: str | None = None,
    columns: str = "",
    units: str = "",
    segment: str = "",
    from_: float | None = None,
    to: float | None = None,
    skip_bad_rows: bool = False,
    strain: float | None = None,
    stress_pa: float | None = None,
    loading: _Loading = None,
    area_m2: float | None = None,
    thickness_m: float | None = None,
    indenter_radius_m: float | None = None,
    half_angle_rad: float | None = None,
    bonded: bool = False,
    poisson_ratio: float | None = None,
    contact_point: _Contact = None,
    baseline: _Baseline = None,
    ramp_time_s: float | None = None,
    ramp_ends_s: float | None = None,
    subtract_start: bool = False,
    stiffening: bool = False,
    fix: _Fix = None,
    weights: _Weights = "errors",
    starts: int = 40,
    bootstrap: int = 0,
    seed: int = 1,
    replicates: bool = False,
    master_curve_c: float | None = None,
    shift_by: Literal["storage", "loss", "both"] | None = None,
    temperatures_c: Sequence[float] = (),
    progress: Callable[[int], object] | None = None,
) -> Identification:
    """Models from tables, read as ``host-cli identify`` reads them.

    Parameters
    ----------
    tables : path
        CSV, TSV or XLSX, as instruments write them; several are motions of one tissue, unless ``replicates`` or ``master_curve_c`` is
        given.
    kind, strain, stress_pa
        Kind of the record, and the value that is held where no column has it.
    model : str, optional
        The one to put first; without it the record chooses.
    columns, units, segment : str
        As in ``"time=1,modulus=3"``, ``"time=ms"``, ``"1,3"``.
    from_, to : float, optional
        First and last time, s, or angular frequency, rad/s.
    skip_bad_rows : bool
        Leave out rows that are no sample, a tenth of them at most; `Identification.notes` names them.
    loading, area_m2, thickness_m, indenter_radius_m, half_angle_rad, bonded, poisson_ratio
        As in `identify`.
    contact_point, baseline, ramp_time_s, stiffening, fix, weights, starts, bootstrap, seed, progress
        As in `identify`.
    ramp_ends_s : float, optional
        Time of the table's clock at which the ramp ends; without it the ramp begins at 0.
    subtract_start : bool
        Subtract the first row of strain and stress.
    replicates : bool
        The tables are of several specimens: each is fitted by itself, and the mean is taken.
    master_curve_c : float, optional
        The tables, or segments, are at several temperatures: shift them to this one, °C.
    shift_by : {"storage", "loss", "both"}, optional
        The modulus of sweeps that decides the shift.
    temperatures_c : sequence of float
        One for each table that has no column of it.

    Returns
    -------
    Identification

    Raises
    ------
    OSError
        A table that cannot be read.
    ValueError
        What the command refuses, with the name of the table.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> rows = [f"{t},{1000 * t**-0.2 * 0.8590}" for t in (0.1, 0.3, 1, 3, 10, 30)]
    >>> _ = (folder / "gel.csv").write_text("\\n".join(["Time (s),Modulus (Pa)", *rows]))
    >>> best = identify_tables(folder / "gel.csv", fix={"order": (0.1, 0.3)}).best
    >>> best.kind, round(best.model.parameters["order"], 6)
    ('spring-pot', 0.2)
    """
    asked = locals()
    import pathlib

    names = {"from_": "from_s", "to": "to_s", "master_curve_c": "master_curve"}
    given = _fit_options({names.get(key, key): value for key, value in asked.items() if key not in ("tables", "temperatures_c", "progress")})
    given["temperature"] = ",".join(map(str, temperatures_c))
    paths = [pathlib.Path(table) for table in tables]
    read = [(path.name, path.read_bytes()) for path in paths]
    options = {key: value for key, value in given.items() if value is not None}
    return _identification(_native.identify_tables(read, options, progress))


def explain_table(table: AnyPath, *, columns: str = "", units: str = "", segment: str = "") -> dict[str, Any]:
    """How `identify_tables` reads a table, as ``host-cli identify --explain`` tells.

    Parameters
    ----------
    table : path
        CSV, TSV or XLSX.
    columns, units, segment : str
        As in `identify_tables`.

    Returns
    -------
    dict
        ``columns``, each with what it is taken for, its first value in SI units and what else it could be; ``segments``; ``records``, or
        ``records_reason``; ``notes``.

    Raises
    ------
    OSError
        A table that cannot be read.
    ValueError
        A file without a row of numbers.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> gel = pathlib.Path(tempfile.mkdtemp()) / "gel.csv"
    >>> _ = gel.write_text("t (min),G (kPa)\\n0.1,1.2\\n1,0.8\\n10,0.5\\n")
    >>> [(one["taken_for"], one["first_value"]) for one in explain_table(gel)["columns"]]
    [('time', 6.0), ('modulus', 1200.0)]
    """
    import pathlib

    options = {"columns": columns, "units": units, "segment": segment}
    return _native.explain_table(pathlib.Path(table).read_bytes(), options)


def _identification(found: dict[str, Any]) -> Identification:
    fits = tuple(
        Fit(**{**fit, "estimates": tuple(Estimate(**estimate) for estimate in fit["estimates"])})
        for fit in found["fits"]
    )
    beside = tuple(Estimate(**estimate) for estimate in found["beside"])
    texts: dict[str, Any] = {key: tuple(found[key]) for key in ("warnings", "notes") if key in found}
    return Identification(**(found | texts | {"fits": fits, "beside": beside}))


def _motions(t: Any, *columns: Any) -> list[tuple[Any, ...]]:
    """The columns of each record: of the one, or of the several whose first one is an array itself."""
    several = np.iterable(t) and np.ndim(next(iter(t), 0.0)) > 0
    each = [None if column is None else list(column) if several else [column] for column in (t, *columns)]
    count = len(each[0] or [])
    if any(len(column) != count for column in each if column is not None):
        raise ValueError(f"t is of {count} records, and another column is not: give each column of each record")
    return list(zip(*(column or [None] * count for column in each), strict=True))
