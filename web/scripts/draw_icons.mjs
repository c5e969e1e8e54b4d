// Draws the icons: npm run icons. A house whose door speaks, white on the accent colour. The SVG and the PNGs come
// from the same figures; a PNG is sampled four by four times a pixel.
import { mkdirSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { crc32, deflateSync } from './png_parts.mjs';

const folder = join(dirname(fileURLToPath(import.meta.url)), '../static/icons');
const kGround = [11, 101, 97];
const kFigure = [255, 255, 255];
// In a square of side 100; what matters lies in the circle that masks leave (radius 40).
const kHouse = [[50, 21], [78, 46], [78, 76], [22, 76], [22, 46]];
const kDot = { x: 39, y: 59, r: 5 };
const kArcs = [{ r: 13 }, { r: 22 }, { r: 31 }]; // about the dot, to the right
const kStroke = 4.5;
const kArcHalfAngle = (38 / 180) * Math.PI;

function inside(polygon, x, y) {
  let odd = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i, i += 1) {
    const [xi, yi] = polygon[i];
    const [xj, yj] = polygon[j];
    if (yi > y !== yj > y && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) {
      odd = !odd;
    }
  }
  return odd;
}

function inVoice(x, y) {
  const [dx, dy] = [x - kDot.x, y - kDot.y];
  const distance = Math.hypot(dx, dy);
  return distance <= kDot.r || (Math.abs(Math.atan2(dy, dx)) <= kArcHalfAngle &&
    kArcs.some(({ r }) => Math.abs(distance - r) <= kStroke / 2));
}

const isFigure = (x, y) => inside(kHouse, x, y) && !inVoice(x, y);

function png(side) {
  const rows = Buffer.alloc(side * (1 + 3 * side));
  for (let v = 0; v < side; v += 1) {
    for (let u = 0; u < side; u += 1) {
      let hits = 0;
      for (let s = 0; s < 16; s += 1) {
        const x = ((u + ((s % 4) + 0.5) / 4) / side) * 100;
        const y = ((v + (Math.floor(s / 4) + 0.5) / 4) / side) * 100;
        hits += isFigure(x, y) ? 1 : 0;
      }
      for (let c = 0; c < 3; c += 1) {
        rows[v * (1 + 3 * side) + 1 + 3 * u + c] = Math.round(kGround[c] + ((kFigure[c] - kGround[c]) * hits) / 16);
      }
    }
  }
  const size = Buffer.alloc(13);
  size.writeUInt32BE(side, 0);
  size.writeUInt32BE(side, 4);
  size.set([8, 2, 0, 0, 0], 8); // 8 bits a channel, RGB
  return Buffer.concat([Buffer.from('\x89PNG\r\n\x1a\n', 'latin1'),
    chunk('IHDR', size), chunk('IDAT', deflateSync(rows, { level: 9 })), chunk('IEND', Buffer.alloc(0))]);
}

function chunk(name, data) {
  const body = Buffer.concat([Buffer.from(name, 'latin1'), data]);
  const framed = Buffer.alloc(body.length + 8);
  framed.writeUInt32BE(data.length, 0);
  body.copy(framed, 4);
  framed.writeUInt32BE(crc32(body), body.length + 4);
  return framed;
}

function svg() {
  const rgb = `#${kGround.map((value) => value.toString(16).padStart(2, '0')).join('')}`;
  const arcs = kArcs.map(({ r }) => {
    const [dx, dy] = [r * Math.cos(kArcHalfAngle), r * Math.sin(kArcHalfAngle)].map((value) => +value.toFixed(2));
    return `M${kDot.x + dx} ${kDot.y - dy}A${r} ${r} 0 0 1 ${kDot.x + dx} ${kDot.y + dy}`;
  }).join('');
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100"><rect width="100" height="100" rx="22" fill="${rgb}"/>` +
    `<clipPath id="house"><path d="M${kHouse.map((point) => point.join(' ')).join('L')}z"/></clipPath>` +
    `<path d="M${kHouse.map((point) => point.join(' ')).join('L')}z" fill="#fff"/>` +
    `<g clip-path="url(#house)"><circle cx="${kDot.x}" cy="${kDot.y}" r="${kDot.r}" fill="${rgb}"/>` +
    `<path d="${arcs}" fill="none" stroke="${rgb}" stroke-width="${kStroke}"/></g></svg>\n`;
}

mkdirSync(folder, { recursive: true });
writeFileSync(join(folder, 'icon.svg'), svg());
for (const side of [180, 192, 512]) {
  writeFileSync(join(folder, `icon-${side}.png`), png(side));
}
