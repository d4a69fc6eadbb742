# The front door. Every target installs what it needs (scripts/deps says what and why) and builds with Meson, which does the real work.
BUILD ?= build
PREFIX ?= /usr/local
DESTDIR ?=
DATA ?=
ARGS ?=
FUZZ_SECONDS ?= 600
BENCH_ARGS ?=
export DEBIAN_FRONTEND = noninteractive

.PHONY: help all demo check bench fuzz install bundle clean
.DEFAULT_GOAL := help

help: ## this list
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1\t\2/p' Makefile | expand -t 18

all: ## build the program (build/tools/pellucid) and the library
	@scripts/deps build
	@scripts/build "$(BUILD)"

demo: all ## pictures into demo/: a hydrogen orbital and a head; with DATA=path (and ARGS=options of render), of that file too
	@scripts/demo "$(BUILD)" $(if $(DATA),"$(DATA)" $(ARGS))

check: ## all tests, in a release build and in one with ASan and UBSan
	@scripts/deps build check
	@scripts/check "$(BUILD)" "$(BUILD)-asan"

bench: all ## measure this program beside VTK and VolPack; BENCH_ARGS=--quick for a short run
	@bench/deps
	@bench/run --build "$(BUILD)" $(BENCH_ARGS)

fuzz: ## run every fuzz target for FUZZ_SECONDS (600) each
	@scripts/deps build check fuzz
	@scripts/fuzz "$(BUILD)-fuzz" $(FUZZ_SECONDS)

install: all ## install under PREFIX (/usr/local), staged in DESTDIR
	@meson configure "$(BUILD)" --prefix "$(PREFIX)"
	@DESTDIR="$(DESTDIR)" meson install -C "$(BUILD)" --quiet
	@[ -n "$(DESTDIR)" ] || ldconfig 2>/dev/null || true

bundle: ## a folder and archive that run on another machine with nothing installed: build-bundle/pellucid.tar.gz
	@scripts/deps build
	@scripts/bundle "$(BUILD)-bundle" "$(BUILD)-bundle/pellucid"

clean: ## remove what the targets above made
	rm -rf "$(BUILD)" "$(BUILD)-asan" "$(BUILD)-fuzz" "$(BUILD)-bundle" demo bench/data
