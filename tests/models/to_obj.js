// node to_obj.js IN OUT.obj: a 3DS file (3D Studio: chunks 4110 vertices, 4120 faces), or a module of npm that exports
// `positions` and `cells`.
'use strict';
const fs = require('fs');
const path = require('path');

function read3ds(data) {
  const positions = [], cells = [];
  let first = 0;
  const readChunks = (from, to) => {
    for (let at = from; at + 6 <= to;) {
      const id = data.readUInt16LE(at), end = at + data.readUInt32LE(at + 2);
      if (id === 0x4d4d || id === 0x3d3d || id === 0x4100) {
        readChunks(at + 6, end);
      } else if (id === 0x4000) {
        readChunks(data.indexOf(0, at + 6) + 1, end); // behind the object's name
      } else if (id === 0x4110) {
        first = positions.length;
        for (let i = 0; i < data.readUInt16LE(at + 6); ++i)
          positions.push([0, 4, 8].map((o) => data.readFloatLE(at + 8 + 12 * i + o)));
      } else if (id === 0x4120) {
        for (let i = 0; i < data.readUInt16LE(at + 6); ++i)
          cells.push([0, 2, 4].map((o) => first + data.readUInt16LE(at + 8 + 8 * i + o)));
      }
      at = end;
    }
  };
  readChunks(0, data.length);
  return {positions, cells};
}

const [input, output] = process.argv.slice(2);
const mesh = input.endsWith('.3ds') ? read3ds(fs.readFileSync(input)) : require(path.resolve(input));
const lines = mesh.positions.map((p) => 'v ' + p.join(' '));
lines.push(...mesh.cells.map((c) => 'f ' + c.map((v) => v + 1).join(' ')));
fs.writeFileSync(output, lines.join('\n') + '\n');
