#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes docs/gallery.md and its pictures with the program: `./dev docs --gallery`.

    make.py PROGRAM

Each target is drawn by `sightline target --picture`; of each study with images stand four of
the first that `sightline render` makes of it.
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

HERE = Path(__file__).resolve().parent
TARGET_PX = (420, 280)
FRAME_PX = 190
FRAMES = range(0, 12, 3)  # conditions of a draw follow each other, and are often alike
ZOOM = 0.9
QUALITY = [cv2.IMWRITE_JPEG_QUALITY, 72]  # noise makes PNG four times as large

HEAD = """<!-- SPDX-FileCopyrightText: 2026 The Sightline authors -->
<!-- SPDX-License-Identifier: GPL-3.0-or-later -->

# Gallery

What comes with the program, drawn by it (`./dev docs --gallery` makes this page anew).
`sightline list NAME` says all about one of them.
"""


def sightline(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"sightline {' '.join(arguments)}: {done.stderr}")
    return done.stdout


def target_picture(program, name, folder):
    """A picture without noise, shrunk."""
    sightline(program, "target", name, "--picture", str(folder / "target.png"))
    image = cv2.imread(str(folder / "target.png"), cv2.IMREAD_UNCHANGED)
    cv2.imwrite(str(HERE / f"{name}.jpg"), cv2.resize(image, TARGET_PX, interpolation=cv2.INTER_AREA), QUALITY)


def frames(program, name, folder):
    """The study's first images side by side, each cut to its middle square; None of a numeric study."""
    out = folder / name
    done = subprocess.run([program, "render", name, "--count", str(FRAMES[-1] + 1), "--out", str(out), "--quiet"],
                          capture_output=True, text=True)
    if "renders nothing" in done.stderr:
        return None
    if done.returncode != 0:
        sys.exit(f"sightline render {name}: {done.stderr}")
    files = sorted(out.glob("test/*/rgb/*.png")) or sorted(out.glob("test/*/gray/*.png"))
    squares = []
    for i in FRAMES:
        image = cv2.imread(str(files[i]), cv2.IMREAD_COLOR)
        side = int(ZOOM * min(image.shape[:2]))
        top, left = (image.shape[0] - side) // 2, (image.shape[1] - side) // 2
        square = image[top:top + side, left:left + side]
        squares.append(cv2.resize(square, (FRAME_PX, FRAME_PX), interpolation=cv2.INTER_AREA))
    gap = np.full((FRAME_PX, 6, 3), 255, np.uint8)
    row = [part for square in squares for part in (square, gap)][:-1]
    cv2.imwrite(str(HERE / f"{name}.jpg"), np.hstack(row), QUALITY)
    return f"gallery/{name}.jpg"


def main():
    program = sys.argv[1]
    lists = json.loads(sightline(program, "list", "--json"))
    page = HEAD + "\n## Targets\n"
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for target in lists["targets"]:
            name = target["name"]
            target_picture(program, name, folder)
            page += f"\n### {name}\n\n{target['text']}\n\n![The target {name}](gallery/{name}.jpg)\n"
        page += ("\n## Studies\n\nOf those with images four of the first, as the extractors get them, each "
                 "cut to its middle.\n")
        numeric = ""
        for study in lists["studies"]:
            name, question = study["name"], study["text"]
            picture = frames(program, name, folder)
            if picture is None:
                numeric += f"| `sightline study {name}` | {question} |\n"
                continue
            page += f"\n### {name}\n\n{question}\n\n![Four images of the study {name}]({picture})\n"
    page += ("\n### Without images\n\nThese begin at exact projections, or at points in two frames, and add "
             "noise and outliers.\n\n| command | question |\n|---|---|\n" + numeric)
    (HERE.parent / "gallery.md").write_text(page)


if __name__ == "__main__":
    main()
