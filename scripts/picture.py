#!/usr/bin/python3
"""The pictures of README and docs, from a page that `make verify` wrote: the first screen, its filament, its three panels.

    scripts/picture.py build/release/results/report.html docs/pictures

Needs chromium, which nothing else here does but scripts/check-page.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageChops

COLOURS = 200
# Name, size of the window, and what is shown alone; without it the page as it opens, in a window in which the first screen is the answer.
PICTURES = (
    ("report", (1280, 900), ""),
    ("filament", (640, 600), ".answer figure"),
    ("panels", (1080, 600), ".panels"),
)
STYLE = "<style>body { display: block; padding: 8px; } .panels { border: 0; margin: 0; } .enlarge { display: none; }</style></head>"
ALONE = '<script>document.body.replaceChildren(document.querySelector("%s"));</script></body>'


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("page", type=Path, help="report.html")
    parser.add_argument("pictures", type=Path, help="the folder to write to")
    options = parser.parse_args()
    page = options.page.read_text("utf-8")
    options.pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, size, part in PICTURES:
            shown, shot = Path(folder, f"{name}.html"), Path(folder, f"{name}.png")
            shown.write_text(page.replace("</head>", STYLE).replace("</body>", ALONE % part) if part else page, "utf-8")
            window = "--window-size={},{}".format(*size)
            words = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--screenshot={shot}", window]
            subprocess.run([*words, shown.as_uri()], check=True, stderr=subprocess.DEVNULL)
            picture = Image.open(shot).convert("RGB")
            if part:
                left, top, right, bottom = ImageChops.invert(picture).getbbox()
                picture = picture.crop((max(left - 8, 0), max(top - 8, 0), min(right + 8, size[0]), min(bottom + 8, size[1])))
            picture.quantize(COLOURS).save(options.pictures / f"{name}.png", optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
