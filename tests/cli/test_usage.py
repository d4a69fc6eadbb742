# SPDX-License-Identifier: MIT
"""The words of the tool: help, version, bad usage, completions, the manual page, docs/options.md."""
import os
import shutil
import subprocess

from harness import DATA, SOURCE, TOOL, Folder, check, fails, fine, finish, read, run, skip, write

COMMANDS = ["info", "render", "convert", "compare", "make", "bench", "techniques", "devices", "formats", "options", "completion", "man"]

overview = run()
check(overview.status == 2 and not overview.out and "Commands:" in overview.err, "no command: the overview on stderr, status 2", overview)
overview = run("--help")
check(overview.status == 0 and all("\n  %s " % c in overview.text for c in COMMANDS), "--help names every command", overview)
version = run("--version")
check(version.status == 0 and version.text.startswith("pellucid ") and version.text.count(".") == 2, "--version", version)
fails("an unknown command is refused", 2, "did you mean render", "rendr")
fails("a word that is near no command", 2, "see pellucid --help", "xyzzyplugh")
for command in COMMANDS:
    text = run(command, "--help")
    check(text.status == 0 and text.text.startswith("Usage: pellucid " + command) and not text.err, command + " --help", text)
    check(run("help", command).text == text.text, "help " + command)

USAGE = [  # what is asked, a word of the answer
    (["render", "--colurmap", "x"], "did you mean --colormap"),
    (["render", "--xyzzyplugh"], "see pellucid render --help"),
    (["render", "--iso", "3"], "could be"),
    (["render", "--size"], "needs a value"),
    (["render", "-o"], "needs a value"),
    (["render", "-Z"], "-Z"),
    (["render", "--no-shade=1", "x"], "takes no value"),
    (["render", "--shade=perhaps", "x"], "--shade"),
    (["render", "x"], "-o"),
    (["render", "-o", "a.png"], "missing"),
    (["render", "x", "y", "-o", "a.png"], "too many"),
    (["render", "x", "-o", "a.jpg"], ".png"),
    (["render", "x", "-o", "a"], ".png"),
    (["render", "x", "--depth", "a.png"], ".nrrd"),
    (["render", "x", "-o", "a.png", "--device", "tpu"], "say auto, cpu, gpu"),
    (["render", "x", "-o", "a.png", "--device", "gpu:x"], "say auto, cpu, gpu"),
    (["render", "x", "-o", "a.png", "--device", "gpu", "--technique", "reference"], "CPU alone"),
    (["render", "x", "-o", "a.png", "--technique", "magic"], "raycast"),
    (["render", "x", "-o", "a.png", "--mode", "magic"], "--mode"),
    (["render", "x", "-o", "-", "--turntable", "3"], "--turntable"),
    (["render", "x", "-o", "a.png", "--isovalue", "1,nan"], "--isovalue"),
    (["render", "x", "-o", "a.png", "--isovalue", "1,,2"], "--isovalue"),
    (["render", "x", "-o", "a.png", "--isovalue", ",".join(map(str, range(17)))], "at most"),
    (["render", "x", "-o", "a.png", "--isovalue", "1", "--mode", "mip"], "--isovalue"),
    (["render", "x", "-o", "a.png", "--isovalue", "1", "--slice", "0,0,0,0,0,1"], "--slice"),
    (["render", "x", "-o", "a.png", "--slice", "0,0,0,0,0,0"], "--slice"),
    (["render", "x", "-o", "a.png", "--light", "0,0,0"], "--light"),
    (["render", "x", "-o", "a.png", "--light-color", "red"], "--light-color"),
    (["render", "x", "-o", "a.png", "--clip-plane", "0,0,0,0,0,0"], "--clip-plane"),
    (["render", "x", "-o", "a.png", "--clip-box", "1,0,0,1,0,1"], "--clip-box"),
    (["render", "x", "-o", "a.png", "--range", "3,3"], "--range"),
    (["render", "x", "-o", "a.png", "--step", "nan"], "--step"),
    (["render", "x", "-o", "a.png", "--step", "0"], "--step"),
    (["render", "x", "-o", "a.png", "--step", "-1"], "--step"),
    (["render", "x", "-o", "a.png", "--azimuth", "inf"], "--azimuth"),
    (["render", "x", "-o", "a.png", "--size", "0x5"], "--size"),
    (["render", "x", "-o", "a.png", "--size", "99999999999"], "--size"),
    (["render", "x", "-o", "a.png", "--size", "-5x5"], "--size"),
    (["render", "x", "-o", "a.png", "--threads", "-1"], "--threads"),
    (["render", "x", "-o", "a.png", "--background", "mauveish"], "--background"),
    (["info"], "missing"),
    (["info", "a", "b"], "too many"),
    (["convert", "a"], "missing"),
    (["compare", "a"], "missing"),
    (["compare", "a", "b", "--psnr-min", "nan"], "--psnr-min"),
    (["make"], "--list"),
    (["make", "hydrgen"], "did you mean hydrogen"),
    (["make", "hydrogen"], "-o"),
    (["make", "hydrogen", "--size", "0", "-o", "a.nrrd"], "--size"),
    (["make", "hydrogen", "extra", "-o", "a.nrrd"], "too many"),
    (["bench"], "missing"),
    (["completion"], "missing"),
    (["completion", "tcsh"], "bash"),
    (["techniques", "x"], "too many"),
]
with Folder() as folder:
    for words, fragment in USAGE:
        fails("refused: " + " ".join(words)[:70], 2, fragment, *words, cwd=folder.path)
    seven = sum((["--clip-plane", "0,0,0,0,0,1"] for _ in range(7)), [])
    fails("refused: seven clip planes", 2, "at most", "render", "x", "-o", "a.png", *seven, cwd=folder.path)
    fails("refused: five lights", 2, "at most", "render", "x", "-o", "a.png", *["--light=0,0,1"] * 5, cwd=folder.path)
    fails("refused: a text of 5000 bytes", 2, "longer", "render", "x", "-o", "a" * 5000 + ".png", cwd=folder.path)
    fails("a name with a newline stays on one line", 1, "?", "info", "no\nsuch\033file", cwd=folder.path)
    check(folder.names() == [], "nothing was written", folder.names())

