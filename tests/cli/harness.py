# SPDX-License-Identifier: MIT
"""Runs the built tool and tells what held, as TAP: one line a check. Python's standard library only."""
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

TOOL = os.path.abspath(sys.argv[1])
SOURCE = os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 else os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.environ.get("PELLUCID_TEST_DATA", "")

checks = 0
failures = 0


def check(good, name, detail=""):
    """One line of TAP."""
    global checks, failures
    checks += 1
    print(("ok" if good else "not ok"), checks, "-", name)
    if not good:
        failures += 1
        for line in str(detail)[:2000].splitlines():
            print("#", line)
    sys.stdout.flush()
    return good


def skip(name, why):
    global checks
    checks += 1
    print("ok", checks, "-", name, "# SKIP", why)


def finish():
    print("1..%d" % checks)
    sys.exit(1 if failures else 0)


class Result:
    def __init__(self, status, out, err, args):
        self.status, self.out, self.err = status, out, err.decode("utf-8", "replace")
        self.text = out.decode("utf-8", "replace")
        self.args = args

    def __str__(self):
        return "%s\nstatus %s\nstdout: %s\nstderr: %s" % (" ".join(map(str, self.args)), self.status, self.text[:500], self.err[:1000])

    def json(self):
        """What was printed, parsed as strictly as a script would: NaN and Infinity are no JSON."""
        def refuse(word):
            raise ValueError(word)
        return json.loads(self.text, parse_constant=refuse)

    def errors(self):
        return [line for line in self.err.splitlines() if not line.startswith("pellucid: note: ")]

    def one_error(self):
        """One line on stderr that begins as it should, beside notes."""
        lines = self.errors()
        return len(lines) == 1 and lines[0].startswith("pellucid: ") and len(lines[0]) > len("pellucid: ")


def run(*args, cwd=None, stdout=subprocess.PIPE, timeout=300, **more):
    words = [TOOL] + [a if isinstance(a, bytes) else str(a) for a in args]
    done = subprocess.run(words, cwd=cwd, stdin=subprocess.DEVNULL, stdout=stdout, stderr=subprocess.PIPE, timeout=timeout, **more)
    return Result(done.returncode, done.stdout or b"", done.stderr, args)


if run("--version").status != 0:
    print("Bail out! %s does not run" % TOOL)
    sys.exit(1)


def fine(name, *args, **more):
    result = run(*args, **more)
    check(result.status == 0, name, result)
    return result


def fails(name, status, fragment, *args, **more):
    """The run must end with this status and one line of error that holds the fragment."""
    result = run(*args, **more)
    check(result.status == status and result.one_error() and fragment in result.err, name, result)
    return result


class Folder:
    """A temporary folder; with Folder() as f: f / "name"."""

    def __enter__(self):
        self.path = tempfile.mkdtemp(prefix="pellucid-cli-")
        return self

    def __exit__(self, *_):
        for base, folders, _ in os.walk(self.path):
            for name in folders:
                os.chmod(os.path.join(base, name), 0o755)
        shutil.rmtree(self.path)

    def __truediv__(self, name):
        return os.path.join(self.path, name)

    def names(self):
        return sorted(os.listdir(self.path))


def read(path):
    with open(path, "rb") as file:
        return file.read()


def write(path, data):
    with open(path, "wb") as file:
        file.write(data if isinstance(data, bytes) else data.encode())
    return path


NRRD_TYPES = {"B": "uint8", "b": "int8", "H": "uint16", "h": "int16", "I": "uint32", "i": "int32", "f": "float", "d": "double"}


def nrrd(path, sizes, code, values, extra=""):
    """A little-endian attached NRRD from numbers; `code` is struct's letter of the type."""
    head = "NRRD0004\ntype: %s\ndimension: %d\nsizes: %s\nendian: little\nencoding: raw\n%s\n" % (
        NRRD_TYPES[code], len(sizes), " ".join(map(str, sizes)), extra + "\n" if extra else "")
    return write(path, head.encode() + struct.pack("<%d%s" % (len(values), code), *values))


def png(data):
    """Width, height, channels and rows of bytes of an 8-bit PNG that is not interlaced."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "no PNG"
    at, packed, width, height, channels = 8, b"", 0, 0, 0
    while True:
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0]
        at += 12 + length
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlace = struct.unpack(">IIBBBBB", body)
            assert depth == 8 and interlace == 0
            channels = {0: 1, 2: 3, 4: 2, 6: 4}[color]
        elif kind == b"IDAT":
            packed += body
        elif kind == b"IEND":
            break
    assert at == len(data), "something after the end"
    raw, stride, rows = zlib.decompress(packed), width * channels, []
    before = bytearray(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride):
            left = row[x - channels] if x >= channels else 0
            up, corner = before[x], before[x - channels] if x >= channels else 0
            if kind == 1:
                row[x] = row[x] + left & 255
            elif kind == 2:
                row[x] = row[x] + up & 255
            elif kind == 3:
                row[x] = row[x] + (left + up) // 2 & 255
            elif kind == 4:
                guess = left + up - corner
                a, b, c = abs(guess - left), abs(guess - up), abs(guess - corner)
                row[x] = row[x] + (left if a <= b and a <= c else up if b <= c else corner) & 255
        rows.append(bytes(row))
        before = row
    return width, height, channels, rows


def colours(path):
    """How many different pixels a picture has: 1 is a blank one."""
    width, _, channels, rows = png(read(path))
    return len({row[x * channels:(x + 1) * channels] for row in rows for x in range(width)})


def options_of(*command):
    """The long options and the facts about them, from the help: {name: (metavar, facts)}."""
    found, name = {}, None
    for line in run(*command, "--help").text.splitlines():
        head = line[:30].strip() if not line.startswith(" " * 30) else ""
        words = line.split()
        if line.startswith("  ") and words and (words[0].startswith("--") or words[0].endswith(",") and len(words) > 1 and words[1].startswith("--")):
            word = words[0] if words[0].startswith("--") else words[1]
            rest = words[words.index(word) + 1] if len(words) > words.index(word) + 1 else ""
            name = word.strip(",").split("[")[0][2:]
            found[name] = [rest if rest.isupper() or "," in rest or "|" in rest or "x" in rest else "", line]
        elif name and head == "" and line.strip():
            found[name][1] += " " + line.strip()
        elif not line.strip():
            name = None
    return found
