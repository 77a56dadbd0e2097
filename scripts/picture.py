#!/usr/bin/python3
"""The picture of the report's first screen in the README, from a page that `make verify` wrote.

    scripts/picture.py build/release/results/report.html docs/pictures/report.png

Needs chromium, which nothing else here does.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

SIZE = 1280, 900  # of a window in which the first screen is the answer
COLOURS = 200


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("page", type=Path, help="report.html")
    parser.add_argument("picture", type=Path, help="the PNG file to write")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        shot = Path(folder, "shot.png")
        window = "--window-size={},{}".format(*SIZE)
        words = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--screenshot={shot}", window]
        subprocess.run([*words, options.page.resolve().as_uri()], check=True, stderr=subprocess.DEVNULL)
        options.picture.parent.mkdir(parents=True, exist_ok=True)
        Image.open(shot).convert("RGB").quantize(COLOURS).save(options.picture, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
