"""One sentence for whatever a library says of a damaged file."""

from __future__ import annotations

import warnings
from collections.abc import Generator
from contextlib import contextmanager

from flycontrol.errors import InvalidInputError


@contextmanager
def refusing(where: str) -> Generator[None]:
    """Turn errors of any kind into an InvalidInputError that begins with `where`; warnings stay here."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except FileNotFoundError as error:
        raise InvalidInputError(f"{where}: there is no such file.") from error
    except InvalidInputError as error:
        raise InvalidInputError(str(error) if str(error).startswith(where) else f"{where} {error}.") from error
    except MemoryError as error:
        raise InvalidInputError(f"{where} asks for more memory than there is; it is damaged or too large.") from error
    except Exception as error:  # decoders let errors of all kinds through
        said = " ".join(str(error).split())[:150].rstrip(".")
        raise InvalidInputError(
            f"{where} cannot be read ({said or type(error).__name__}); it is damaged or unfinished."
        ) from error
