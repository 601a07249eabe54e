import errno
import os
from pathlib import Path

import pytest

from flycontrol.errors import OutputError
from flycontrol.jobs import files
from flycontrol.jobs.files import discard_torn, require_writable_folder, temporary_file, write_files_atomically

NEW = {"index.html": "<p>new</p>", "result.json": '{"new": true}'}


def no_space(*_args, **_kwargs):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def failing_from(call, count, error=no_space):
    """Let a method succeed `count` times, then raise."""
    remaining = iter(range(count))

    def wrapped(*args, **kwargs):
        return error() if next(remaining, None) is None else call(*args, **kwargs)

    return wrapped


class FullDisk:
    """A file that takes the first bytes and then finds the disk full."""

    def __init__(self, file):
        self._file = file

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        self._file.close()

    def write(self, data):
        self._file.write(data[: len(data) // 2])
        no_space()


@pytest.fixture
def folder_with_earlier_results(tmp_path):
    for name in NEW:
        (tmp_path / name).write_text("earlier")
    return tmp_path


def contents(folder):
    return {path.name: path.read_text() for path in folder.iterdir()}


EARLIER = dict.fromkeys(NEW, "earlier")


def test_all_files_are_written_and_nothing_else_remains(tmp_path):
    written = write_files_atomically(tmp_path / "a" / "b", NEW)
    assert contents(tmp_path / "a" / "b") == NEW
    assert written == tuple(tmp_path / "a" / "b" / name for name in NEW)


def test_bytes_are_written_as_they_are(tmp_path):
    write_files_atomically(tmp_path, {"x.bin": b"\x00\xff\r\n"})
    assert (tmp_path / "x.bin").read_bytes() == b"\x00\xff\r\n"


def test_newlines_are_not_translated_and_text_is_utf8(tmp_path):
    write_files_atomically(tmp_path, {"x.txt": "ψ\r\n"})
    assert (tmp_path / "x.txt").read_bytes() == "ψ\r\n".encode()


def test_earlier_results_are_replaced(folder_with_earlier_results):
    write_files_atomically(folder_with_earlier_results, NEW)
    assert contents(folder_with_earlier_results) == NEW


def test_new_files_have_the_permissions_of_ordinary_files(tmp_path):
    (tmp_path / "ordinary").touch()
    write_files_atomically(tmp_path, NEW)
    assert (tmp_path / "index.html").stat().st_mode == (tmp_path / "ordinary").stat().st_mode


def test_a_disk_that_fills_while_writing_leaves_earlier_results_whole(folder_with_earlier_results, monkeypatch):
    really_open = Path.open
    monkeypatch.setattr(Path, "open", lambda path, mode: FullDisk(really_open(path, mode)))
    with pytest.raises(OutputError, match=r"index\.html could not be written: No space left on device"):
        write_files_atomically(folder_with_earlier_results, NEW)
    monkeypatch.undo()
    assert contents(folder_with_earlier_results) == EARLIER


@pytest.mark.parametrize("succeeding", [0, 1])
def test_a_disk_that_fills_on_fsync_leaves_earlier_results_whole(folder_with_earlier_results, monkeypatch, succeeding):
    monkeypatch.setattr(files.os, "fsync", failing_from(os.fsync, succeeding))
    with pytest.raises(OutputError, match="No space left on device"):
        write_files_atomically(folder_with_earlier_results, NEW)
    assert contents(folder_with_earlier_results) == EARLIER


def rename_failing_after(monkeypatch, succeeding, error=no_space):
    """Let renames of finished files fail; putting an earlier version back still works."""
    replace = Path.replace
    failing = failing_from(replace, succeeding, error)
    targets = set()

    def rename(path, target):
        if target in targets:
            return replace(path, target)
        targets.add(target)
        return failing(path, target)

    monkeypatch.setattr(Path, "replace", rename)


@pytest.mark.parametrize("succeeding", [0, 1])
def test_a_rename_that_fails_restores_the_files_already_renamed(folder_with_earlier_results, monkeypatch, succeeding):
    rename_failing_after(monkeypatch, succeeding)
    with pytest.raises(OutputError, match="No space left on device; earlier results are unchanged"):
        write_files_atomically(folder_with_earlier_results, NEW)
    assert contents(folder_with_earlier_results) == EARLIER


def test_a_rename_that_fails_removes_new_files_that_replaced_nothing(tmp_path, monkeypatch):
    rename_failing_after(monkeypatch, 1)
    with pytest.raises(OutputError):
        write_files_atomically(tmp_path / "new", NEW)
    assert contents(tmp_path) == {}


def test_an_earlier_version_that_cannot_be_put_back_is_kept_and_named(folder_with_earlier_results, monkeypatch):
    monkeypatch.setattr(Path, "replace", failing_from(Path.replace, 1))
    with pytest.raises(OutputError, match=r"could not be put back: index\.html \(earlier version: (.*)\)") as refusal:
        write_files_atomically(folder_with_earlier_results, NEW)
    kept = str(refusal.value).split("earlier version: ")[1].removesuffix(").")
    assert Path(kept).read_text() == "earlier"


def test_an_interrupt_between_renames_restores_everything(folder_with_earlier_results, monkeypatch):
    def interrupt():
        raise KeyboardInterrupt

    rename_failing_after(monkeypatch, 1, interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_files_atomically(folder_with_earlier_results, NEW)
    assert contents(folder_with_earlier_results) == EARLIER


def test_earlier_results_survive_on_file_systems_without_hard_links(folder_with_earlier_results, monkeypatch):
    def unsupported(*_):
        raise OSError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(Path, "hardlink_to", unsupported)
    rename_failing_after(monkeypatch, 1)
    with pytest.raises(OutputError):
        write_files_atomically(folder_with_earlier_results, NEW)
    assert contents(folder_with_earlier_results) == EARLIER


def test_a_target_that_is_a_folder_is_refused(tmp_path):
    (tmp_path / "result.json").mkdir()
    with pytest.raises(OutputError, match=r"result\.json could not be written"):
        write_files_atomically(tmp_path, NEW)
    assert [path.name for path in tmp_path.iterdir()] == ["result.json"]


def test_a_folder_below_a_regular_file_is_refused(tmp_path):
    (tmp_path / "file").write_text("x")
    for refuse in (require_writable_folder, lambda folder: write_files_atomically(folder, NEW)):
        with pytest.raises(OutputError, match="file"):
            refuse(tmp_path / "file" / "reports")
    assert contents(tmp_path) == {"file": "x"}


def test_a_regular_file_as_output_folder_is_refused(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match="is not a folder"):
        require_writable_folder(tmp_path / "file")


def test_a_folder_where_no_file_can_be_created_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(Path, "touch", no_space)
    with pytest.raises(OutputError, match="no file can be created"):
        require_writable_folder(tmp_path / "new")


def test_asking_whether_a_folder_is_writable_leaves_nothing_behind(tmp_path):
    require_writable_folder(tmp_path / "a" / "b")
    assert contents(tmp_path) == {}


def test_files_in_folders_of_their_own_are_written_all_or_none(tmp_path):
    (tmp_path / "blocked").write_text("a file where a folder must be")
    with pytest.raises(OutputError, match="blocked"):
        write_files_atomically(tmp_path, {"index.html": "a", "fly1/index.html": "b", "blocked/index.html": "c"})
    assert [path.name for path in tmp_path.iterdir()] == ["blocked"]
    write_files_atomically(tmp_path, {"index.html": "a", "fly1/index.html": "b"})
    assert (tmp_path / "fly1" / "index.html").read_text() == "b"


def test_what_killed_processes_left_is_removed_and_nothing_else(tmp_path):
    with temporary_file(tmp_path, "recording.csv") as path:
        left = path.name
    (tmp_path / left).touch()
    others = (".notes.csv.0123abcd.part", "recording.csv", ".recording.csv.part", ".recording.csv.0123abcd.part2")
    for name in others:
        (tmp_path / name).touch()
    discard_torn(tmp_path, ["index.html", "recording.csv"])
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(others)
    discard_torn(tmp_path / "nowhere", ["recording.csv"])
