"""Files are written whole or not at all."""

import os
import stat
from pathlib import Path

import pytest

from measurement.errors import BadInput
from measurement.files import read_bytes, write_atomically, write_together
from tests.refusing import refusal


def test_text_and_bytes_arrive_unchanged_in_new_folders(tmp_path):
    target = tmp_path / "a" / "b" / "file.txt"
    assert write_atomically(target, "20 °C\r\nline\n") == target
    assert target.read_bytes() == "20 °C\r\nline\n".encode()
    write_atomically(target, b"\x00\xff")
    assert target.read_bytes() == b"\x00\xff"
    assert os.listdir(target.parent) == ["file.txt"]


def test_a_failure_leaves_the_old_file_and_no_debris(tmp_path, monkeypatch):
    target = write_atomically(tmp_path / "file.txt", "old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    assert "cannot be written: No space left on device" in refusal(write_atomically, target, "new")
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["file.txt"]


def test_the_name_is_on_the_disk_after_the_data(tmp_path, monkeypatch):
    target, synced = tmp_path / "file.txt", []
    sync = os.fsync

    def seen(handle: int) -> None:
        folder = stat.S_ISDIR(os.fstat(handle).st_mode)
        synced.append(("folder" if folder else "file", target.exists()))
        sync(handle)

    monkeypatch.setattr(os, "fsync", seen)
    write_atomically(target, "x")
    assert synced == [("file", False), ("folder", True)]


def test_files_that_belong_together_are_written_all_or_none(tmp_path, monkeypatch):
    page, machine = tmp_path / "new" / "page.html", tmp_path / "machine.toml"
    write_together({page: "page", machine: b"one"})
    assert (page.read_text(), machine.read_text()) == ("page", "one")
    sync, count = os.fsync, []

    def full(handle: int) -> None:
        count.append(handle)
        if len(count) == 2:
            raise OSError(28, "No space left on device")
        sync(handle)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(BadInput, match=r"machine\.toml: cannot be written: No space left"):
        write_together({page: "later", machine: "two"})
    assert (page.read_text(), machine.read_text()) == ("page", "one")
    assert sorted(os.listdir(tmp_path)) == ["machine.toml", "new"]
    assert os.listdir(page.parent) == ["page.html"]


def test_a_folder_that_cannot_be_synced_is_no_failure(tmp_path, monkeypatch):
    sync = os.fsync

    def refused(handle: int) -> None:
        if stat.S_ISDIR(os.fstat(handle).st_mode):
            raise OSError(22, "Invalid argument")
        sync(handle)

    monkeypatch.setattr(os, "fsync", refused)
    assert write_atomically(tmp_path / "file.txt", "x").read_text() == "x"


def test_permissions_are_those_of_an_ordinary_new_file(tmp_path):
    plain = tmp_path / "plain"
    plain.touch()
    ours = write_atomically(tmp_path / "ours", "x")
    assert stat.S_IMODE(ours.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)


def test_a_link_stays_a_link(tmp_path):
    real = write_atomically(tmp_path / "real.txt", "old")
    link = tmp_path / "link.txt"
    link.symlink_to(real)
    write_atomically(link, "new")
    assert link.is_symlink()
    assert real.read_text() == "new"


def test_a_name_as_long_as_the_file_system_allows_can_be_written(tmp_path):
    target = write_atomically(tmp_path / ("n" * 255), "x")
    assert target.read_text() == "x"


@pytest.mark.parametrize("target", [".", "file/below", "/dev/null"])
def test_what_cannot_be_written_is_refused_in_one_line(tmp_path, target):
    (tmp_path / "file").touch()
    with pytest.raises(BadInput, match="cannot be written") as refusal:
        write_atomically(tmp_path / target, "x")
    assert "\n" not in str(refusal.value)
    assert Path("/dev/null").is_char_device()


@pytest.mark.parametrize(
    ("name", "problem"),
    [("none", "no such file"), (".", "is a folder"), ("a\0b", "cannot be read")],
)
def test_what_cannot_be_read_is_refused(tmp_path, name, problem):
    assert f"{(tmp_path / name).name}: {problem}" in refusal(read_bytes, tmp_path / name)


def test_what_would_never_end_is_refused_and_the_shell_s_pipe_is_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "link.csv").symlink_to("pipe.csv")
    for path in (tmp_path / "pipe.csv", tmp_path / "link.csv", Path("/dev/zero")):
        assert "is a pipe or a device" in refusal(read_bytes, path)
    reading, writing = os.pipe()
    os.write(writing, b"time_s")
    os.close(writing)
    assert read_bytes(f"/dev/fd/{reading}") == b"time_s"
    os.close(reading)
