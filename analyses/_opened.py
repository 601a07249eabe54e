"""A lab note opens with its answer, as it stands in the analysis under "The answer", and names its source."""

from pathlib import Path


def opened(file: str, text: str) -> str:
    """Put the answer and a link to the analysis below the title of a note in Markdown."""
    title, _, rest = text.partition("\n\n")
    name = Path(file).name
    return f"{title}\n\n{answer_of(file)}\n\nMade by [analyses/{name}](../../analyses/{name}).\n\n{rest}"


def answer_of(file: str) -> str:
    """Comments from "# ## The answer" to the first line that is none, as paragraphs."""
    lines = Path(file).read_text(encoding="utf-8").splitlines()
    rest = lines[lines.index("# ## The answer") + 1 :]
    end = next(k for k, line in enumerate(rest) if not line.startswith("#"))
    said = "\n".join(line.removeprefix("#").removeprefix(" ") for line in rest[:end])
    return "\n\n".join(" ".join(part.split()) for part in said.strip().split("\n\n"))
