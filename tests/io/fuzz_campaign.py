"""A long campaign of malformed files, one process: python tests/io/fuzz_campaign.py [reader=count ...].

Cases that end in anything but a valid result or one sentence are written to .cache/fuzz/fault, with what was wrong
beside them; the status is 1 if there are any. Those that made a library crash or hang are kept too, for the corpus.
"""

import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from fuzz import BINARY_LIMITS, case, outcome_of_case, readers

from flycontrol.io.binary.reader import BinaryReader

TEXT_CASES, BINARY_CASES = 100_000, 20_000
KEPT = Path(".cache/fuzz")


def main(arguments):
    wanted = dict(argument.split("=") for argument in arguments)
    first = int(wanted.pop("first", 0))
    faults = 0
    for name, reader in readers().items():
        count = int(wanted.get(name, wanted.get("binary" if reader.binary else "text", 0)) or 0)
        if not wanted:
            count = BINARY_CASES if reader.binary else TEXT_CASES
        if count:
            faults += run(reader, range(first, first + count))
    return 1 if faults else 0


def run(reader, seeds):
    """Run the cases of one reader, say how they ended, and return the number of faults."""
    started, ends = time.monotonic(), Counter()
    with tempfile.TemporaryDirectory() as folder, BinaryReader(**BINARY_LIMITS) as binary_reader:
        for seed in seeds:
            end = outcome_of_case(reader, seed, folder, binary_reader)
            ends[end.kind] += 1
            if end.kind in ("fault", "crashed", "late"):
                keep(reader, seed, end)
    counts = ", ".join(f"{ends[kind]} {kind}" for kind in ("valid", "refused", "crashed", "late", "fault"))
    sys.stdout.write(f"{reader.name:16} {len(seeds):7} cases in {time.monotonic() - started:6.0f} s: {counts}\n")
    sys.stdout.flush()
    return ends["fault"]


def keep(reader, seed, end):
    """Write a case that went wrong, or made a library crash or hang, and how it ended."""
    folder = KEPT / end.kind
    folder.mkdir(parents=True, exist_ok=True)
    stem = f"{reader.name.replace(' ', '_')}-{seed}"
    (folder / stem).write_bytes(case(reader, seed))
    (folder / f"{stem}.txt").write_text(end.text)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
