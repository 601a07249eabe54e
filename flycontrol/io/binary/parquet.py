"""Parquet files, through pyarrow, which is heavy and installed on demand."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.source import MOST_NAMES, refuse_huge, refuse_unknown


@dataclass(frozen=True, slots=True)
class Parquet:
    """An open file: a table with named columns."""

    file: Any

    def names(self) -> list[str]:
        """Names of the columns."""
        return list(self.file.schema_arrow.names)[:MOST_NAMES]

    def value(self, path: str) -> NDArray | str:
        """Read a column by its name, or by its number from 0 if no column has it as its name; nulls become NaN."""
        import pyarrow as pa

        names = list(self.file.schema_arrow.names)
        name = names[int(path)] if path not in names and path.isdecimal() and int(path) < len(names) else path
        if names.count(name) != 1:
            if name in names:
                raise InvalidInputError(f"is the name of {names.count(name)} columns; rename them")
            refuse_unknown(path, self.names())
        refuse_huge((self.file.metadata.num_rows,))
        column = self.file.read(columns=[name], use_threads=False).column(0).combine_chunks()
        kind = column.type
        if pa.types.is_dictionary(kind):
            column, kind = column.dictionary_decode(), kind.value_type
        return _array(column, kind)

    def unit(self, path: str) -> str:
        """Parquet states no units."""
        del path
        return ""

    def attribute(self, group: str, name: str) -> object:
        """Return an entry of the schema's metadata."""
        del group
        value = (self.file.schema_arrow.metadata or {}).get(name.encode())
        return None if value is None else value.decode("utf-8", "replace")

    def groups(self, pattern: str) -> list[str]:
        """Tables have no groups."""
        del pattern
        return []


@contextmanager
def open_parquet(path: Path) -> Generator[Parquet]:
    """Open a file for reading; what pyarrow raises at damaged ones is left to the caller."""
    try:
        from pyarrow import parquet
    except ImportError as error:
        raise InvalidInputError(
            "needs pyarrow, which is not installed; install it by: pip install 'flycontrol[parquet]', or save the "
            "table as CSV"
        ) from error
    with parquet.ParquetFile(path, pre_buffer=False) as file:
        yield Parquet(file)


def _array(column: Any, kind: Any) -> NDArray:
    import pyarrow as pa

    if pa.types.is_string(kind) or pa.types.is_large_string(kind):
        return np.array([value or "" for value in column.to_pylist()], dtype=np.str_)
    if not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind)):
        raise InvalidInputError(f"holds values of the type {str(kind)[:40]}; numbers or texts are needed")
    if pa.types.is_integer(kind) and column.null_count == 0:
        return column.to_numpy(zero_copy_only=False)
    return column.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
