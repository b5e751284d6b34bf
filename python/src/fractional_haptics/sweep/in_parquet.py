"""Results in Parquet: a file for each block, a row for each point, a column for each coordinate and variable.

For those who go on in a database or in R. The result is put together in memory when it is asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import xarray as xr

from .blocks import Blocks, Part
from .folder import read_journal
from .outputs import Outputs
from .results import InMemory, error_texts
from .work import Block


class InParquet:
    """Files ``part-NUMBER.parquet`` in a folder.

    Parameters
    ----------
    path : Path
    blocks : Blocks
    outputs : mapping
        None of them complex, which Parquet does not know.
    """

    def __init__(self, path: Path, blocks: Blocks, outputs: Outputs) -> None:
        if complex_ones := [name for name, one in outputs.items() if one.dtype == "complex128"]:
            raise ValueError(f"{complex_ones[0]!r} is complex, which Parquet has no type for: use Zarr")
        self._path, self._blocks, self._outputs = path, blocks, outputs

    def write(self, part: Part, block: Block) -> None:
        """Writes the file of the block, which appears by renaming."""
        columns: dict[str, Any] = {}
        places = np.indices(part.shape).reshape(len(part.shape), -1)
        for name, (dimension, values) in part.coordinates.items():
            columns[name] = np.asarray(values)[places[dimension]]
        for name, values in block.values.items():
            one = self._outputs[name]
            flat = pa.array(values.reshape(-1))
            for length in reversed(one.shape):
                flat = pa.FixedSizeListArray.from_arrays(flat, length)
            columns[name] = flat
        columns["error"] = pa.array(error_texts(part, block).reshape(-1).tolist(), pa.string())
        temporary = self._path / f"_part-{part.number:08}.new"
        pq.write_table(pa.table(columns).replace_schema_metadata(self._units()), temporary, compression="zstd")
        temporary.replace(_file(self._path, part.number))

    def dataset(self, attributes: Mapping[str, Any]) -> xr.Dataset:
        """Everything that is written so far."""
        whole = InMemory(self._blocks.grid, self._outputs)
        for number in filter(range(len(self._blocks)).__contains__, read_journal(self._path)):
            part = self._blocks.part(number)
            whole.write(part, self.read(part))
        return whole.dataset(attributes)

    def read(self, part: Part) -> Block:
        """The block as it is written."""
        table = pq.read_table(_file(self._path, part.number))
        values = {}
        for name, one in self._outputs.items():
            flat = table[name].combine_chunks()
            for _ in one.shape:
                flat = flat.flatten()
            values[name] = flat.to_numpy(zero_copy_only=False).reshape(part.shape + one.shape)
        texts = table["error"].to_pylist()
        return Block(part.number, values, {row: text for row, text in enumerate(texts) if text}, 0.0)

    def _units(self) -> dict[str, str]:
        units = {name: one.unit for name, (_, one) in self._blocks.grid.coordinates.items()}
        units.update({name: one.unit for name, one in self._outputs.items()})
        return {f"unit of {name}": unit for name, unit in units.items()}


def _file(path: Path, number: int) -> Path:
    return path / f"part-{number:08}.parquet"
