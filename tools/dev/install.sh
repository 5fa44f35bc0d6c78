#!/usr/bin/env bash
# Installs what building, testing and running cairn need: the Debian packages of packages.txt and the
# npm packages of the web report. Does nothing where all is there. Works as root and with sudo.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

installed() { dpkg-query -W -f='${db:Status-Status}\n' "$1" 2>/dev/null | grep -qx installed; }

missing=()
while read -r package; do
  case "$package" in '' | '#'*) continue ;; esac
  installed "$package" || missing+=("$package")
done <"$here/packages.txt"
# Any Node.js from 18 on serves; Debian's is taken where there is none.
command -v node >/dev/null || missing+=(nodejs)
command -v npm >/dev/null || missing+=(npm)

if [ ${#missing[@]} -gt 0 ]; then
  echo "install: ${#missing[@]} Debian packages: ${missing[*]}"
  as_root apt-get update -qq
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
else
  echo "install: all Debian packages are there"
fi

web=$root/lib/report/web
stamp=$web/node_modules/.cairn-lock
if [ -f "$web/package-lock.json" ] && ! cmp -s "$web/package-lock.json" "$stamp"; then
  echo "install: npm packages of the web report"
  npm ci --prefix "$web" --no-audit --no-fund --loglevel=error
  cp "$web/package-lock.json" "$stamp"
fi
