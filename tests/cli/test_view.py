# SPDX-License-Identifier: MIT
"""pellucid view and replay, from outside: what a page gets, and what nobody gets who should not."""
import http.client
import json
import os
import resource
import signal
import socket
import struct
import subprocess
import sys
import time

import harness as h
from websocket import Closed, Socket, Viewer

with open(h.TOOL, "rb") as tool:
    KEPT = 300e6 if b"__asan_init" in tool.read() else 0  # bytes: the address sanitizer holds back what is freed


def still_fine(viewer, client, name):
    """The other client sees what it asks for."""
    number = client.command("rotate", by=[0.01, 0])
    try:
        h.check(client.frame(number, lossless=True)["picture"][:4] == b"\x89PNG" and viewer.alive(), name)
    except (Closed, OSError) as error:
        h.check(False, name, repr(error))


def page(viewer):
    status, headers, body = viewer.get()
    h.check(status == 200 and b"<html" in body and headers["content-type"].startswith("text/html"), "the page", status)
    h.check("default-src 'self'" in headers.get("content-security-policy", ""), "a content security policy", headers)
    h.check(headers.get("x-content-type-options") == "nosniff" and headers.get("cache-control") == "no-store", "nothing guessed, nothing kept", headers)
    for name, kind in (("main.js", "text/javascript"), ("style.css", "text/css"), ("icon.svg", "image/svg+xml")):
        status, headers, body = viewer.get(name)
        h.check(status == 200 and headers["content-type"].startswith(kind) and len(body) == int(headers["content-length"]), name, headers)
    status, headers, _ = viewer.request("GET", "/" + viewer.token)
    h.check(status == 301 and headers["location"].endswith("/%s/" % viewer.token), "the slash is put behind the token", headers)
    for name in ("no.js", "../main.js", "%2e%2e/main.js", "..%2fmain.js", ".hidden", "a/b", "download/1", "download/x", "download/", "%252e%252e/main.js", "..%5cmain.js", "/etc/passwd", "%2fetc%2fpasswd",
                 "main.js%00.css", "download/-1", "download/99999999999999999999", "x" * 3000):
        try:
            status, _, _ = viewer.get(name)
        except http.client.RemoteDisconnected:
            status = "closed" # what is no address of HTTP at all
        h.check(status in ("closed", 400, 403, 404, 414, 431), "there is no %.20s" % name, status)
    h.check(viewer.get("main.js")[0] == 200, "and what there is, is there still")


def refusals(viewer):
    wrong = "0" * len(viewer.token)
    for path in ("/", "/main.js", "/%s/" % wrong, "/%s/main.js" % wrong, "/%s" % viewer.token[:-1], "/%sx/" % viewer.token, "/?token=" + viewer.token):
        status, _, body = viewer.request("GET", path)
        h.check(status == 403 and len(body) < 300 and b"ellucid" not in body and b"script" not in body, "403 for %s" % path[:8], (status, body))
    for host in ("evil.example", "evil.example:%d" % viewer.port, "127.0.0.1:1", "127.0.0.1", "localhost.evil:%d" % viewer.port, ""):
        status, _, _ = viewer.get(headers={"Host": host})
        h.check(status in (400, 403), "403 for the host %r" % host, status)
    for path in ("/%s/upload?name=a.nrrd" % wrong, "/upload?name=a.nrrd", "/upload?name=a.nrrd&token=" + viewer.token):
        h.check(viewer.request("POST", path, body=b"x")[0] == 403, "no upload without the token: %.12s" % path)
    for path in ("/%s/download/1" % wrong, "/download/1"):
        h.check(viewer.request("GET", path)[0] == 403, "no download without the token: %.12s" % path)
    h.check(viewer.request("POST", "/%s/upload?name=a.nrrd" % viewer.token, body=b"x", headers={"Host": "evil.example"})[0] == 403, "no upload by another name")
    h.check(viewer.get("download/1", headers={"Host": "evil.example"})[0] == 403, "no download by another name")
    h.check(viewer.get(headers={"Host": "localhost:%d" % viewer.port})[0] == 200, "localhost is a name of this server")
    upload = "/%s/upload?name=a.nrrd" % viewer.token
    for origin in ("http://evil.example", "null", "https://" + viewer.authority, "http://127.0.0.1:1"):
        h.check(viewer.request("POST", upload, body=b"x", headers={"Origin": origin})[0] == 403, "no upload from %s" % origin)
        h.check(Socket(viewer, origin=origin).status == 403, "no socket from %s" % origin)
    h.check(Socket(viewer, token=wrong).status == 403, "no socket with another token")
    h.check(Socket(viewer, token="").status == 403, "no socket without a token")
    h.check(Socket(viewer, host="evil.example:%d" % viewer.port).status == 403, "no socket by another name")
    h.check(Socket(viewer, protocol="").status == 403, "no socket without the protocol's name")
    h.check(Socket(viewer, protocol="chat").status == 403, "no socket of another protocol")
    for method in ("PUT", "DELETE"):
        h.check(viewer.request(method, "/%s/main.js" % viewer.token)[0] in (400, 403, 405), "no " + method)
    h.check(viewer.request("POST", "/%s/main.js" % viewer.token, body=b"x")[0] == 405, "nothing is posted to a file")


