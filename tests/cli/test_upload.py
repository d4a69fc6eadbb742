# SPDX-License-Identifier: MIT
"""pellucid view: files that a page sends, alone and together; what is refused of them, what is kept, and that nothing is left behind."""
import http.client
import json
import os
import signal
import socket
import struct
import time

import harness as h
from websocket import Socket, Viewer

MOST_FILES = 4096


def send(viewer, name, body, folder=None):
    """Status, and the answer."""
    where = "/%s/upload?name=%s" % (viewer.token, name) + ("" if folder is None else "&folder=%s" % folder)
    status, _, answer = viewer.request("POST", where, body=body)
    try:
        return status, json.loads(answer)
    except ValueError:
        return status, {}


def opened(client, path):
    """The event that tells of it, or the error. (A volume is told of a second time, with its histogram.)"""
    client.command("open", path=path)
    return client.until(lambda m: m.get("event") == "error" or (m.get("event") == "volume" and m["path"] == path))


def alone(viewer, client, data):
    """One file. Gives its path and the server's folder."""
    status, answer = send(viewer, "another%20one.nrrd", data)
    h.check(status == 200, "an upload", (status, answer))
    path = answer["path"]
    h.check(os.path.basename(path) == "another one.nrrd", "keeps its name", path)
    h.check(opened(client, path).get("path") == path, "and is opened")
    offered = client.answer(client.command("scene"), "download")
    scene = json.loads(viewer.get(offered["url"])[2])
    h.check(scene["volume"]["path"] == "another one.nrrd", "a scene of it names the user's file", scene["volume"])
    for name in ("", "..", ".hidden", "a%22b", "%0a", "%ff.nrrd"):
        h.check(send(viewer, name, b"x")[0] in (400, 403), "no file is called %r" % name)
    status, answer = send(viewer, "..%2f..%2fx.nrrd", data)
    base = os.path.dirname(os.path.dirname(path))
    h.check(status == 200 and os.path.dirname(os.path.dirname(answer["path"])) == base, "nor goes elsewhere", answer)
    status, answer = send(viewer, "large.nrrd", b"x" * 2000001)
    h.check(status == 413 and "--max-upload" in answer["error"], "what is too large is refused", (status, answer))
    return path, base


def many(viewer, client, data, first):
    """The oldest go, but for what is open; and few come at once."""
    paths = [send(viewer, "%d.nrrd" % i, data)[1]["path"] for i in range(20)]
    kept = [path for path in paths if os.path.exists(path)]
    h.check(0 < len(kept) < 10 and kept == paths[-len(kept):], "not every upload is kept", kept)
    h.check(os.path.exists(first), "what is open is")
    h.check(opened(client, paths[-1]).get("path") == paths[-1], "the last can be opened")
    client.command("open", path=paths[0])
    h.check("opened" in client.event("error")["message"], "the first no more")
    client.answer(client.command("list"), "files")
    h.check(paths[0] not in str(client.events[-1]) and paths[-1] in str(client.events[-1]), "nor is it listed", client.events[-1])
    busy = [socket.create_connection((viewer.host, viewer.port)) for _ in range(6)]
    for plain in busy:
        plain.sendall(b"POST /%s/upload?name=a.nrrd HTTP/1.1\r\nHost: %s\r\nContent-Length: 100000\r\n\r\nabc" % (viewer.token.encode(), viewer.authority.encode()))
    time.sleep(0.5)
    status, answer = send(viewer, "b.nrrd", data)
    h.check(status == 503 and "already" in answer["error"], "a file beside many others waits", (status, answer))
    for plain in busy:
        plain.close()
    for _ in range(100):
        status, answer = send(viewer, "b.nrrd", data)
        if status == 200:
            break
        time.sleep(0.1)
    h.check(status == 200, "until these are done", (status, answer))


HEADERS = (("pair.nhdr", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\ndata file: %s\n"),
           ("pair.mhd", "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\nElementDataFile = %s\n"))
NUMBERS = bytes(range(24))


def analyze():
    """A header of 4 x 3 x 2 bytes, whose samples are beside it in a file .img."""
    header = bytearray(348)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, 4, 3, 2, 1, 1, 1, 1)
    struct.pack_into("<hh", header, 70, 2, 8)
    struct.pack_into("<4f", header, 76, 1, 1, 1, 1)
    return bytes(header)


