#!/bin/sh
# Installs the one package that the tests need (playwright-core, no browser) into a folder of the build, from the lock file. Does nothing
# where it is there already. Usage: install.sh SOURCE-FOLDER TARGET-FOLDER; exits with 1 and a reason where it cannot.
set -eu
source=$1 target=$2
if [ -d "$target/node_modules/playwright-core" ] && cmp -s "$source/package-lock.json" "$target/package-lock.json"; then
    exit 0
fi
mkdir -p "$target"
cp "$source/package.json" "$source/package-lock.json" "$target/"
export PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1
if ! (cd "$target" && npm ci --no-audit --no-fund --fetch-retries 1 --fetch-timeout 20000 >npm.log 2>&1); then
    rm -f "$target/package-lock.json" # so that the next run tries again
    echo "npm ci failed: $(grep -i -m 1 'npm err' "$target/npm.log" || tail -n 1 "$target/npm.log")"
    exit 1
fi
