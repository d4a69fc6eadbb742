# SPDX-License-Identifier: MIT
"""The shipped viewer as a child, and a WebSocket client (RFC 6455) of the standard library alone, which can misbehave on purpose."""
import base64
import http.client
import json
import os
import signal
import socket
import struct
import subprocess
import time


class Viewer:
    """`pellucid view` with these arguments; with Viewer(tool, file) as v: v.address."""

    def __init__(self, tool, *args, **more):
        self.process = subprocess.Popen([tool, "view", "--no-open", "--port", "0", *map(str, args)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, **more)
        self.address = self.process.stdout.readline().decode().strip()
        self.status = None
        if self.address:
            self.authority, self.token = self.address.split("/")[2:4]
            self.host, port = self.authority.split(":")
            self.port = int(port)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()

    def stop(self, number=signal.SIGTERM):
        if self.status is None:
            self.process.send_signal(number)
            try:
                self.process.wait(60)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
            self.error = self.process.stderr.read().decode("utf-8", "replace")
            self.process.stdout.close()
            self.process.stderr.close()
            self.status = self.process.returncode
        return self.status

    def request(self, method, path, body=None, headers=None, timeout=30):
        """Status, headers, body; `path` with its token."""
        connection = http.client.HTTPConnection(self.host, self.port, timeout=timeout)
        try:
            connection.request(method, path, body=body, headers=headers or {})
            answer = connection.getresponse()
            return answer.status, dict((k.lower(), v) for k, v in answer.getheaders()), answer.read()
        finally:
            connection.close()

    def get(self, name="", **more):
        return self.request("GET", "/%s/%s" % (self.token, name), **more)

    def alive(self):
        return self.process.poll() is None

    def counts(self):
        """Open files and threads of the process."""
        base = "/proc/%d/" % self.process.pid
        return len(os.listdir(base + "fd")), len(os.listdir(base + "task"))

    def memory(self):
        """Resident bytes."""
        with open("/proc/%d/statm" % self.process.pid) as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


class Closed(Exception):
    pass


class Socket:
    """A client. `shows`: it tells at once that it has shown a frame."""

    def __init__(self, viewer, token=None, host=None, origin="", protocol="pellucid-1", shows=True, timeout=60):
        self.plain = socket.create_connection((viewer.host, viewer.port), timeout=timeout)
        self.file = self.plain.makefile("rb")
        self.shows = shows
        self.last_id = 0
        self.deadline = float("inf")
        self.frames, self.events = [], []
        host = host or viewer.authority
        lines = ["GET /%s/socket HTTP/1.1" % (viewer.token if token is None else token), "Host: " + host, "Upgrade: websocket", "Connection: Upgrade",
                 "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode()]
        if origin is not None:
            lines.append("Origin: " + (origin or "http://" + host))
        if protocol:
            lines.append("Sec-WebSocket-Protocol: " + protocol)
        self.plain.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        words = self.file.readline().split()
        self.status = int(words[1]) if len(words) > 1 else 0
        while self.file.readline().strip():
            pass

    def send_frame(self, data, code=1, mask=True, length=None):
        size = len(data) if length is None else length
        head = bytes([0x80 | code])
        bit = 0x80 if mask else 0
        if size < 126:
            head += bytes([bit | size])
        elif size < 65536:
            head += struct.pack(">BH", bit | 126, size)
        else:
            head += struct.pack(">BQ", bit | 127, size)
        # A mask of zeros is a mask, and leaves the bytes as they are.
        self.plain.sendall(head + (b"\0\0\0\0" if mask else b"") + data)

    def text(self, text):
        self.send_frame(text if isinstance(text, bytes) else text.encode())

    def command(self, do, **keys):
        """Sends a command with the next id; gives the id."""
        self.last_id += 1
        self.text(json.dumps({"do": do, "id": self.last_id, **keys}))
        return self.last_id

    def _exactly(self, count):
        data = self.file.read(count)
        if len(data) < count:
            raise Closed
        return data

    def receive(self):
        """The next event, or frame as {"header", "picture"}."""
        message = b""
        kind = 0
        while True:
            first, second = self._exactly(2)
            size = second & 127
            if size > 125:
                size = struct.unpack(">H" if size == 126 else ">Q", self._exactly(2 if size == 126 else 8))[0]
            data = self._exactly(size)
            code = first & 15
            if code == 8:
                self.close_code = struct.unpack(">H", data[:2])[0] if len(data) > 1 else 0
                raise Closed
            if code == 9:
                self.send_frame(data, 10)
                if time.monotonic() > self.deadline:
                    raise TimeoutError("what was waited for never came")
                continue
            kind = code or kind
            message += data
            if first & 0x80:
                break
        if kind == 1:
            event = json.loads(message)
            self.events.append(event)
            return event
        length = struct.unpack("<I", message[:4])[0]
        frame = {"header": json.loads(message[4:4 + length]), "picture": message[4 + length:], "time": time.monotonic()}
        self.frames.append(frame["header"])
        if self.shows:
            self.text(json.dumps({"do": "shown", "frame": frame["header"]["frame"]}))
        return frame

    def until(self, wanted):
        """The first message that `wanted` is true of."""
        self.deadline = time.monotonic() + 240
        while True:
            message = self.receive()
            if wanted(message):
                self.deadline = float("inf")
                return message

    def event(self, kind):
        return self.until(lambda m: m.get("event") == kind)

    def answer(self, number, kind):
        """The event of that kind, or the error, that answers a command."""
        return self.until(lambda m: m.get("id") == number and m.get("event") in (kind, "error"))

    def answer_or_event(self, number, kind):
        """The next event of that kind, to whomever, or the error that answers the command."""
        return self.until(lambda m: m.get("event") == kind or (m.get("id") == number and m.get("event") == "error"))

    def events_of(self, kind):
        return [event for event in self.events if event["event"] == kind]

    def frame(self, number=0, lossless=False, view="main"):
        """The next frame that shows a command."""
        return self.until(lambda m: "header" in m and m["header"]["view"] == view and m["header"]["id"] >= number and (m["header"]["lossless"] or not lossless))

    def hello(self, size=(96, 64)):
        return self.command("hello", size=list(size))

    def closed(self, seconds=30):
        """Does the server close it within that time?"""
        self.plain.settimeout(seconds)
        try:
            while True:
                self.receive()
        except Closed:
            return True
        except ConnectionError:
            return True
        except TimeoutError:
            return False

    def kill(self):
        """Gone at once, with a reset and no goodbye."""
        self.plain.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.close()

    def close(self):
        self.file.close()
        self.plain.close()