def tiff(first):
    tags = ((256, 4), (257, 3), (258, 8), (259, 1), (262, 1), (273, 8), (277, 1), (278, 3), (279, 12))
    data = b"II*\0" + struct.pack("<I", 20) + bytes(range(first, first + 12)) + struct.pack("<H", len(tags))
    return data + b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags) + bytes(4)


def together(viewer, client):
    """Files of one folder of the server: a header and its data, a series."""
    for name, text in HEADERS:
        for order in (0, 1):
            pair = [(name, (text % "pair.raw").encode()), ("pair.raw", NUMBERS)]
            first = send(viewer, *pair[order])[1]
            second = send(viewer, *pair[1 - order], folder=first["folder"])[1]
            h.check(os.path.dirname(first["path"]) == os.path.dirname(second["path"]) and first["folder"] == second["folder"], "a pair lies together", (first, second))
            event = opened(client, (first, second)[order]["path"])
            h.check(event.get("range") == [0, 23], "%s and its data are opened, whichever comes first" % name, event)
    for one, other in (("pair.hdr", "pair.img"), ("pair.img", "pair.hdr")):
        body = {"pair.hdr": analyze(), "pair.img": NUMBERS}
        first = send(viewer, one, body[one])[1]
        send(viewer, other, body[other], first["folder"])
        event = opened(client, os.path.join(os.path.dirname(first["path"]), "pair.hdr"))
        h.check(event.get("range") == [0, 23], "so are .hdr and .img", event)
    listed = client.answer(client.command("list"), "files")
    names = [entry["name"] for entry in listed["entries"]]
    h.check("pair.hdr" in names and "pair.raw" not in names, "listed is what opens them", names)
    folder = send(viewer, "0.tif", tiff(0))[1]
    for i in (1, 2):
        send(viewer, "%d.tif" % i, tiff(i), folder["folder"])
    whole = os.path.dirname(folder["path"])
    event = opened(client, whole)
    h.check(event.get("dims") == [4, 3, 3], "slices are opened as a volume", event)
    listed = client.answer(client.command("list"), "files")
    h.check([entry["path"] for entry in listed["entries"] if entry["series"] and entry["path"] == whole] == [whole], "and listed as one", listed)


def foreign(viewer, client, folder):
    """A header that was sent names what was sent with it, and nothing else: not even what the page may open by itself."""
    secret = h.write(folder / "secret.raw", NUMBERS)
    inside = h.write(os.path.join(folder / "inside", "inside.raw"), NUMBERS)
    for name, text in HEADERS:
        for data in (secret, inside, "%s", "../%s", "/etc/passwd"):
            other = send(viewer, "other.raw", NUMBERS)[1]["path"]
            if "%" in data:
                data %= other if data == "%s" else os.path.join(os.path.basename(os.path.dirname(other)), "other.raw")
            first = send(viewer, name, (text % data).encode())[1]
            send(viewer, "mine.raw", NUMBERS, first["folder"])
            event = opened(client, first["path"])
            h.check(event["event"] == "error" and "opened" in event["message"] and os.path.exists(other), "%s names %s in vain" % (name, data[-16:]), event)
        mine = send(viewer, "mine.raw", NUMBERS)[1]
        first = send(viewer, name, (text % mine["path"]).encode(), mine["folder"])[1]
        h.check(opened(client, first["path"]).get("range") == [0, 23], "what was sent with %s is opened by its whole path, too" % name)
    linked = os.path.join(folder / "inside", "linked.hdr")
    h.write(linked, analyze())
    os.symlink(secret, os.path.join(folder / "inside", "linked.img"))
    event = opened(client, linked)
    h.check(event["event"] == "error" and "may be opened" in event["message"], "nor does the data of a pair that is a link to elsewhere open", event)


