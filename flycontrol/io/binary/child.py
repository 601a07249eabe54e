"""The process that opens binary files: one request a line on stdin, one reply each on stdout.

The libraries of MATLAB, HDF5 and netCDF files crash, hang or fill the memory on some damaged files. Here that costs
this process and no more: a watch that needs no interpreter ends it when time is up, the system when memory is.
"""

from __future__ import annotations

import faulthandler
import os
import sys
import warnings
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.request import Found, Reply, Request, Wanted, parse_request, refused, write_reply
from flycontrol.io.binary.source import AbsentError, Source, numbers, series, shape_text, text, texts


def main(seconds: float, memory: int) -> None:
    """Answer requests until stdin ends."""
    _limit_memory(memory)
    warnings.simplefilter("ignore")
    requests, replies = sys.stdin.buffer, os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    sys.stdout = sys.stderr  # what a library prints is no reply
    with Path(os.devnull).open("w") as nowhere:
        for line in requests:
            faulthandler.dump_traceback_later(seconds, exit=True, file=nowhere)
            reply = answer(parse_request(line))
            faulthandler.cancel_dump_traceback_later()
            write_reply(reply, replies)


def answer(request: Request) -> Reply:
    """Read what is asked for; whatever goes wrong becomes a refusal."""
    try:
        with _opened(request) as source:
            return _summary(source) if request.summary else _read(source, request)
    except InvalidInputError as error:
        return Reply(str(error) if str(error).startswith(request.name) else f"{request.name} {error}.")
    except MemoryError:
        return Reply(f"{request.name} asks for more memory than there is; it is damaged or too large: cut it.")
    except RecursionError:
        return Reply(f"{request.name} is nested without end; it is damaged: export it again.")
    except Exception as error:  # the libraries' readers let errors of all kinds through
        said = " ".join(str(error).split())[:150].rstrip(".")
        said = said if said.isprintable() else ascii(said)
        return Reply(
            f"{request.name} cannot be read as {request.form} ({said or type(error).__name__}); it is damaged or "
            "unfinished: export it again."
        )


@contextmanager
def _opened(request: Request) -> Generator[Source]:
    path = Path(request.path)
    if request.layout == "matlab 5":
        from flycontrol.io.binary.matlab5 import open_matlab5

        yield open_matlab5(path, None if request.summary else _beginnings(request))
    elif request.layout == "netcdf classic":
        from flycontrol.io.binary.netcdf3 import open_netcdf3

        with open_netcdf3(path) as source:
            yield source
    elif request.layout == "parquet":
        from flycontrol.io.binary.parquet import open_parquet

        with open_parquet(path) as source:
            yield source
    elif request.form == "mat":
        from flycontrol.io.binary.matlab73 import open_matlab73

        with open_matlab73(path) as source:
            yield source
    else:
        from flycontrol.io.binary.hdf5 import open_hdf5

        with open_hdf5(path, packed=request.form == "netcdf") as source:
            yield source


def _beginnings(request: Request) -> list[str]:
    """Paths from the root of the file: those of the groups, and of what is wanted outside of them."""
    inside = bool(request.groups)
    return [*request.groups, *(item.path for item in request.wanted if not inside or item.path.startswith("/"))]


def _read(source: Source, request: Request) -> Reply:
    groups = [""]
    if request.groups:
        groups = [group for pattern in request.groups for group in source.groups(pattern)]
        if not groups:
            raise InvalidInputError(
                f"has no group or structure {' or '.join(map(repr, request.groups))}; there are the variables "
                f"{', '.join(source.names()[:12])}"
            )
    return Reply(
        groups=[(group, [_found(source, request, group, item) for item in request.wanted]) for group in groups]
    )


def _found(source: Source, request: Request, group: str, wanted: Wanted) -> Found:
    path = wanted.path.lstrip("/") if wanted.path.startswith("/") or not group else f"{group}/{wanted.path}"
    try:
        if wanted.what == "attribute":
            return _attribute(source.attribute(group, wanted.path))
        if wanted.what == "array":
            return _array(source, path)
        value = source.value(path)
        if wanted.what == "texts":
            single = isinstance(value, str) or value.size == 1
            return Found(texts=[text(value)] if single else texts(value))
        return Found(series(numbers(value), wanted.row, wanted.column), unit=source.unit(path)[:40])
    except InvalidInputError as error:
        raise InvalidInputError(refused(request, wanted, error)) from error


def _array(source: Source, path: str) -> Found:
    try:
        array = numbers(source.value(path))
    except AbsentError:
        return Found()
    return Found(array.reshape(-1), shape=array.shape)


def _attribute(value: object) -> Found:
    if isinstance(value, bool) or value is None:
        raise InvalidInputError("is not there" if value is None else "is neither a number nor a text")
    import numpy as np

    if isinstance(value, int | float):
        return Found(np.array([float(value)]), [text(np.array([value]))] if np.isfinite(value) else [])
    try:
        return Found(np.array([float(str(value))]), [str(value).strip()])
    except ValueError:
        return Found(texts=[str(value).strip()])


def _summary(source: Source) -> Reply:
    """Names, shapes and the numbers of all variables that hold few enough."""
    found: list[tuple[str, list[Found]]] = []
    for name in source.names()[:100]:
        try:
            value = numbers(source.value(name))
            found.append(
                (name, [Found(value.reshape(-1, order="F"), [shape_text(value.shape)], source.unit(name)[:40])])
            )
        except InvalidInputError as error:
            found.append((name, [Found(texts=[str(error)])]))
    return Reply(groups=found)


def _limit_memory(memory: int) -> None:
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except (ImportError, OSError, ValueError):  # where the system knows no such limit, time alone is limited
        pass


if __name__ == "__main__":
    main(float(sys.argv[1]), int(sys.argv[2]))
