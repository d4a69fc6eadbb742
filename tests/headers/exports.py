#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The shared library exports what the public headers declare, and nothing else.  Usage: exports.py LIBRARY INCLUDE-FOLDER"""
import glob
import os
import re
import subprocess
import sys

library, folder = sys.argv[1:]
table = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
exported = {line.split()[2].split("@")[0] for line in table.splitlines()}
text = ""
for path in glob.glob(os.path.join(folder, "pellucid", "*.h")):
    with open(path, encoding="utf-8") as f:
        text += re.sub(r"/\*.*?\*/", "", f.read(), flags=re.S)
functions = set(re.findall(r"\b(pel_\w+)\(", text)) - set(re.findall(r"static inline [\w ]*?\**(pel_\w+)\(", text))
data = set(re.findall(r"extern const [\w ]*?\**(pel_\w+)\[\]", text))
extra, missing = exported - functions - data, (functions | data) - exported
for name in sorted(extra):
    print("exported, but in no public header: " + name)
for name in sorted(missing):
    print("declared, but not exported: " + name)
sys.exit(1 if extra or missing or not functions else 0)