def session(viewer):
    with_origin, without = Socket(viewer), Socket(viewer, origin=None)
    h.check(with_origin.status == 101 and without.status == 101, "sockets of the page, and of a program that is none")
    a, b = with_origin, without
    hello = a.answer(a.hello(), "hello")
    h.check(hello["event"] == "hello" and len(hello["techniques"]) > 2, "hello")
    first = a.frame(lossless=True)
    h.check(first["header"]["of"] == [96, 64] and first["header"]["type"] == "image/png" and h.png(first["picture"])[:2] == (96, 64), "a picture at rest",
            first["header"])
    b.hello()
    same = b.frame(lossless=True)
    h.check(same["picture"] == first["picture"], "two clients see the same")
    a.command("hold")
    number = a.command("rotate", by=[0.2, 0.1], gesture=1)
    h.check(a.frame(number)["header"]["quality"] == "moving", "a moving picture under a hand")
    a.command("release")
    turned = a.frame(number, lossless=True)
    h.check(turned["picture"] != first["picture"], "a turn changes the picture")
    number = a.command("undo")
    h.check(a.frame(number, lossless=True)["picture"] == first["picture"], "undo gives it back, byte for byte")
    picture = a.answer(a.command("picture", size=[200, 100], background=True), "download")
    status, headers, body = viewer.get(picture["url"])
    h.check(status == 200 and headers["content-type"] == "image/png" and "attachment" in headers["content-disposition"] and h.png(body)[:2] == (200, 100),
            "a picture to save", headers)
    a.command("slices", at=[0, 0, 0], size=[64, 64])
    h.check(a.frame(view="slice-k", lossless=True)["header"]["camera"]["parallel"] is True, "slices")
    a.command("slices", at=None)
    return a, b


def devices_known(viewer):
    """What `hello` tells once devices are listed, which takes a moment; where there is but the CPU it never tells more."""
    for _ in range(60):
        asker = Socket(viewer)
        asker.hello()
        told = asker.event("hello")
        asker.close()
        if len(told["devices"]) > 1:
            break
        time.sleep(0.25)
    return told


def devices(viewer, client):
    told = devices_known(viewer)
    rows = told["devices"]
    h.check(rows[0]["id"] == "cpu" and told["device"]["id"] in [row["id"] for row in rows], "the devices", told)
    client.command("device", device="cpu")
    before = client.frame(client.command("rotate", by=[0, 0]), lossless=True)
    for row in rows[1:]:
        client.answer_or_event(client.command("device", device=row["id"]), "devices")
        frame = client.frame(client.command("rotate", by=[0, 0]), lossless=True)
        h.check(frame["header"]["device"].startswith(row["name"][:8]), "drawn on " + row["id"], frame["header"])
    number = client.command("device", device="gpu:%d" % 999)
    error = client.answer(number, "none")
    h.check(error["message"].startswith("device: ") and error["do"] == "device", "a device that there is none of is refused in words", error)
    client.answer_or_event(client.command("device", device="cpu"), "devices")
    after = client.frame(client.command("rotate", by=[0, 0]), lossless=True)
    h.check(after["picture"] == before["picture"], "back on the CPU the picture is the same, byte for byte")
    undo_across_devices(client, rows)


