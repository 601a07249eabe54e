"""Results as bytes without pickle: an .npz with one flat array per type of number, and a JSON tree pointing into it."""

from __future__ import annotations

import io
import json
import math
import types
from typing import TypeAlias

import numpy as np

from flycontrol.errors import InvalidParameterError

Result: TypeAlias = "bool | int | float | str | np.ndarray | np.generic | list[Result] | dict[str, Result] | None"
"""What a task may return."""

_TREE = "tree"


class Packing:
    """Results on their way into bytes.

    Arrays are copied when a result is added, so a task may fill the same array again for the next one.
    """

    def __init__(self) -> None:
        self._trees: list[object] = []
        self._flat: dict[str, list[np.ndarray]] = {}
        self._length: dict[str, int] = {}

    def add(self, result: Result, where: str) -> None:
        """Take one more result.

        Parameters
        ----------
        result
            Arrays of numbers or text, scalars, strings, None, and lists and dicts (string keys) of these.
        where
            What the message calls it if it is anything else.

        Raises
        ------
        InvalidParameterError
            If the result holds anything else, a tuple for instance, which would come back as a list.
        """
        self._trees.append(self._strip(result, where))

    def to_bytes(self) -> bytes:
        """Return all results added so far; equal results give equal bytes."""
        tree = np.frombuffer(json.dumps(self._trees).encode(), np.uint8)
        flat = {kind: np.concatenate(parts, dtype=kind) for kind, parts in self._flat.items()}
        buffer = io.BytesIO()
        np.savez(buffer, allow_pickle=False, **{_TREE: tree, **flat})
        return buffer.getvalue()

    def _strip(self, value: object, where: str) -> object:
        if isinstance(value, np.ndarray | np.generic) and _is_plain(value):
            return {"array" if isinstance(value, np.ndarray) else "scalar": self._put(np.asarray(value))}
        if type(value) in (bool, int, float, str, types.NoneType):
            return value
        if type(value) is list:
            return [self._strip(part, f"{where}[{i}]") for i, part in enumerate(value)]
        if type(value) is dict and all(type(key) is str for key in value):
            return {"record": {key: self._strip(part, f"{where}[{key!r}]") for key, part in value.items()}}
        raise InvalidParameterError(
            f"{where} must be made of arrays, numbers, strings, None, lists and dicts with string keys, "
            f"got {type(value).__name__}; let the task return these."
        )

    def _put(self, array: np.ndarray) -> list[object]:
        """Copy the array behind those of its type; return where it stands: type, offset, shape."""
        kind = array.dtype.str
        offset = self._length.get(kind, 0)
        self._length[kind] = offset + array.size
        self._flat.setdefault(kind, []).append(array.flatten())
        return [kind, offset, list(array.shape)]


def unpacked(data: bytes) -> list[Result]:
    """Return the results that `Packing.to_bytes` gave as `data`, bit for bit."""
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        trees = json.loads(file[_TREE].tobytes())
        flat = {kind: file[kind] for kind in file.files if kind != _TREE}
    return [_restored(tree, flat) for tree in trees]


def _is_plain(value: np.ndarray | np.generic) -> bool:
    """Tell arrays of numbers or text from those of objects, of records, and from masked ones and matrices."""
    return (type(value) is np.ndarray or isinstance(value, np.generic)) and value.dtype.kind in "biufcSUmM"


def _restored(tree: object, flat: dict[str, np.ndarray]) -> Result:
    if isinstance(tree, list):
        return [_restored(part, flat) for part in tree]
    if not isinstance(tree, dict):
        return tree  # type: ignore[return-value]
    ((tag, content),) = tree.items()
    if tag == "record":
        return {key: _restored(part, flat) for key, part in content.items()}
    kind, offset, shape = content
    array = flat[kind][offset : offset + math.prod(shape)].reshape(shape)
    return array.copy() if tag == "array" else array[()]
