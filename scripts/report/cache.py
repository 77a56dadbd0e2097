"""Keeps what is dear to make by a name that its content decides: a wrong or damaged entry only costs making it again."""

import hashlib
import json
import os
import time
from pathlib import Path

KEPT = 30 * 86400  # seconds without use after which an entry is swept
ROOM = 100e6  # bytes of all entries


def checksum(*parts):
    """Of texts and bytes, each set apart from the next."""
    found = hashlib.sha256()
    for part in parts:
        part = part.encode("utf-8", "surrogateescape") if isinstance(part, str) else part
        found.update(len(part).to_bytes(8, "little") + part)
    return found.hexdigest()


def of_files(folder, *suffixes):
    """Checksum of all files of a folder with these endings: of the code that draws."""
    files = sorted(path for path in Path(folder).iterdir() if path.suffix in suffixes)
    return checksum(*(part for path in files for part in (path.name, path.read_bytes())))


def home():
    """The folder of the entries, None where none can be made."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    folder = Path(base, "veriflex", "report")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


class Cache:
    """Values that JSON can hold, by key. Without a folder nothing is kept."""

    def __init__(self, folder):
        self.folder = folder

    def get(self, key):
        """The value, None without a whole one."""
        if self.folder is None:
            return None
        path = self.folder / f"{key}.json"
        try:
            seal, _, body = path.read_text(encoding="utf-8").partition("\n")
            if seal != checksum(body):
                return None
            os.utime(path)
            return json.loads(body)
        except (OSError, ValueError):
            return None

    def put(self, key, value):
        if self.folder is None:
            return
        body = json.dumps(value)
        aside = self.folder / f".{key}.{os.getpid()}"
        try:
            aside.write_text(f"{checksum(body)}\n{body}", encoding="utf-8")
            aside.replace(self.folder / f"{key}.json")
        except OSError:  # a full disk costs the cache, not the report
            aside.unlink(missing_ok=True)

    def sweep(self):
        """Removes what nobody has used for long, and beyond a size what was used longest ago."""
        if self.folder is None:
            return
        entries = []
        for path in self.folder.iterdir():
            try:
                entries.append((path.stat().st_mtime, path.stat().st_size, path))
            except OSError:  # another report has swept it
                pass
        size = 0
        for used, bytes_of_it, path in sorted(entries, reverse=True):
            size += bytes_of_it
            if time.time() - used > KEPT or size > ROOM:
                path.unlink(missing_ok=True)
