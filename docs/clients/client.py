#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The smallest solver and extractor that Sightline can ask: the protocol of docs/external.md.

    sightline study boeing-random --solver mine='python3 docs/clients/client.py'

Put your own code into solve() and extract(). Print to standard error only: it goes to a log.
"""
import json
import sys


def solve(question):
    """A pose from question["points_m"] and question["pixels"]: here merely where to start."""
    if "initial" not in question:
        return {"status": "no estimate", "reason": "there is no initial pose"}
    return {"rotation": question["initial"]["rotation"],
            "translation_m": question["initial"]["translation_m"],
            "removed": []}


def extract(question):
    """The features in the file question["image"]: here merely where they are predicted."""
    found = [{"feature": feature["name"], "u": feature["pixel"][0], "v": feature["pixel"][1],
              "covariance_px2": feature["covariance_px2"]}
             for feature in question["features"] if "pixel" in feature and not feature["is_hidden"]]
    return {"observations": found}


def main():
    for line in sys.stdin:
        question = json.loads(line)
        if question["type"] == "hello":
            answer = {"protocol": 1}
        else:
            answer = {"solve": solve, "extract": extract}[question["type"]](question)
            answer["id"] = question["id"]
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