def undo_across_devices(client, rows):
    """A step that needs a GPU is no wall for undo on the CPU."""
    if len(rows) < 2:
        print("# no GPU: undo across devices is not tested")
        return
    client.answer_or_event(client.command("device", device=rows[1]["id"]), "devices")
    for scene in ({"render": {"mode": "isosurface"}}, {"technique": {"name": "mesh"}}, {"technique": {"name": "raycast"}}):
        client.frame(client.command("set", scene=scene), lossless=True)
    client.answer_or_event(client.command("device", device="cpu"), "devices")
    client.events.clear()
    for _ in range(3):
        client.frame(client.command("undo"), lossless=True)
        states = client.events_of("state")
        h.check(not client.events_of("error"), "undo goes past a technique of the GPU alone", client.events[-1:])
    h.check(states and states[-1]["scene"]["render"]["mode"] == "composite", "to what was before it", states[-1:])


def misuse(viewer, other):
    client = Socket(viewer)
    client.hello()
    client.frame()
    for text in ("", "{", "nonsense", "[1]", '{"do":"size","size":[NaN,10]}', '{"do":"size","size":[1e999,10]}', '{"do":"size","size":[100000,100000]}',
                 '{"do":"picture","size":[100000,100000]}', '{"do":"rotate","by":"left"}', '{"do":"rotate","by":[1,2],"x":1}', '{"do":["rotate"]}',
                 '{"do":"hello","size":{"w":1}}', '{"do":"open","path":"/etc/passwd"}', '{"do":"list","path":"\\u0000"}', '{"do":"dance"}', '{"do":""}', '{"do":"%s"}' % ("x" * 100000), '{"do":"shutdown","now":true}',
                 '{"do":"slices","at":[0,0,0],"size":[100000,100000]}',
                 '{"do":"movie","size":[100000,100000],"frames":2,"degrees":1}', '{"do":"set","scene":{"render":{"step":"1e999"}}}', "[" * 5000, '{"a":' * 5000):
        client.text(text)
        event = client.event("error")
        h.check(0 < len(event["message"]) < 600 and "\n" not in event["message"], "refused in words: %.40s" % text, event)
    still_fine(viewer, client, "and the client goes on after all of these")
    client.text(b'{"do":"rotate","by":[0,0]}\xff\xfe')
    h.check(client.closed(), "text that is no UTF-8 closes the socket")
    for name, act in (("an oversized message", lambda c: c.send_frame(b" " * (1 << 20) + b"x")),
                      ("a message that claims 2^40 bytes", lambda c: c.send_frame(b"x" * 4096, length=1 << 40)),
                      ("a binary message", lambda c: c.send_frame(b"\0\1\2", code=2)),
                      ("an unknown opcode", lambda c: c.send_frame(b"x", code=7))):
        client = Socket(viewer)
        client.hello()
        client.frame()
        try:
            act(client)
            if "2^40" in name:
                for _ in range(600):
                    client.plain.sendall(b" " * 4096)
        except OSError:
            pass
        h.check(client.closed(), name + " closes the socket")
    still_fine(viewer, other, "the other client is undisturbed")


