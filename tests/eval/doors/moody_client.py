# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A solver and extractor that answers well, but for the trial of number 2: moody_client.py MOOD.

Further arguments: started=FILE adds a line to the file with the process's number; poses=FILE
answers with what a results.csv has for the trial; images=FILE adds the image's path to the file.
"""
import csv
import json
import os
import sys
import time

MOOD = sys.argv[1]
GIVEN = dict(argument.split("=", 1) for argument in sys.argv[2:])
EYE = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
GOOD = {"rotation": EYE, "translation_m": [0, 0, 10]}
BAD_TRIAL = 2


def say(answer):
    print(answer if isinstance(answer, str) else json.dumps(answer), flush=True)


def note(key, text):
    if key in GIVEN:
        with open(GIVEN[key], "a", encoding="utf-8") as file:
            file.write(f"{text}\n")


def pose_in_file(trial):
    with open(GIVEN["poses"], encoding="utf-8") as file:
        row = next(row for row in csv.DictReader(file) if row["trial"] == str(trial))
    return {"quaternion": [float(row[key]) for key in ("qw", "qx", "qy", "qz")],
            "translation_m": [float(row[key]) for key in ("tx_m", "ty_m", "tz_m")]}


def answer_badly(question):
    with_id = {"id": question["id"]}
    if MOOD in ("hang", "silent"):
        time.sleep(1000)
    elif MOOD == "crash":
        sys.stdout.write('{"id": ')
        sys.stdout.flush()
        os._exit(3)
    elif MOOD == "garble":
        say("my pose is fine")
    elif MOOD == "huge":
        while True:
            sys.stdout.write("x" * 65536)
    elif MOOD == "stale":
        say({**GOOD, "id": question["id"] - 1})
    elif MOOD == "raise":
        say({**with_id, "status": "raised an error", "reason": "the network is tired"})
    elif MOOD == "none":
        say({**with_id, "status": "no estimate"})
    elif MOOD == "moon":
        say({**with_id, "status": "full moon"})
    elif MOOD == "skewed":
        say({**GOOD, **with_id, "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 2]]})
    elif MOOD == "long":
        say({**with_id, "quaternion": [2, 0, 0, 0], "translation_m": [0, 0, 10]})
    elif MOOD == "stranger":
        say({**GOOD, **with_id, "removed": ["nose"], "observations": [{"feature": "nose"}]})
    elif MOOD == "unsure":
        say({**GOOD, **with_id, "covariance": [[0] * 6] * 6})
    elif MOOD == "abyss":
        say('{"id": ' + 1_000_000 * "[" + 1_000_000 * "]" + "}")
    elif MOOD == "infinite":
        say({**GOOD, **with_id, "translation_m": [0, 0, float("inf")]})


def answer_well(question):
    if question["type"] == "extract":
        note("images", question["image"])
        with open(question["image"], "rb") as file:
            assert file.read(4) == b"\x89PNG"
        return {"id": question["id"],
                "observations": [{"feature": feature["name"], "u": feature["pixel"][0],
                                  "v": feature["pixel"][1]} for feature in question["features"]]}
    answer = pose_in_file(question["trial"]) if "poses" in GIVEN else dict(GOOD)
    if "initial" in question and "poses" not in GIVEN:
        answer = dict(question["initial"])
    return {**answer, "id": question["id"], "removed": question["features"][:1]}


def main():
    note("started", os.getpid())
    print("I am", MOOD, file=sys.stderr, flush=True)
    if MOOD == "late":
        time.sleep(2)
    if MOOD == "still-born":
        sys.exit("there is no network here")
    for line in sys.stdin:
        question = json.loads(line)
        if question["type"] == "hello":
            say({"protocol": 7 if MOOD == "newer" else 1})
        elif question["trial"] == BAD_TRIAL and MOOD not in ("good", "late"):
            answer_badly(question)
        else:
            say(answer_well(question))


main()
