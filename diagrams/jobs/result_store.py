"""A folder of results, each in a file of its own.

Whenever the program is killed, each file is complete or isn't there. A file
that was damaged later is removed, and a note says so.
"""

import glob
import hashlib
import json
import os
from pathlib import Path
import uuid

from pbpf_drake.diagrams.jobs.job_key import JobKey


def key_digest(key: JobKey) -> str:
    """Returns a name for what a result depends on.

    Args:
        key: what JSON can hold.
    """
    text = json.dumps(key, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:20]


def write_atomically(path: Path, data: bytes) -> None:
    """Writes a file, so that nobody ever finds a part of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    # Not by tempfile, whose files nobody else may read.
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex}.part")
    try:
        with open(part, "xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


class ResultStore:
    """Files by key.

    Attributes:
        notes: a sentence for every file that was found damaged.
    """

    def __init__(self, folder: Path, *, suffix: str):
        """Takes the folder, which is made when it is needed.

        Args:
            folder: holds this store's files only.
            suffix: of all files, with its dot.
        """
        self._folder = folder
        self._suffix = suffix
        self.notes: list[str] = []

    def Load(self, name: str, key: JobKey) -> bytes | None:
        """Returns what was stored, or None.

        Args:
            name: the readable part of the file's name.
            key: what the result depends on.
        """
        for path in sorted(self._folder.glob(self._pattern(name, key))):
            data = path.read_bytes()
            if path.stem.endswith(_content_digest(data)):
                return data
            self.notes.append(f"{path} is damaged; it is made again")
            path.unlink()
        return None

    def Save(self, name: str, key: JobKey, data: bytes) -> Path:
        """Stores something at once; returns its file."""
        stem = f"{name}-{key_digest(key)}-{_content_digest(data)}"
        path = self._folder / (stem + self._suffix)
        write_atomically(path, data)
        return path

    def _pattern(self, name: str, key: JobKey) -> str:
        return glob.escape(f"{name}-{key_digest(key)}-") + f"*{self._suffix}"


def _content_digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:12]
