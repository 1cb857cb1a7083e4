"""Files of runs: read and written whole, and what tells two of them apart."""

from __future__ import annotations

import contextlib
import hashlib
import os
import pathlib
import re
import stat
import tempfile
from typing import Iterable, List, Set

from .status import UsageError

FOLDER_WORDS = re.compile(r"""(?:mesh|asset)dir\s*=\s*["']([^"']*)["']""")
FILE_WORDS = re.compile(r"""\bfile\s*=\s*["']([^"']*)["']""")


def make_folder(folder: pathlib.Path) -> pathlib.Path:
    """Makes the folder and those above it. Returns its absolute path."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot make {folder}: {error.strerror}") from None
    return pathlib.Path(os.path.abspath(folder))


def read_bytes(file: pathlib.Path) -> bytes:
    """A file's bytes, none if there is no such file."""
    with contextlib.suppress(OSError):
        return file.read_bytes()
    return b""


def write_text(file: pathlib.Path, text: str) -> None:
    """Whole or not at all: what was there stays until the new file is complete."""
    target = pathlib.Path(os.path.realpath(file))  # a link stays one
    try:
        if target.exists() and not target.is_file():  # a pipe, a device
            target.write_text(text, encoding="utf-8")
            return
        _replace(target, text)
    except OSError as error:
        raise RuntimeError(f"cannot write {file}: {error.strerror}") from None


def _replace(target: pathlib.Path, text: str) -> None:
    descriptor, name = tempfile.mkstemp(prefix=".c3rt-", suffix=".part", dir=target.parent)
    part = pathlib.Path(name)
    try:
        with open(descriptor, "w", encoding="utf-8") as stream:
            stream.write(text)
            stream.flush()
            os.fchmod(descriptor, _mode_of(target))
            os.fsync(descriptor)
        part.replace(target)
    except BaseException:
        part.unlink()
        raise


def _mode_of(target: pathlib.Path) -> int:
    with contextlib.suppress(FileNotFoundError):
        return stat.S_IMODE(target.stat().st_mode)
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def tail(file: pathlib.Path, lines: int) -> str:
    """The last lines of a file, nothing if there is none."""
    text = read_bytes(file).decode(errors="replace")
    return "".join(f"{line}\n" for line in text.splitlines()[-lines:])


def hash_of(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def hash_of_files(files: Iterable[str]) -> str:
    """A hash of these files and of those that the MuJoCo models among them name (meshes, included models).

    Files that are not there do not count.
    """
    digest = hashlib.sha256()
    known: Set[str] = set()
    for file in files:
        _add(pathlib.Path(file), known, digest)
    return digest.hexdigest()


def _add(file: pathlib.Path, known: Set[str], digest: "hashlib._Hash") -> None:
    path = os.path.realpath(file)
    if not file.is_file() or path in known:
        return
    known.add(path)
    data = file.read_bytes()
    digest.update(len(data).to_bytes(8, "little") + data)
    if file.suffix == ".xml":
        for named in _named_by(file.parent, data.decode(errors="replace")):
            _add(named, known, digest)


def _named_by(folder: pathlib.Path, text: str) -> List[pathlib.Path]:
    """What a MuJoCo model may name by file="…": from its own folder, or from those that <compiler> says."""
    folders = [folder] + [folder / word for word in FOLDER_WORDS.findall(text)]
    return [place / word for word in FILE_WORDS.findall(text) for place in folders]
