#!/usr/bin/env bash
# A recording read by Foxglove's own readers from npm, in a folder that is gone afterwards: needs node and the network.
#
#   tests/foxglove.sh run.mcap
set -euo pipefail

if [[ $# != 1 || ! -f ${1:-} ]]; then
  printf 'usage: %s FILE.mcap (c3rt run and c3rt record leave them)\n' "$0" >&2
  exit 2
fi
command -v npm >/dev/null || { printf 'c3rt: error: npm is not there (Debian: npm)\n' >&2; exit 2; }
recording=$(readlink -f "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
printf '{"private": true}\n' >package.json
npm install --silent --no-audit --no-fund @mcap/core@2.2.2 @foxglove/omgidl-parser@1.1.0 \
  @foxglove/omgidl-serialization@1.0.3 @foxglove/wasm-zstd@1.0.1

cat >read.js <<'JS'
const fs = require("fs");
const {McapIndexedReader} = require("@mcap/core");
const {parseIDL} = require("@foxglove/omgidl-parser");
const {MessageReader} = require("@foxglove/omgidl-serialization");
const zstd = require("@foxglove/wasm-zstd");

(async () => {
  await zstd.isLoaded;
  const file = fs.readFileSync(process.argv[2]);
  const readable = {
    size: async () => BigInt(file.length),
    read: async (offset, size) => new Uint8Array(file.buffer, file.byteOffset + Number(offset), Number(size)),
  };
  const reader = await McapIndexedReader.Initialize({
    readable, decompressHandlers: {zstd: (bytes, size) => zstd.decompress(bytes, Number(size))},
  });
  const types = new Map(), counts = {};
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (!types.has(schema.name))
      types.set(schema.name, new MessageReader(schema.name, parseIDL(new TextDecoder().decode(schema.data))));
    const sample = types.get(schema.name).readMessage(message.data);
    if (sample.header.time_ns !== message.publishTime || Number(sample.header.seq) !== message.sequence)
      throw new Error(`${channel.topic} ${message.sequence}: another sample was read`);
    counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  }
  if (Object.keys(counts).length === 0) throw new Error("no messages");
  console.log(counts);
})();
JS
node read.js "$recording"
