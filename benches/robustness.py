#!/usr/bin/env python3
"""What the detector makes of changed pictures: crops, quarter turns, mirror images, inverted greys, gamma, strong JPEG.

  benches/robustness.py PROGRAM FOLDER [--family F]... [--each N] [--seed S] [--truth LINES] [--keep DIR]

PROGRAM is `sextant`; FOLDER holds PNG files of any kind. What must be found in a changed picture is what
`sextant detect --json` says of the picture as it is, or what the LINES of a file of that form say. A mirrored or
inverted tag is no tag: of those nothing must be found (but for families with a white border on black ground, which an
inverted picture may show). Each picture is changed N times (default 5) in every way, all but the first time after a
random crop, too. A tag within a quarter of its edge of the changed picture's border need not be found. Pictures with
false detections are kept in DIR. Needs numpy and OpenCV.

Says for every way: pictures, how often the program failed, tags found of those to be found, and false detections. The
exit code is 1 when the program failed or anything was detected falsely.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

import cv2
import numpy as np


def quarter_turn(picture, turns):
    """The picture turned counter-clockwise, and where its places go."""
    height, width = picture.shape
    place = [
        lambda p: p,
        lambda p: np.stack([p[:, 1], width - 1 - p[:, 0]], 1),
        lambda p: np.stack([width - 1 - p[:, 0], height - 1 - p[:, 1]], 1),
        lambda p: np.stack([height - 1 - p[:, 1], p[:, 0]], 1),
    ][turns]
    return np.rot90(picture, turns), place


def mirrored(picture, _):
    width = picture.shape[1]
    return picture[:, ::-1], lambda p: np.stack([width - 1 - p[:, 0], p[:, 1]], 1)


def with_gamma(picture, random):
    gamma = np.exp(random.uniform(np.log(0.4), np.log(2.5)))
    table = (255 * (np.arange(256) / 255) ** gamma).round().astype(np.uint8)
    return table[picture], lambda p: p


def through_jpeg(picture, _):
    _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 30])
    return cv2.imdecode(data, cv2.IMREAD_GRAYSCALE), lambda p: p


def crop(picture, random):
    height, width = picture.shape
    w, h = (int(random.uniform(min(16 / size, 1.0), 1.0) * size) for size in (width, height))
    w, h = max(w, min(width, 16)), max(h, min(height, 16))
    left, top = random.integers(0, width - w + 1), random.integers(0, height - h + 1)
    return picture[top : top + h, left : left + w], lambda p: p - [left, top]


# The largest picture that the detector takes.
MOST_COLUMNS, MOST_ROWS = 4096, 3072

# Name, the change, whether tags remain tags.
WAYS = [
    ("as it is", lambda picture, _: (picture, lambda p: p), True),
    ("turned by 90", lambda picture, _: quarter_turn(picture, 1), True),
    ("turned by 180", lambda picture, _: quarter_turn(picture, 2), True),
    ("turned by 270", lambda picture, _: quarter_turn(picture, 3), True),
    ("mirrored", mirrored, False),
    ("inverted", lambda picture, _: (255 - picture, lambda p: p), False),
    ("gamma", with_gamma, True),
    ("JPEG 30", through_jpeg, True),
]


def detect(program, families, files):
    """Detections by file; a file that the program says nothing of is absent."""
    command = [program, "detect", "--json", *(x for f in families for x in ("--family", f)), "-"]
    said = subprocess.run(command, input="\n".join(files), stdout=subprocess.PIPE, text=True, check=False)
    lines = [json.loads(line) for line in said.stdout.splitlines() if line.startswith("{")]
    return {line["file"]: line["detections"] for line in lines}


def edge_of(corners):
    return np.linalg.norm(np.roll(corners, -1, 0) - corners, axis=1).mean()


def compare(found, expected, shape):
    """Tags to be found, those found, and false detections."""
    left, wanted, hits = list(found), 0, 0
    for tag in expected:
        corners = tag["corners"]
        margin = edge_of(corners) / 4
        inside = (corners >= margin).all() and (corners <= [shape[1] - 1 - margin, shape[0] - 1 - margin]).all()
        same = [
            d
            for d in left
            if (d["family"], d["id"]) == (tag["family"], tag["id"])
            and np.linalg.norm(np.mean(d["corners"], 0) - corners.mean(0)) < edge_of(corners) / 2
        ]
        if same:
            left.remove(same[0])
        wanted += bool(inside)
        hits += bool(inside and same)
    return wanted, hits, left


def changed(picture, tags, way, time, random):
    """The picture changed, and what it shows then."""
    places = []
    if time > 0:
        picture, place = crop(picture, random)
        places.append(place)
    picture, place = way[1](picture, random)
    places.append(place)
    expected = []
    for tag in tags if way[2] else []:
        corners = np.array(tag["corners"], float)
        for place in places:
            corners = place(corners)
        expected.append({"family": tag["family"], "id": tag["id"], "corners": corners})
    return np.ascontiguousarray(picture), expected


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("folder")
    arguments.add_argument("--family", action="append", default=None)
    arguments.add_argument("--each", type=int, default=5)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--truth")
    arguments.add_argument("--keep")
    chosen = arguments.parse_args()
    families = chosen.family or ["tag36h11"]
    files = sorted(os.path.join(chosen.folder, f) for f in os.listdir(chosen.folder) if f.endswith(".png"))
    if chosen.truth:
        lines = map(json.loads, open(chosen.truth, encoding="utf-8"))
        by_name = {os.path.basename(line["file"]): line["detections"] for line in lines}
        truth = {f: [t for t in by_name.get(os.path.basename(f), []) if t["family"] in families] for f in files}
    else:
        truth = detect(chosen.program, families, files)
    random, wrong = np.random.default_rng(chosen.seed), 0
    for way in WAYS:
        sums = np.zeros(5, int)
        with tempfile.TemporaryDirectory() as folder:
            cases = {}
            for file in files:
                picture = cv2.imread(file, cv2.IMREAD_GRAYSCALE)
                for time in range(chosen.each):
                    made, expected = changed(picture, truth.get(file, []), way, time, random)
                    if made.shape[0] > MOST_ROWS or made.shape[1] > MOST_COLUMNS:
                        continue
                    name = os.path.join(folder, f"{os.path.basename(file)[:-4]}-{time}.png")
                    cv2.imwrite(name, made, [cv2.IMWRITE_PNG_COMPRESSION, 1])
                    cases[name] = (expected, made.shape)
            said = detect(chosen.program, families, list(cases))
            for name, (expected, shape) in cases.items():
                wanted, hits, false = compare(said.get(name, []), expected, shape)
                sums += [1, name not in said, wanted, hits, len(false)]
                for d in false:
                    print(
                        "  false:",
                        os.path.basename(name),
                        d["family"],
                        d["id"],
                        "hamming",
                        d["hamming"],
                        "margin %.1f" % d["margin"],
                        "at %.0f %.0f" % tuple(np.mean(d["corners"], 0)),
                        "edge %.1f" % edge_of(np.array(d["corners"])),
                    )
                if false and chosen.keep:
                    os.makedirs(chosen.keep, exist_ok=True)
                    kept = f"{way[0].replace(' ', '-')}-{os.path.basename(name)}"
                    os.replace(name, os.path.join(chosen.keep, kept))
        wrong += sums[1] + sums[4]
        print("%-14s %5d pictures, %d failed, %d of %d tags (%.1f %%), %d false"
              % (way[0], *sums[:2], sums[3], sums[2], 100 * sums[3] / max(sums[2], 1), sums[4]), flush=True)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
