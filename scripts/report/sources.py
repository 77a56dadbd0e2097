"""What results cite: the works of the bibliography, and the files of the source tree that a case comes from."""

import os
import re
import unicodedata
from functools import cache
from pathlib import Path
from urllib.parse import quote

from markupsafe import Markup, escape

ROOT = Path(__file__).parents[2]  # of the source tree, or of what was installed
ACCENTS = {"'": "\u0301", "`": "\u0300", '"': "\u0308", "^": "\u0302", "~": "\u0303", "v": "\u030c", "c": "\u0327"}
WHERE = ("journal", "booktitle", "publisher", "school", "volume", "number", "pages", "note")


def plain(text):
    """Text of a BibTeX field as people write it."""
    text = re.sub(r"\\(['`\"^~]|[vc](?=\{))\{?(\w)\}?", lambda found: found.group(2) + ACCENTS[found.group(1)], text)
    text = re.sub(r"[{}]|\\(?=&)", "", text).replace("--", "–")
    return unicodedata.normalize("NFC", text)


@cache
def bibliography():
    """Fields of each work by its key; empty where there is no bibliography."""
    try:
        entries = (ROOT / "reference/bibliography.bib").read_text("utf-8").split("\n@")[1:]
    except OSError:
        return {}
    return {
        entry.partition("{")[2].partition(",")[0]: {key: plain(value) for key, value in re.findall(r"(\w+)\s*=\s*\{(.*)\},?\n", entry)}
        for entry in entries
    }


def cited(key):
    """A work in words; its key where the bibliography does not hold it."""
    fields = bibliography().get(key, {})
    return f"{fields['author']} ({fields['year']}). {fields['title']}" if {"author", "year", "title"} <= fields.keys() else key


def in_full(key):
    """A work with where it appeared."""
    fields = bibliography()[key]
    return ". ".join([cited(key), ", ".join(fields[name] for name in WHERE if name in fields)]).removesuffix(". ") + "."


def split(text):
    """Text, key of a work, text, ...; what looks like a key need not be one."""
    return re.split(r"(?<![\w-])([a-z][a-z0-9-]*-\d{4}(?:-[a-z]+)?)(?![\w-])", str(text))


def linked(text):
    """Text whose keys of works lead to the list of them."""
    parts, known = split(text), bibliography()
    link = Markup('<a href="#source-{0}">{0}</a>').format
    return Markup("").join(link(part) if index % 2 and part in known else escape(part) for index, part in enumerate(parts))


def works(results, benchmarks):
    """Keys and words of the works that results and ledger cite, by key."""
    texts = [entry["where"] for entry in benchmarks]
    for result in results:
        texts += [*result.sources, *(text for check in result.checks for text in (check.source, check.reference))]
        texts += [text for reference in result.references for text in (reference.source, reference.obtained)]
    keys = {key for text in texts for key in split(text)[1::2]} & bibliography().keys()
    return [(key, in_full(key)) for key in sorted(keys)]


def address(name, out):
    """Where a file of the source tree stands, from the page."""
    return quote(os.path.relpath(ROOT / name, Path(out).resolve().parent))


def files_of(result, out):
    """Files of the source tree that the case comes from: (what, name, address from the page)."""
    names = [("case", f"cases/{result.case_id}.toml")]
    stem = result.driver.replace("-", "_")
    names += [("driver", str(path.relative_to(ROOT))) for path in sorted((ROOT / "verify/measures").glob(f"*/{stem}.cpp"))]
    names += [("reference", f"reference/{reference.id}.toml") for reference in result.references]
    return [(what, name, address(name, out)) for what, name in names if (ROOT / name).is_file()]


def reference_link(name, out):
    """A reference by its name, as a link to its file where that is there."""
    file = f"reference/{name}.toml"
    return Markup('<a href="{}">{}</a>').format(address(file, out), name) if (ROOT / file).is_file() else name