# Forms of a flag.
with Folder() as folder:
    fine("make", "make", "sphere", "--size=12", "-o", folder / "v.nrrd")
    base = ["render", folder / "v.nrrd", "--size", "16x8"]
    pictures = {}
    for name, words in {"on": ["--jitter"], "on=": ["--jitter=on"], "off": ["--no-jitter"], "off=": ["--jitter=off"], "none": [],
                        "last": ["--jitter", "--no-jitter"]}.items():
        fine("form " + name, *base, "-o", folder / "a.png", "--step", "2", *words)
        pictures[name] = read(folder / "a.png")
    check(pictures["on"] == pictures["on="] and pictures["off"] == pictures["off="] == pictures["none"] == pictures["last"], "forms of a switch agree")
    fine("a negative value after a blank", *base, "-o", folder / "a.png", "--azimuth", "-30")
    fine("a name that begins with a dash, after --", "render", "-o", folder / "b.png", "--size=4", "--", folder / "v.nrrd")

# What is made from the tables.
page = run("man")
check(page.status == 0 and page.text.startswith(".TH PELLUCID 1"), "man", page)
if shutil.which("groff"):
    done = subprocess.run(["groff", "-man", "-ww", "-z"], input=page.out, capture_output=True)
    check(done.returncode == 0 and not done.stderr, "the manual page is good roff", done.stderr.decode())
else:
    skip("the manual page is good roff", "no groff here")
with Folder() as folder:
    script = write(folder / "c", run("completion", "bash").out)
    done = subprocess.run(["bash", "-c", 'source "$1"; complete_at() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); _pellucid; echo "${COMPREPLY[@]}"; };'
                           'complete_at pellucid re; complete_at pellucid render --mode mi; complete_at pellucid render --colorm; complete_at pellucid make hyd',
                           "bash", script], capture_output=True, cwd=folder.path)
    check(done.stdout.decode().split("\n")[:4] == ["render replay", "mip minip", "--colormap", "hydrogen"], "bash completes", done)
    for shell in ["zsh", "fish"]:
        script = write(folder / shell, run("completion", shell).out)
        check("--isovalue" in read(script).decode() or "-l isovalue" in read(script).decode(), shell + " completion knows the options")
        if shutil.which(shell):
            done = subprocess.run([shell, "-n", script], capture_output=True)
            check(done.returncode == 0, shell + " completion parses", done)
        else:
            skip(shell + " completion parses", "no %s here" % shell)

committed = os.path.join(SOURCE, "docs", "options.md")
check(os.path.exists(committed) and read(committed) == run("options").out, "docs/options.md is current (make it with: pellucid options > docs/options.md)")

# Streams that cannot be written to.
for words in [["--help"], ["--version"], ["render", "--help"], ["formats"], ["techniques", "--json"], ["make", "--list"], ["options"]]:
    with open("/dev/full", "wb") as full:
        result = run(*words, stdout=full)
    check(result.status == 1 and result.one_error(), "a full disk behind stdout is told: " + " ".join(words), result)
closed = subprocess.run(
    ["bash", "-c", '"$0" --version >&-', TOOL], capture_output=True)
check(closed.returncode == 1 and closed.stderr.startswith(b"pellucid: "), "a closed stdout is told", closed)
finish()
