"""What the packages need of the system: nothing that only Unix has, and no file renamed while open.

None of this replaces a run on Windows, which .github/workflows/tests.yml has.
"""

import builtins
import errno
import os
import sys
from pathlib import Path
from types import SimpleNamespace

import packages
import pytest

from compare.output.places import LOCK, working_folder
from semianalytic.results import files
from semianalytic.results.files import new_file, write_bytes
from semianalytic.scene.errors import DataFileError

UNIX = """
import builtins, os, re, signal, sys

OURS = ("slipfront", "semianalytic", "fem", "meshes", "compare")
MISSING = {"resource", "fcntl", "pwd", "grp", "termios", "tty", "pty", "readline", "posix"}
imports = builtins.__import__

def asked(name, globals=None, locals=None, fromlist=(), level=0):
    by = (globals or {}).get("__name__", "").split(".")[0]
    if by in OURS and name.split(".")[0] in MISSING:
        raise ModuleNotFoundError(f"No module named {name!r}, asked for by {by}", name=name)
    return imports(name, globals, locals, fromlist, level)

builtins.__import__ = asked
SIGNALS = {"SIGKILL", "SIGPIPE", "SIGHUP", "SIGALRM", "pthread_sigmask", "setitimer"}
CALLS = {"fork", "getloadavg", "nice", "sysconf", "killpg", "setsid"}
for name in SIGNALS:
    delattr(signal, name)
for name in CALLS:
    delattr(os, name)
"""
IMPORTS = """
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

count, named = 0, re.compile(rf"\\b({'|'.join(MISSING | SIGNALS | CALLS)})\\b")
for package in OURS:
    root = Path(find_spec(package).origin).parent
    for path in root.rglob("*.py"):
        if path.stem != "__main__":
            count += 1
            if named.search(path.read_text(encoding="utf-8")):
                # a module that names none of them needs none
                parts = path.relative_to(root.parent).with_suffix("").parts
                import_module(".".join(parts).removesuffix(".__init__"))
from slipfront.cli.commands import main
assert main(["solve", "preloaded", "--json"]) == 0
print(count)
"""


def without_unix(code, folder):
    return packages.run("", "-c", UNIX + code, cwd=folder)


def test_no_module_needs_what_only_unix_has(tmp_path):
    done = without_unix(IMPORTS, tmp_path)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[-1]) > 250


@pytest.fixture
def windows(monkeypatch):
    """Refuse to rename and to remove files that are open in this process, as Windows does."""
    if not Path("/proc/self/fd").exists():
        pytest.skip("this system does not tell which files are open")
    locked = {}

    def locking(descriptor, how, count):
        assert os.lseek(descriptor, 0, os.SEEK_CUR) == files._LOCKED_BYTE
        name = os.readlink(f"/proc/self/fd/{descriptor}")
        holder = locked.get(name)
        if holder is not None and holder != descriptor and is_open(Path(name), holder):
            raise OSError(errno.EACCES, "Permission denied")
        locked[name] = descriptor

    def is_open(path, only=None):
        for file in Path("/proc/self/fd").iterdir():
            try:
                found = os.readlink(file) == os.path.realpath(path)
            except OSError:
                continue
            if found and only in (None, int(file.name)):
                return True
        return False

    def guarded(does):
        def act(path, *rest, **options):
            if is_open(path):
                raise PermissionError(errno.EACCES, "The process cannot access the file", str(path))
            return does(path, *rest, **options)

        return act

    for name in ("replace", "rename", "unlink", "remove"):
        monkeypatch.setattr(os, name, guarded(getattr(os, name)))
    monkeypatch.setattr(Path, "unlink", _unlink)
    monkeypatch.setattr(files, "sys", SimpleNamespace(platform="win32"))
    monkeypatch.setattr(files, "_KEEPS_WHAT_IS_OPEN", True)
    msvcrt = SimpleNamespace(locking=locking, LK_NBLCK=2)
    monkeypatch.setitem(sys.modules, "msvcrt", msvcrt)
    real = builtins.__import__
    monkeypatch.setattr(
        builtins,
        "__import__",
        lambda name, *rest, **o: (
            pytest.fail("fcntl was imported") if name == "fcntl" else real(name, *rest, **o)
        ),
    )


def _unlink(self, missing_ok=False):
    try:
        os.unlink(self)
    except FileNotFoundError:
        if not missing_ok:
            raise


def test_files_are_written_and_replaced(windows, tmp_path):
    path = tmp_path / "a.txt"
    for text in (b"one", b"two"):
        write_bytes(path, text)
        assert path.read_bytes() == text
    assert list(tmp_path.iterdir()) == [path]


def test_a_failed_file_leaves_nothing(windows, tmp_path):
    with pytest.raises(ZeroDivisionError), new_file(tmp_path / "a.txt"):
        raise ZeroDivisionError
    with pytest.raises(DataFileError, match="no room"), new_file(tmp_path / "a.txt"):
        raise OSError(errno.EIO, "no room")
    assert list(tmp_path.iterdir()) == []


def test_leftovers_go_and_files_of_others_stay(windows, tmp_path):
    path = tmp_path / "a.txt"
    dead = tmp_path / ".a.txt.0123456789ab.part"
    dead.write_text("half")
    with new_file(path) as mine:
        assert not dead.exists()
        write_bytes(path, b"of another writer")
        assert mine.exists()
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_is_locked_and_its_lock_removed(windows, tmp_path):
    with working_folder(tmp_path / "run"):
        assert (tmp_path / "run" / LOCK).exists()
        with (
            pytest.raises(DataFileError, match="another run is writing"),
            working_folder(tmp_path / "run"),
        ):
            pass
    assert list(tmp_path.iterdir()) == []
