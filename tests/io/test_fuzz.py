import time
from functools import cache
from hashlib import blake2b
from pathlib import Path

import pytest
from fuzz import BINARY_LIMITS, CORPUS, case, outcome, outcome_of_case, readers
from strange_files import sound

import flycontrol.io
from flycontrol.io.binary.reader import BinaryReader, shared_reader

FRESH = {"text": 230, "binary": 50}  # of each reader: 2,000 and a few in all
MANY = {"text": 3_000, "binary": 500}
NAMES = tuple(readers())


@pytest.fixture(scope="module")
def binary_reader():
    with BinaryReader(**BINARY_LIMITS) as reader:
        yield reader


@cache
def first_seed():
    """A number of the readers' own source: other cases after every change of them, the same ones until then."""
    sources = sorted(Path(flycontrol.io.__file__).parent.rglob("*.py"))
    return int.from_bytes(blake2b(b"".join(path.read_bytes() for path in sources), digest_size=5).digest())


def assert_no_fault(name, seed, folder, binary_reader):
    end = outcome_of_case(readers()[name], seed, folder, binary_reader)
    assert end.kind != "fault", f"case(readers()[{name!r}], {seed}) ended in: {end.text}"


@pytest.mark.parametrize("path", sorted(CORPUS.iterdir()), ids=lambda path: path.name)
def test_a_file_of_the_corpus_is_read_or_refused_in_one_sentence(path, binary_reader):
    reader = readers()[path.name.partition("--")[0].replace("_", " ")]
    end = outcome(reader, path, binary_reader)
    assert end.kind != "fault", end.text


@pytest.mark.parametrize("name", NAMES)
def test_fresh_malformed_files_are_read_or_refused_in_one_sentence(name, tmp_path, binary_reader):
    count = FRESH["binary" if readers()[name].binary else "text"]
    first = first_seed()
    for seed in range(first, first + count):
        assert_no_fault(name, seed, tmp_path, binary_reader)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_many_malformed_files_are_read_or_refused_in_one_sentence(name, tmp_path, binary_reader):
    for seed in range(MANY["binary" if readers()[name].binary else "text"]):
        assert_no_fault(name, seed, tmp_path, binary_reader)


@pytest.mark.parametrize("name", [name for name in NAMES if readers()[name].binary])
def test_the_sound_files_that_are_damaged_are_read(name, tmp_path):
    (tmp_path / "sound").write_bytes(sound(name))
    end = outcome(readers()[name], tmp_path / "sound", shared_reader())
    assert end.kind == "valid", end.text


@pytest.mark.parametrize("name", NAMES)
def test_a_case_is_the_same_bytes_from_its_seed(name, monkeypatch):
    once = case(readers()[name], 7)
    monkeypatch.setattr(time, "asctime", lambda: "Wed Dec 31 23:59:59 1997")  # what is written at another hour
    assert case(readers()[name], 7) == once
    assert len({case(readers()[name], seed) for seed in range(20)}) > 10


def test_a_crash_of_a_library_costs_a_sentence_and_the_next_file_is_read(tmp_path, monkeypatch):
    """A real crash: the process ends itself by a segmentation fault, or hangs, where it would open the file."""
    crash = tmp_path / "crash"
    crash.mkdir()
    (crash / "h5py.py").write_text(
        "import ctypes, time\n"
        "class File:\n"
        "    def __init__(self, path, mode):\n"
        "        if 'hangs' in str(path): time.sleep(60)\n"
        "        ctypes.string_at(0)\n"
    )
    monkeypatch.syspath_prepend(crash)
    hdf5, matlab = readers()["hdf5"], readers()["mat5"]
    for name in ("hangs", "crashes"):
        (tmp_path / name).write_bytes(sound("hdf5"))
    (tmp_path / "sound").write_bytes(sound("mat5"))
    with BinaryReader(seconds=1.0) as reader:
        late = outcome(hdf5, tmp_path / "hangs", reader)
        assert late.kind == "late"
        assert "hangs took longer than 1 s to read; it is damaged or too large: export it again." in late.text
    with BinaryReader() as reader:
        crashed = outcome(hdf5, tmp_path / "crashes", reader)
        assert crashed.kind == "crashed"
        assert "crashes made the library that reads hdf5 files crash; it is damaged" in crashed.text
        assert outcome(matlab, tmp_path / "sound", reader).kind == "valid"


def test_damage_is_damage():
    """Mutations change nearly every file, so that the counts of cases mean something."""
    csv = readers()["csv"]
    sound_table = b"t,yaw,fly,onset\n"
    changed = [case(csv, seed) for seed in range(200)]
    assert len(set(changed)) > 180
    assert any(not data.startswith(sound_table) for data in changed)
