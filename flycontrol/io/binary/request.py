"""What is asked of a binary file, and what comes back: JSON and raw float64, since a reader may die on the way."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from typing import Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.formats import BinaryFormat, Layout

FloatArray = NDArray[np.float64]

_LENGTH = 8  #: bytes that say how long a header is


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """A variable or an attribute that a mapping names."""

    path: str  #: within the group of the trial; from the file's root if it begins with /
    row: int | None = None
    column: int | None = None
    what: Literal["numbers", "texts", "attribute", "array"] = "numbers"  #: an array may be empty, and of any shape
    key: str = ""  #: its name in the mapping, "left.stroke"
    where: str = ""  #: file and line of the mapping


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """One file and what to read of it, once for each group."""

    path: str
    name: str  #: of the file, for refusals
    layout: Layout
    form: BinaryFormat
    wanted: tuple[Wanted, ...] = ()
    groups: tuple[str, ...] = ()  #: patterns; none: the file is one trial
    summary: bool = False  #: list the variables instead


@dataclass(frozen=True, slots=True)
class Found:
    """What stands at the place of one Wanted."""

    numbers: FloatArray | None = None
    texts: list[str] = field(default_factory=list[str])
    unit: str = ""  #: as the file states it
    shape: tuple[int, ...] | None = None  #: of an array that was asked for; None: it is not there

    def array(self) -> FloatArray | None:
        """Return the numbers in the shape that they have in the file; None if they are not there."""
        return None if self.numbers is None or self.shape is None else self.numbers.reshape(self.shape)


@dataclass(frozen=True, slots=True)
class Reply:
    """For each group its path and what was found, in the order of `wanted`; or a refusal."""

    refusal: str = ""
    groups: list[tuple[str, list[Found]]] = field(default_factory=list[tuple[str, list[Found]]])


def write_request(request: Request, stream: BinaryIO) -> None:
    """Write a request as one line."""
    stream.write(json.dumps(asdict(request)).encode() + b"\n")
    stream.flush()


def parse_request(line: bytes) -> Request:
    """Read a request's line."""
    given: dict[str, Any] = json.loads(line)
    given["wanted"] = tuple(Wanted(**item) for item in given["wanted"])
    given["groups"] = tuple(given["groups"])
    return Request(**given)


def write_reply(reply: Reply, stream: BinaryIO) -> None:
    """Write the header's length, the header, and all numbers one after the other."""
    groups = [[path, [_head(found) for found in values]] for path, values in reply.groups]
    header = json.dumps({"refusal": reply.refusal, "groups": groups}).encode()
    stream.write(len(header).to_bytes(_LENGTH, "little") + header)
    for _, values in reply.groups:
        for found in values:
            if found.numbers is not None:
                stream.write(np.ascontiguousarray(found.numbers, dtype=np.float64).tobytes())
    stream.flush()


def read_reply(stream: BinaryIO) -> Reply:
    """Read a reply; EOFError if its writer died."""
    header: dict[str, Any] = json.loads(_exactly(stream, int.from_bytes(_exactly(stream, _LENGTH), "little")))
    groups: list[tuple[str, list[Found]]] = []
    for path, heads in header["groups"]:
        groups.append((path, [_found(head, stream) for head in heads]))
    return Reply(header["refusal"], groups)


def refused(request: Request, wanted: Wanted, error: InvalidInputError | str) -> str:
    """Name file, key and place in the mapping."""
    place = f" ({wanted.where})" if wanted.where else ""
    kind = "attribute" if wanted.what == "attribute" else "variable"
    return f"{request.name}: the {kind} {wanted.path!r} of {wanted.key} {error}{place}."


def _head(found: Found) -> dict[str, Any]:
    count = None if found.numbers is None else int(found.numbers.size)
    return {"count": count, "texts": found.texts, "unit": found.unit, "shape": found.shape}


def _found(head: dict[str, Any], stream: BinaryIO) -> Found:
    shape = None if head["shape"] is None else tuple(int(n) for n in head["shape"])
    if head["count"] is None:
        return Found(None, head["texts"], head["unit"])
    numbers = np.frombuffer(_exactly(stream, 8 * head["count"]), dtype=np.float64)
    return Found(numbers, head["texts"], head["unit"], shape)


def _exactly(stream: BinaryIO, count: int) -> bytes:
    data = stream.read(count)
    if len(data) != count:
        raise EOFError
    return data
