"""Text files as they come: read whole, hashed, and refused in one sentence when they are no text files."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from flycontrol.errors import InvalidInputError
from flycontrol.io.formats import refuse_binary, require_regular_file


@dataclass(frozen=True, slots=True)
class TextFile:
    """A text file's name as the user wrote it, its text and the hash of its bytes."""

    name: str
    text: str
    sha256: str


def read_text_file(path: Path) -> TextFile:
    """Read a UTF-8 text file.

    Raises
    ------
    InvalidInputError
        If there is no such file, if it is a folder, empty, unreadable, or no UTF-8 text.
    """
    require_regular_file(path)
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise InvalidInputError(f"{path}: there is no such file.") from error
    except OSError as error:
        raise InvalidInputError(f"{path} cannot be read: {error.strerror or error}.") from error
    except ValueError as error:  # a zero byte in its name
        raise InvalidInputError(f"{str(path)!r} cannot be read: {error}.") from error
    return text_file(str(path), data)


def text_file(name: str, data: bytes) -> TextFile:
    """Decode the bytes of a file; refused like `read_text_file`."""
    if not data.strip():
        raise InvalidInputError(f"{name} is empty.")
    refuse_binary(name, data)
    zero = data.find(b"\0")
    if zero >= 0:
        raise InvalidInputError(f"{name} is not a text file: byte {zero} is zero; save it as UTF-8 text.")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InvalidInputError(
            f"{name}, line {line}: byte 0x{data[error.start]:02x} is not UTF-8; save the file as UTF-8 text."
        ) from error
    return TextFile(name, text, hashlib.sha256(data).hexdigest())