def floods(viewer, other):
    client = Socket(viewer)
    client.hello()
    client.frame()
    try:
        for i in range(200):
            client.plain.sendall(b"".join(bytes([0x81, 0x80 | len(t)]) + b"\0\0\0\0" + t for t in [b'{"do":"rotate","by":[0.001,0],"gesture":1}'] * 100))
    except OSError:
        pass
    h.check(client.closed(), "20000 commands at once close the socket")
    still_fine(viewer, other, "a flood disturbs nobody else")
    client = Socket(viewer)
    client.hello()
    client.frame()
    try:
        for i in range(100):
            client.text(b'{"do":"import","text":"' + b" " * 1000000 + b'"}')
    except OSError:
        pass
    h.check(client.closed(), "so do 100 MB of them")
    still_fine(viewer, other, "that disturbs nobody else, either")
    # Asks and asks, and reads nothing: what is kept for it has a bound.
    client = Socket(viewer, shows=False)
    client.hello()
    before = viewer.memory()
    try:
        for i in range(2500):
            client.command("scene" if i % 2 else "list")
            if i % 100 == 0:
                time.sleep(0.1)
    except OSError:
        pass
    still_fine(viewer, other, "a client that does not read disturbs nobody else")
    h.check(viewer.memory() - before < 100e6 + KEPT, "and takes no memory without bound", viewer.memory() - before)
    client.kill()


def opened(client, path):
    """The event that tells of it, or the error. (A volume is told of a second time, with its histogram.)"""
    client.command("open", path=path)
    return client.until(lambda m: m.get("event") == "error" or (m.get("event") == "volume" and m["path"] == path))


