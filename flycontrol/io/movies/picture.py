"""One picture file, read by Pillow and made grey."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.recorded import too_large
from flycontrol.io.movies.refusals import refusing
from flycontrol.model.film import ImageArray

FORMATS = {".png": "PNG", ".tif": "TIFF", ".tiff": "TIFF", ".bmp": "BMP", ".jpg": "JPEG", ".jpeg": "JPEG"}
_FIRST = {
    "PNG": (b"\x89PNG",),
    "TIFF": (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    "BMP": (b"BM",),
    "JPEG": (b"\xff\xd8",),
}
_COLOURED = ("RGB", "RGBA", "RGBX", "LA", "La", "CMYK", "YCbCr", "LAB", "HSV")
_MOST_16_BIT = np.iinfo(np.uint16).max


def read_picture(path: Path) -> ImageArray:
    """Read a PNG, TIFF, BMP or JPEG file as grey values (rows, columns).

    Raises
    ------
    InvalidInputError
        If it is damaged, not what its ending says, or larger than any camera's image.
    """
    with refusing(str(path)):
        require_format(path)
        with Image.open(path, formats=(FORMATS[path.suffix.lower()],)) as picture:
            return grey(picture)


def grey(picture: Image.Image) -> ImageArray:
    """Decode a picture that is open: 8 and 16 bit as they are, colours by their luminance (ITU-R 601).

    Pictures of one bit become 0 and 1.
    """
    columns, rows = picture.size
    if fault := too_large(rows, columns):
        raise InvalidInputError(fault)
    mode = picture.mode
    if mode in ("1", "L"):
        return np.asarray(picture, dtype=np.uint8)
    if mode.startswith("I;16"):
        return np.asarray(picture).astype(np.uint16)
    if mode in ("I", "F"):
        return _of_numbers(np.asarray(picture))
    if mode in ("P", "PA"):
        return np.asarray(picture.convert("RGB").convert("L"))
    if mode in _COLOURED:
        return np.asarray(picture.convert("L"))
    raise InvalidInputError(f"has pixels of the kind {mode!r}, which is neither grey nor coloured")


def require_format(path: Path) -> None:
    """Refuse a file that is empty or not what its ending says."""
    with path.open("rb") as file:
        head = file.read(8)
    if not head:
        raise InvalidInputError("is empty")
    form = FORMATS[path.suffix.lower()]
    if not head.startswith(_FIRST[form]):
        other = next((name for name, first in _FIRST.items() if head.startswith(first)), "")
        raise InvalidInputError(f"is no {form} file by its first bytes" + (f", but a {other} file" if other else ""))


def _of_numbers(values: np.ndarray) -> ImageArray:
    if not np.all(np.isfinite(values)):
        raise InvalidInputError("has pixels that are no finite numbers")
    if values.dtype.kind == "i" and values.min() >= 0 and values.max() <= _MOST_16_BIT:
        return values.astype(np.uint16)
    return values.astype(np.float64)
