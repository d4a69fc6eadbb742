#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Drags on several clients of one viewer at once for a while, and tells what came of it: frames, their age, answers that never came, memory.

Usage: viewer_soak.py PELLUCID FILE [--clients 8] [--seconds 600] [--size 768x768] [--slow 0]

Each client holds and turns, sends a move for every frame that it gets (and at most 60 a second), asks for a probe now and then, lets go, and begins again.
`--slow N`: the last N of them take half a second to show a frame. A frame's age is how many newer ones of its view there were when it was sent."""
import argparse
import os
import statistics
import sys
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "tests", "cli"))
from websocket import Closed, Socket, Viewer  # noqa: E402


class Hand(threading.Thread):
    def __init__(self, viewer, size, number, until, slow):
        super().__init__(daemon=True)
        self.socket = Socket(viewer, shows=not slow)
        self.number, self.until, self.slow = number, until, slow
        self.ages, self.latency, self.asked, self.answered, self.sent = [], [], 0, 0, {}
        self.commands, self.trouble = 0, ""
        self.socket.hello(size)

    def send(self, do, **keys):
        number = self.socket.command(do, **keys)
        self.sent[number] = time.monotonic()
        self.commands += 1
        return number

    def take(self, message):
        """A frame or event; true for a frame of the main view."""
        if "header" not in message:
            self.answered += message.get("event") == "probe"
            if message.get("event") == "error":
                self.trouble = message["message"]
            return False
        header = message["header"]
        if self.slow:
            time.sleep(0.5)
            self.socket.text('{"do":"shown","frame":%d}' % header["frame"])
        del self.socket.frames[:], self.socket.events[:]
        self.ages.append(header["age"])
        for number in [k for k in self.sent if k <= header["id"]]:
            self.latency.append(message["time"] - self.sent.pop(number))
        return header["view"] == "main"

    def gesture(self, number):
        self.send("hold")
        for step in range(60):
            start = time.monotonic()
            self.send("rotate", by=[0.004 * (1 + self.number % 3), 0.002], gesture=number)
            while not self.take(self.socket.receive()):
                pass
            time.sleep(max(0, 1 / 60 - (time.monotonic() - start)))
        self.send("release")
        self.asked += 1
        self.send("probe", at=[0.5, 0.5])

    def run(self):
        try:
            while not self.take(self.socket.receive()):
                pass
            gesture = 1
            while time.monotonic() < self.until:
                self.gesture(gesture)
                gesture += 1
            while self.sent or self.answered < self.asked:
                self.take(self.socket.receive())
        except (Closed, OSError) as error:
            self.trouble = self.trouble or repr(error)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("pellucid")
    parser.add_argument("file")
    parser.add_argument("--clients", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--size", default="768x768")
    parser.add_argument("--slow", type=int, default=0)
    args = parser.parse_args()
    size = tuple(int(x) for x in args.size.split("x"))
    with Viewer(args.pellucid, args.file) as viewer:
        start = time.monotonic()
        hands = [Hand(viewer, size, i, start + args.seconds, i >= args.clients - args.slow) for i in range(args.clients)]
        for hand in hands:
            hand.start()
        while not all(hand.ages for hand in hands) and all(hand.is_alive() for hand in hands):
            time.sleep(0.05)
        begin = minute = viewer.memory()
        while any(hand.is_alive() for hand in hands) and time.monotonic() - start < args.seconds + 120:
            time.sleep(min(30, args.seconds / 10))
            files, threads = viewer.counts()
            if time.monotonic() - start <= 75:
                minute = viewer.memory()
            print("%6.0f s  %7.1f MB resident, %d files, %d threads, %d frames" %
                  (time.monotonic() - start, viewer.memory() / 1e6, files, threads, sum(len(h.ages) for h in hands)), flush=True)
        end = viewer.memory()
        lost = 0
        for hand in hands:
            lost += len(hand.sent) + hand.asked - hand.answered
            latency = sorted(hand.latency) or [0]
            print("client %d%s: %d commands, %d frames, oldest %d, latency median %.1f ms, 95th percentile %.1f ms%s" %
                  (hand.number, " (slow)" if hand.slow else "", hand.commands, len(hand.ages), max(hand.ages, default=0), 1e3 * statistics.median(latency),
                   1e3 * latency[len(latency) * 95 // 100], ", " + hand.trouble if hand.trouble else ""))
        print("memory: %.1f MB at the first pictures, %.1f after a minute, %.1f at the end" % (begin / 1e6, minute / 1e6, end / 1e6))
        print("lost answers: %d; oldest frame: %d frames" % (lost, max((max(h.ages, default=0) for h in hands), default=0)))
        return 1 if lost or viewer.stop() != 0 else 0


if __name__ == "__main__":
    sys.exit(main())
