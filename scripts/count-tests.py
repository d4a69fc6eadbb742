#!/usr/bin/env python3
"""Adds up what meson's test logs say: one line, `N passed, N failed, N skipped`. A cmocka program, and one that speaks TAP, counts with each of
its tests, any other program as one. Exit status 1 where something failed or nothing ran."""
import json
import re
import sys

SUMMARY = {"passed": "PASSED", "failed": "FAILED", "skipped": "SKIPPED"}


def said(text):
    """What a program says of its own tests, in cmocka's words or in TAP; all zero where it says nothing."""
    if re.search(r"^1\.\.\d+", text, re.M):
        found = dict.fromkeys(SUMMARY, 0)
        for bad, rest in re.findall(r"^(not )?ok\b(.*)$", text, re.M):
            found["skipped" if re.search(r"#\s*skip", rest, re.I) else "failed" if bad else "passed"] += 1
        return found
    # cmocka closes each group with "[  PASSED  ] 12 test(s)." and the like.
    return {k: sum(int(n) for n in re.findall(r"\[  %s ?\s*\] (\d+) test\(s\)" % word, text)) for k, word in SUMMARY.items()}


def count(entry):
    """(passed, failed, skipped) of one meson test."""
    text = (entry.get("stdout") or "") + "\n" + (entry.get("stderr") or "")
    result = entry["result"]
    good = result in ("OK", "EXPECTEDFAIL")
    if result == "SKIP":
        return 0, 0, 1
    found = said(text)
    if not any(found.values()):
        return (1, 0, 0) if good else (0, 1, 0)
    # A crash, a sanitizer's report or a time limit fails the program whatever its tests had said by then.
    if not good and not found["failed"]:
        found["failed"] = 1
    return found["passed"], found["failed"], found["skipped"]


def main(paths):
    total = [0, 0, 0]
    for path in paths:
        with open(path, encoding="utf-8") as log:
            for line in log:
                total = [a + b for a, b in zip(total, count(json.loads(line)))]
    print("%d passed, %d failed, %d skipped" % tuple(total))
    return 1 if total[1] or not total[0] else 0


sys.exit(main(sys.argv[1:]))
