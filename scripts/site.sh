#!/usr/bin/env bash
# Builds all pages as a site that can be searched, from the files as they are: results/site/index.html.
#   scripts/site.sh            results/site
#   scripts/site.sh DIRECTORY  elsewhere
# MkDocs is installed into an environment of its own, results/site-python, at the first time; that needs a network. A link
# that leads nowhere ends it. To search, open the site through a server: python3 -m http.server -d results/site
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

site=${1:-results/site}
[[ $site == /* || $# = 0 ]] || site=$started/$site
[[ $site == /* ]] || site=$root/$site
place=$root/results
log=$place/site.log
mkdir -p "$place"
: >"$log"

python=$place/site-python
if ! "$python/bin/python" -c 'import mkdocs' 2>/dev/null; then
  echo "site: installing MkDocs into results/site-python"
  logged "$log" "making results/site-python" python3 -m venv --clear "$python"
  logged "$log" "installing MkDocs" "$python/bin/python" -m pip install --disable-pip-version-check -q mkdocs==1.6.1
fi

# The pages, and what they link to, where they stand to each other as they do here.
pages=$place/site-pages
rm -rf "$pages"
mkdir -p "$pages"
git ls-files -co --exclude-standard -- '*.md' '*.png' '*.gif' '*.ipynb' 'docs/*.css' LICENSE CITATION.cff 'docs/*.csv' 'docs/*/*.csv' \
  'docs/*/*.opts' 'docs/*/*.txt' 'options/*.opts' tests/python/public_cases.py ':!scripts/tendril' |
  while read -r file; do
    [ -f "$file" ] || continue
    mkdir -p "$pages/$(dirname "$file")"
    cp "$file" "$pages/$file"
  done
TENDRIL_SITE_PAGES=$pages TENDRIL_SITE=$site logged "$log" "the site (a link that leads nowhere?)" \
  "$python/bin/python" -m mkdocs build --strict --config-file docs/mkdocs.yml
echo "site: $site/index.html"