def refusals(viewer, base):
    first = send(viewer, "a.nrrd", b"abc")[1]
    status, answer = send(viewer, "a.nrrd", b"other", first["folder"])
    h.check(status == 409 and "name" in answer["error"] and h.read(first["path"]) == b"abc", "nothing is written over", (status, answer))
    for wrong in ("0", "-1", "", "x", "1x", "99999", str(first["folder"]) + "%2f..", "..", "18446744073709551617", "1" * 40):
        before = sorted(os.listdir(base))
        status, answer = send(viewer, "b.nrrd", b"abc", wrong)
        h.check(status == 404 and "again" in answer["error"] and sorted(os.listdir(base)) == before, "there is no folder %r" % wrong, (status, answer))
    for name in ("..", ".hidden", "a%22b"):
        h.check(send(viewer, name, b"x", first["folder"])[0] == 400, "no file is called %r there" % name)
    h.check(send(viewer, "b.raw", b"x" * 1999000, first["folder"])[0] == 200, "files up to the limit")
    status, answer = send(viewer, "c.raw", b"x" * 2000, first["folder"])
    h.check(status == 413 and "together" in answer["error"] and "--max-upload" in answer["error"], "and none beyond it, together", (status, answer))
    h.check(send(viewer, "c.raw", b"x" * 900, first["folder"])[0] == 200, "a smaller one still")
    h.check(sorted(os.listdir(os.path.dirname(first["path"]))) == ["a.nrrd", "b.raw", "c.raw"], "what was refused left nothing")
    h.check(send(viewer, "empty.raw", b"", first["folder"])[0] == 200, "an empty file is one")


def cut_off(viewer, base):
    """A connection that ends in the middle leaves no file, and takes none of the room."""
    before = sorted(os.listdir(base))
    first = send(viewer, "a.nrrd", b"abc")[1]
    for where in ("", "&folder=%d" % first["folder"]):
        plain = socket.create_connection((viewer.host, viewer.port))
        plain.sendall(b"POST /%s/upload?name=b.raw%s HTTP/1.1\r\nHost: %s\r\nContent-Length: 1999000\r\n\r\nabc"
                      % (viewer.token.encode(), where.encode(), viewer.authority.encode()))
        time.sleep(0.3)
        plain.close()
    folder = os.path.dirname(first["path"])
    for _ in range(100):
        left = sorted(os.listdir(folder)), len(set(os.listdir(base)) - set(before))
        if left == (["a.nrrd"], 1):
            break
        time.sleep(0.1)
    h.check(left == (["a.nrrd"], 1), "what was cut off is removed", left)
    h.check(send(viewer, "b.raw", b"x" * 1999000, first["folder"])[0] == 200, "and can be sent again")


def too_many(viewer):
    connection = http.client.HTTPConnection(viewer.host, viewer.port, timeout=60)
    where, count = "/%s/upload?name=%%d.dcm" % viewer.token, 0
    folder = ""
    while True:
        connection.request("POST", (where % count) + folder, body=b"x")
        answer = connection.getresponse()
        told = json.loads(answer.read())
        if answer.status != 200 or count > MOST_FILES:
            break
        folder = "&folder=%d" % told["folder"]
        count += 1
    connection.close()
    h.check(answer.status == 413 and count == MOST_FILES and "files" in told["error"], "%d files at once, and no more" % MOST_FILES, (answer.status, count, told))


with h.Folder() as folder:
    os.mkdir(folder / "inside")
    os.mkdir(folder / "temporary")
    volume = folder / "small.nrrd"
    h.fine("a volume to view", "make", "marschner-lobb", "--size", "24", "-o", volume)
    env = dict(os.environ, TMPDIR=folder / "temporary")
    with Viewer(h.TOOL, volume, folder / "inside", "--max-upload", "2", env=env) as viewer:
        client = Socket(viewer)
        client.hello()
        data = h.read(volume)
        path, base = alone(viewer, client, data)
        many(viewer, client, data, path)
        together(viewer, client)
        foreign(viewer, client, folder)
        refusals(viewer, base)
        cut_off(viewer, base)
        too_many(viewer)
        client = Socket(viewer) # the other one, which said nothing meanwhile, may have been shown out
        client.hello()
        number = client.command("rotate", by=[0.1, 0])
        h.check(client.frame(number, lossless=True)["picture"][:4] == b"\x89PNG", "the page goes on")
        half = socket.create_connection((viewer.host, viewer.port))
        half.sendall(b"POST /%s/upload?name=b.raw HTTP/1.1\r\nHost: %s\r\nContent-Length: 1000\r\n\r\nabc" % (viewer.token.encode(), viewer.authority.encode()))
        time.sleep(0.3)
        h.check(os.path.isdir(base), "uploads are in a folder of their own")
        h.check(viewer.stop(signal.SIGINT) == 0 and viewer.error == "", "Ctrl-C ends it without a word", viewer.error)
        half.close()
    h.check(os.listdir(folder / "temporary") == [], "and all that was sent is removed", os.listdir(folder / "temporary"))
h.finish()
