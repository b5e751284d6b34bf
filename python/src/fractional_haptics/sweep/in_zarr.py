"""Results in a Zarr group: an array for each variable, a chunk for each block. The default.

Why the default: the labelled arrays with units are in the store as they are in the result, `xarray.open_zarr` opens
them at any time, also while the sweep runs, and reads no more than is looked at.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from zarr.codecs import ZstdCodec

from .blocks import Blocks, Part
from .outputs import Outputs
from .results import ERROR_ABOUT, attributes_of, coordinates_of, error_texts, variables_of
from .work import Block

CHECKED = ZstdCodec(level=0, checksum=True)
"""Whoever reads a chunk is told of a flipped bit."""


class InZarr:
    """A Zarr group in a folder.

    Parameters
    ----------
    path : Path
    blocks : Blocks
    outputs : mapping
    fresh : bool
        Makes the arrays anew: nothing is done yet.
    """

    def __init__(self, path: Path, blocks: Blocks, outputs: Outputs, *, fresh: bool) -> None:
        self._path = path
        if fresh:
            _make(path, blocks, outputs)
        group = zarr.open_group(path, mode="r+")
        # A chunk of results is a file whatever it holds, so that one that is lost can be told.
        with zarr.config.set({"array.write_empty_chunks": True}):
            self._arrays = {name: _array(group, name) for name in outputs}
        self._errors = _array(group, "error")
        self._fresh = fresh

    def write(self, part: Part, block: Block) -> None:
        """Writes each chunk of the block; each of them is a file that appears by renaming."""
        for name, values in block.values.items():
            self._arrays[name][part.region] = values
        # A block that failed in an earlier run leaves texts, which go. An array of empty texts takes no file.
        if block.errors or not self._fresh:
            self._errors[part.region] = error_texts(part, block)

    def read(self, part: Part) -> Block:
        """The block as it is written. A chunk that is gone would be read as NaN."""
        for name, array in self._arrays.items():
            starts = part.start + (0,) * (array.ndim - len(part.start))
            places = [str(start // width) for start, width in zip(starts, array.chunks, strict=True)]
            self._path.joinpath(name, "c", *places).stat()
        texts = np.asarray(self._errors[part.region]).reshape(-1)
        values = {name: np.asarray(array[part.region]) for name, array in self._arrays.items()}
        return Block(part.number, values, {row: str(text) for row, text in enumerate(texts) if text}, 0.0)

    def dataset(self, attributes: Mapping[str, Any]) -> xr.Dataset:
        """Everything that is written so far, read when it is looked at."""
        return read(self._path).assign_attrs(attributes)


def chunks_of(path: Path, names: Iterable[str]) -> int:
    """Blocks of which every array has its chunk."""
    group = zarr.open_group(path, mode="r")
    return min(_array(group, name).nchunks_initialized for name in names)


def read(path: Path) -> xr.Dataset:
    """The group as a Dataset that reads when it is looked at."""
    found: xr.Dataset = xr.open_zarr(path, chunks=None)
    return found


def _make(path: Path, blocks: Blocks, outputs: Outputs) -> None:
    grid = blocks.grid
    group = zarr.open_group(path, mode="a", zarr_format=3)
    for name, dimension, coordinate in coordinates_of(grid, outputs):
        values = coordinate.values
        kind: Any = "str" if values.dtype.kind == "U" else values.dtype
        array = group.create_array(
            name,
            shape=values.shape,
            dtype=kind,
            dimension_names=[dimension],
            compressors=CHECKED,
            attributes=dict(attributes_of(coordinate)),
            overwrite=True,
        )
        array[:] = values.astype(object) if values.dtype.kind == "U" else values
    for name, dimensions, attributes in variables_of(grid, outputs):
        one = outputs[name]
        group.create_array(
            name,
            shape=grid.shape + one.shape,
            chunks=blocks.shape + one.shape,
            dtype=one.dtype,
            compressors=CHECKED,
            fill_value=np.dtype(one.dtype).type(one.missing),
            dimension_names=dimensions,
            attributes=dict(attributes),
            overwrite=True,
        )
    group.create_array(
        "error",
        shape=grid.shape,
        chunks=blocks.shape,
        dtype="str",
        compressors=CHECKED,
        fill_value="",
        dimension_names=list(grid.dimensions),
        attributes={"long_name": ERROR_ABOUT},
        overwrite=True,
    )
    beside = [name for name, dimension, _ in coordinates_of(grid, outputs) if name != dimension]
    if beside:
        group.attrs["coordinates"] = " ".join(beside)
    with warnings.catch_warnings():  # Zarr 3 has not yet agreed on it; xarray asks for it
        warnings.simplefilter("ignore")
        zarr.consolidate_metadata(path)


def _array(group: zarr.Group, name: str) -> zarr.Array[Any]:
    array = group[name]
    if not isinstance(array, zarr.Array):
        raise ValueError(f"{name!r} in the store is no array: name a new store")
    return array