def paths(viewer, client, folder):
    """Nothing outside of what the command line named is listed or opened, by whatever way."""
    secret = h.write(folder / "secret.raw", b"s" * 24)
    inside = folder / "inside"
    join = os.path.join
    os.symlink(folder.path, join(inside, "out"))
    os.symlink(secret, join(inside, "link.raw"))
    for name, data in (("leak.nhdr", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\ndata file: %s\n"),
                       ("list.nhdr", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\ndata file: LIST\n%s\n"),
                       ("leak.mhd", "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\nElementDataFile = %s\n"),
                       ("leak.json", '{"volume": {"path": "%s", "raw": "4x3x2:u8"}}')):
        h.write(join(inside, name), data % secret)
        h.write(join(inside, "up-" + name), data % "../secret.raw")
        status, _, body = viewer.request("POST", "/%s/upload?name=%s" % (viewer.token, name), body=(data % secret).encode())
        for path in (join(inside, name), join(inside, "up-" + name), json.loads(body)["path"]):
            client.command("open", path=path)
            event = client.until(lambda m: m.get("event") == "volume" or m.get("event") == "error")
            h.check(event["event"] == "error" and "opened" in event["message"], "what %s names elsewhere stays closed" % name, event)
    h.write(join(inside, "good.nhdr"), "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\ndata file: good.raw\n")
    h.write(join(inside, "good.raw"), bytes(range(24)))
    event = opened(client, join(inside, "good.nhdr"))
    h.check(event.get("range") == [0, 23], "data beside their header are read", event)
    for path in ("/", "/etc", folder.path, join(inside, ".."), join(inside, "out"), inside + "/../inside/../", join(inside, "link.raw"), folder / "inside2",
                 secret, "~"):
        for do in ("list", "open"):
            error = client.answer(client.command(do, path=path), "files")
            h.check(error["event"] == "error", "no %s of %s" % (do, path[-12:]), error)
    files = client.answer(client.command("list", path=inside), "files")
    names = [entry["name"] for entry in files["entries"]]
    h.check("good.nhdr" in names and "passwd" not in str(files), "the named folder is listed", files)
    h.check("good.raw" not in names, "raw samples, that their header opens, are left out", names)


def series(client, inside):
    """A folder of slices below a named one is told as such, and opened as a whole."""
    slices = os.path.join(inside, "slices")
    os.mkdir(slices)
    for i in range(3):
        tags = ((256, 4), (257, 3), (258, 8), (259, 1), (262, 1), (273, 8), (277, 1), (278, 3), (279, 12))
        data = b"II*\0" + struct.pack("<I", 20) + bytes(range(i, i + 12)) + struct.pack("<H", len(tags))
        h.write(os.path.join(slices, "%d.tif" % i), data + b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags) + bytes(4))
    entries = client.answer(client.command("list", path=inside), "files")["entries"]
    h.check([entry["path"] for entry in entries if entry["series"]] == [slices], "the folder of slices is told", entries)
    listed = client.answer(client.command("list", path=slices), "files")
    h.check(listed["series"] is True, "likewise where it is listed itself", listed)
    h.check(opened(client, slices).get("dims") == [4, 3, 3], "and is opened as a volume", client.events[-1])


def half_open(viewer, other):
    sockets = [socket.create_connection((viewer.host, viewer.port)) for _ in range(60)]
    for i, plain in enumerate(sockets):
        if i % 3 == 1:
            plain.sendall(b"GET /%s/socket HTT" % viewer.token.encode())
        elif i % 3 == 2:
            plain.sendall(b"POST /%s/upload?name=a.nrrd HTTP/1.1\r\nHost: %s\r\nContent-Length: 100000\r\n\r\nabc" % (viewer.token.encode(), viewer.authority.encode()))
    still_fine(viewer, other, "60 half-open sockets disturb nobody")
    h.check(viewer.get("main.js")[0] == 200, "and the page is served")
    for plain in sockets:
        plain.close()


def killed(viewer, other):
    still_fine(viewer, other, "before clients are killed")
    time.sleep(1)
    files, threads = viewer.counts()
    memory = viewer.memory()
    for i in range(30):
        client = Socket(viewer, shows=i % 2)
        client.hello((512 + i, 512))
        client.command("hold")
        client.command("rotate", by=[0.1, 0], gesture=1)
        if i % 3:
            client.plain.recv(1000 * (i % 3))
        client.kill()
    number = other.command("size", size=[96, 64])
    other.frame(number, lossless=True)
    still_fine(viewer, other, "30 clients killed in the midst of frames disturb nobody")
    for _ in range(100):
        other.events.clear()
        still_fine(viewer, other, "a lossless picture is for who is at rest")
        if not other.events_of("state")[-1]["held"]:
            break
        time.sleep(0.1)
    h.check(not other.events_of("state")[-1]["held"], "and their holds are released")
    for _ in range(100):
        now = viewer.counts()
        if now[0] <= files and now[1] <= threads:
            break
        time.sleep(0.1)
    h.check(now[0] <= files and now[1] <= threads, "no file and no thread is left behind", ((files, threads), now))
    h.check(viewer.memory() - memory < 64e6 + KEPT, "nor memory", viewer.memory() - memory)


CHILD = """
import sys
sys.path.insert(0, sys.argv[1])
from websocket import Socket
class Where:
    host, port, authority, token = sys.argv[2], int(sys.argv[3]), sys.argv[2] + ":" + sys.argv[3], sys.argv[4]
client = Socket(Where)
client.hello((700, 700))
client.command("hold")
while True:
    number = client.command("rotate", by=[0.01, 0], gesture=1)
    client.frame(number)
    print("frame", flush=True)
"""


def killed_processes(viewer, other):
    """As kill -9 does it, while frames flow: the kernel closes what the process had open, with frames on their way."""
    for i in range(4):
        child = subprocess.Popen([sys.executable, "-c", CHILD, os.path.dirname(os.path.abspath(__file__)), viewer.host, str(viewer.port), viewer.token],
                                 stdout=subprocess.PIPE)
        for _ in range(3 + i):
            h.check(child.stdout.readline() == b"frame\n", "a process gets frames")
        child.kill()
        child.wait()
        child.stdout.close()
    other.command("size", size=[96, 64])
    still_fine(viewer, other, "killed processes disturb nobody, and hold nothing")


def listening(volume):
    """Only where it was told to."""
    def reaches(host, port):
        try:
            socket.create_connection((host, port), timeout=5).close()
        except OSError:
            return False
        return True

    with Viewer(h.TOOL, volume) as viewer:
        h.check(viewer.address.startswith("http://127.0.0.1:") and reaches("127.0.0.1", viewer.port), "127.0.0.1 unless told", viewer.address)
        h.check(not reaches("127.0.0.2", viewer.port), "and no other address")
        h.fails("a port that is taken", 1, "cannot listen", "view", volume, "--no-open", "--port", str(viewer.port))
        h.check(viewer.stop(signal.SIGTERM) == 0 and viewer.error == "", "SIGTERM ends it", (viewer.status, viewer.error))
    with Viewer(h.TOOL, volume, "--listen", "127.0.0.2") as viewer:
        h.check(viewer.address.startswith("http://127.0.0.2:") and viewer.get()[0] == 200, "another address, if told", viewer.address)
        h.check(not reaches("127.0.0.1", viewer.port), "and that one alone")
        h.check(viewer.get(headers={"Host": "127.0.0.1:%d" % viewer.port})[0] == 403, "by its own name")


def browser(volume, folder):
    """The browser is led by a file, for anybody on the machine can read a command line."""
    tools = folder / "tools"
    os.mkdir(tools)
    told = folder / "told"
    h.write(os.path.join(tools, "xdg-open"), '#!/bin/sh\nstat -c %%a "$1" > %s.new\necho "$1" >> %s.new\ncat "$1" >> %s.new\nmv %s.new %s\n' % ((told,) * 5))
    os.chmod(os.path.join(tools, "xdg-open"), 0o700)
    env = dict(os.environ, PATH=tools + ":" + os.environ["PATH"], TMPDIR=tools, XDG_RUNTIME_DIR="", HOME=folder.path)
    with Viewer(h.TOOL, volume, "--open", env=env) as viewer:
        for _ in range(300):
            if os.path.exists(told):
                break
            time.sleep(0.1)
        mode, page, text = h.read(told).decode().split("\n", 2)
        h.check(mode == "600" and viewer.token not in page and viewer.address in text, "the browser is led to the page", (mode, page, text))
        h.check(viewer.stop() == 0 and not os.path.exists(page), "and the file that led it is removed", viewer.error)


def refused(folder, told, *args):
    """Runs it with a browser that leaves a trace in `told`."""
    tools = folder / "none"
    os.mkdir(tools)
    h.write(os.path.join(tools, "xdg-open"), "#!/bin/sh\ntouch '%s'\n" % told)
    os.chmod(os.path.join(tools, "xdg-open"), 0o755)
    env = dict(os.environ, PATH="%s:%s" % (tools, os.environ["PATH"]))
    return subprocess.run([h.TOOL, *map(str, args)], stdin=subprocess.DEVNULL, capture_output=True, timeout=120, env=env)


def cut_short(volume, folder):
    """A recording that cannot be written to its end is told of."""
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    with Viewer(h.TOOL, volume, "--record", folder / "cut.jsonl", preexec_fn=limit, restore_signals=False) as viewer:
        client = Socket(viewer)
        client.hello()
        for i in range(100):
            client.command("rotate", by=[0.01, 0])
        client.frame(client.last_id, lossless=True)
        h.check(viewer.stop() == 1 and "could not be written to its end" in viewer.error, "a recording cut short is told of", (viewer.status, viewer.error))


with h.Folder() as folder:
    os.mkdir(folder / "inside")
    os.mkdir(folder / "inside2")
    volume = folder / "small.nrrd"
    h.fine("a volume to view", "make", "marschner-lobb", "--size", "24", "-o", volume)
    record = folder / "session.jsonl"
    with Viewer(h.TOOL, volume, folder / "inside", "--record", record) as viewer:
        silent = socket.create_connection((viewer.host, viewer.port))
        page(viewer)
        refusals(viewer)
        a, b = session(viewer)
        devices(viewer, b)
        misuse(viewer, b)
        floods(viewer, b)
        half_open(viewer, b)
        killed(viewer, b)
        killed_processes(viewer, b)
        paths(viewer, b, folder)
        series(b, os.path.join(folder.path, "inside"))
        still_fine(viewer, b, "at the end, too")
        silent.settimeout(60)
        h.check(silent.recv(1) == b"", "who says nothing is shown out")
        h.check(viewer.stop(signal.SIGINT) == 0, "Ctrl-C ends it", viewer.error)
        h.check(viewer.error == "", "without a word", viewer.error)

    with Viewer(h.TOOL, folder.path) as viewer:
        client = Socket(viewer)
        h.check(client.answer(client.hello(), "hello")["empty"] is True, "a folder without slices is there to choose from")
        h.check(str(volume) in str(client.answer(client.command("list", path=folder.path), "files")), "it lists its files")
        h.check(opened(client, str(volume)).get("dims") == [24, 24, 24], "and opens them")
        client.frame(lossless=True)
        h.check(viewer.stop() == 0 and "no DICOM or TIFF" in viewer.error and "choose" in viewer.error, "it says so", viewer.error)

    listening(volume)
    browser(volume, folder)
    cut_short(volume, folder)

    short = folder / "short.jsonl"
    with Viewer(h.TOOL, volume, folder / "inside", "--isovalue", "0.5", "--record", short) as viewer:
        client = Socket(viewer)
        client.hello()
        client.frame(lossless=True)
        other = Socket(viewer)
        other.hello((80, 80))
        for i in range(10):
            client.command("rotate", by=[0.02, 0.01], gesture=1)
            other.command("zoom", by=1.01, gesture=2)
        client.answer(client.command("probe", at=[0.5, 0.5]), "probe")
        client.command("set", scene={"isosurfaces": [{"value": 0.4, "color": [1, 0.2, 0.1]}, {"value": 0.6}]})
        client.command("slices", at=[0, 0, 0])
        client.command("set", scene={"render": {"refine": 3}})
        client.command("undo")
        client.command("size", size=[90, 70])
        for i in range(70):
            page = Socket(viewer)
            page.hello((90, 70))
            page.frame()
            page.close()
        good = os.path.join(folder / "inside", "good.nhdr")
        h.check(opened(client, good).get("path") == good, "a file is opened")
        client.command("open", path="/etc/passwd")
        client.event("error")
        number = client.command("roll", by=20)
        picture = client.frame(number, lossless=True)["picture"]
    for way in ([], ["--fast"]):
        out = folder / "again.png"
        h.fine("replay " + " ".join(way), "replay", short, "--picture", out, *way)
        h.check(h.read(out) == picture, "gives the same last picture, byte for byte")
    os.rename(os.path.join(folder / "inside", "good.nhdr"), folder / "good.nhdr")
    h.fails("a replay whose file is gone", 1, "1 error that the recording did not have", "replay", short, "--fast")
    h.fails("a file that is no recording", 1, "no recording", "replay", h.write(folder / "no.jsonl", "{}\n"))
    h.fails("a recording that is not there", 1, "No such file", "replay", folder / "gone.jsonl")

    h.fails("a file that is not there", 1, "No such file", "view", folder / "gone.nrrd", "--no-open")
    bad = os.path.join(os.fsencode(folder.path), b"\xff.nrrd")
    os.symlink(os.fsencode(volume), bad)
    h.fails("a name that is no text", 2, "rename it", "view", os.fsdecode(bad), "--no-open")
    h.fails("a file that is no volume", 1, "", "view", h.write(folder / "bad.nrrd", "NRRD0004\nnonsense\n"), "--no-open")
    os.mkfifo(folder / "pipe.nrrd")
    h.fails("a pipe", 1, "neither a file nor a folder", "view", folder / "pipe.nrrd", "--no-open")
    out = refused(folder, folder / "led", "view", folder / "bad.nrrd")
    h.check(out.returncode == 1 and out.stdout == b"" and b"bad.nrrd" in out.stderr and not os.path.exists(folder / "led"),
            "the error of a file comes before an address, and in place of a browser", out)
    h.fails("no file", 2, "a file name is missing", "view", "--no-open")
    h.fails("a port that is none", 2, "--port", "view", volume, "--no-open", "--port", "70000")
    h.fails("an address that is not this machine's", 1, "cannot listen", "view", volume, "--no-open", "--listen", "192.0.2.1")
h.finish()
