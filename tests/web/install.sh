#!/bin/sh
# Installs the one package that the tests need (playwright-core, no browser) into a folder of the build, from the lock file. Does nothing
# where it is there already. Usage: install.sh SOURCE-FOLDER TARGET-FOLDER; exits with 1 and a reason where it cannot.
set -eu
source=$1 target=$2
if [ -d "$target/node_modules/playwright-core" ] && cmp -s "$source/package-lock.json" "$target/package-lock.json"; then
    exit 0
fi
mkdir -p "$target"
cp "$source/package.json" "$target/"
export PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1
rm -f "$target/package-lock.json"
cp "$source/package-lock.json" "$target/.lock"
if ! (cd "$target" && cp .lock package-lock.json && npm ci --no-audit --no-fund --fetch-retries 1 --fetch-timeout 20000 >npm.log 2>&1); then
    rm -f "$target/package-lock.json"
    echo "npm ci failed, see $target/npm.log: $(grep -m 1 'npm err' "$target/npm.log" || tail -n 1 "$target/npm.log")"
    exit 1
fi
