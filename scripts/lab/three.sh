#!/usr/bin/env bash
# Packs what the page of a rod in space needs of three.js into scripts/tendril/web/three, one file with the
# global THREE. Needs npm.
#   scripts/lab/three.sh [VERSION OF three]
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

version=${1:-0.187.0}
here=$root/scripts/tendril/web/three
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place"
npm init -y >/dev/null
npm install --silent "three@$version" esbuild@0.28.2
cat >pack.js <<'END'
export { BufferAttribute, BufferGeometry, ColorManagement, DirectionalLight, DoubleSide, Group, HemisphereLight, Line,
  LineBasicMaterial, LineSegments, LinearSRGBColorSpace, Mesh, MeshBasicMaterial, MeshLambertMaterial, PerspectiveCamera,
  Scene, Vector3, WebGLRenderer } from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
END
npx esbuild pack.js --bundle --minify --format=iife --global-name=THREE --legal-comments=none \
  --outfile="$here/three.min.js"
cp node_modules/three/LICENSE "$here/LICENSE"
